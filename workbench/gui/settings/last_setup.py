"""The scenario that was set up by hand last, kept for the next start."""

from pathlib import Path

from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError
from workbench.scenario.scenario import Scenario, save_scenario

NAME = "last-flight.yaml"


def last_setup(store: QSettings) -> Path:
    """Return where it is kept: beside the preferences."""
    return Path(store.fileName()).parent / NAME


def keep_setup(path: Path, scenario: Scenario) -> None:
    """Write it, and make the folder where there is none.

    Args:
        path: from `last_setup`.
        scenario: to be flown at the next start.

    Raises:
        WorkbenchError: it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_scenario(scenario, path)
    except OSError as error:
        raise WorkbenchError(f"{path}: cannot be written: {error.strerror}") from error
