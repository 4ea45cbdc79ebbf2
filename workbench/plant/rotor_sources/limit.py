"""How many rotors are read: a bound on the time that a stranger's file can take."""

from pathlib import Path

from workbench.common.errors import WorkbenchError

MOST_ROTORS = 128


def refuse_crowd(file: Path, number: int) -> None:
    """Refuse more rotors than any multirotor has.

    Raises:
        WorkbenchError: for more than `MOST_ROTORS`.
    """
    if number > MOST_ROTORS:
        raise WorkbenchError(f"{file}: it declares {number} rotors: up to {MOST_ROTORS} are read")
