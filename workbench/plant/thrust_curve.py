"""A measured thrust curve, as motor makers print it: a table of speeds and thrusts."""

import csv
import math
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.data_sheet import Measured

COLUMNS = {
    "rpm": 2.0 * math.pi / 60.0,
    "rad/s": 1.0,
    "thrust_N": 1.0,
    "thrust_g": 0.001 * 9.80665,
    "torque_Nm": 1.0,
}
"""What a column's head may be, and the factor to the SI unit."""
_SPEEDS, _THRUSTS, _TORQUES = ("rpm", "rad/s"), ("thrust_N", "thrust_g"), ("torque_Nm",)


def read_thrust_curve(path: Path) -> Measured:
    """Return the constants that fit a CSV file of one motor with its propeller.

    Its first line names the columns: `rpm` or `rad/s`, `thrust_g` or `thrust_N`, and `torque_Nm`
    where it was measured; others are not read. Thrust is fitted by k w², torque by a factor of
    thrust, both with least squares.

    Raises:
        WorkbenchError: with file and line, for what is missing or no number.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.DictReader(stream, skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise WorkbenchError(f"{path}: cannot be read: {error}") from error
    speeds = _column(path, rows, _SPEEDS)
    thrusts = _column(path, rows, _THRUSTS)
    torques = _column(path, rows, _TORQUES) if rows and _head(rows[0], _TORQUES) else []
    squares = [speed**2 for speed in speeds]
    constant = sum(t * s for t, s in zip(thrusts, squares, strict=True)) / sum(
        s * s for s in squares
    )
    moment = (
        sum(q * t for q, t in zip(torques, thrusts, strict=True)) / sum(t * t for t in thrusts)
        if torques
        else None
    )
    source = f"least squares of the {len(rows)} points in {path.name}"
    return Measured(constant, max(speeds), moment, source)


def _head(row: dict[str, str], names: tuple[str, ...]) -> str | None:
    """Return which of some columns a table has."""
    return next((name for name in names if name in row), None)


def _column(path: Path, rows: list[dict[str, str]], names: tuple[str, ...]) -> list[float]:
    """Return a column [SI].

    Raises:
        WorkbenchError: if there is none, or one of its cells is no positive number.
    """
    head = _head(rows[0], names) if rows else None
    if head is None:
        raise WorkbenchError(
            f"{path}: has no column {' or '.join(names)}: its first line names them"
        )
    values = []
    for line, row in enumerate(rows, start=2):
        try:
            value = float(row[head] or "")
        except ValueError:
            value = math.nan
        if not 0.0 < value < 1e6:
            raise WorkbenchError(f"{path}:{line}: {head} '{row[head]}' is no positive number")
        values.append(COLUMNS[head] * value)
    return values
