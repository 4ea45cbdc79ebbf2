"""What the app flies if nothing was named: the last setup, or the default."""

from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import make_folder

if TYPE_CHECKING:
    from PyQt6.QtCore import QSettings

    from workbench.live.choice import Choice
    from workbench.scenario.scenario import Scenario

DEFAULT_APP_SCENARIO = "network"
"""Default scenario: on the ground between obstacles, with sensors."""
LAST_SETUP_FILE = "last-flight.yaml"
"""File name of the scenario that was last set up by hand."""


def first_flight(store: "QSettings") -> "Choice":
    """Return the scenario that was last set up by hand, or the default.

    Raises:
        WorkbenchError: if that setup needs a file that is gone; it is then forgotten.
    """
    from workbench.common.yaml_files import read_yaml
    from workbench.live.choice import Choice

    kept = last_setup(store)
    if not kept.is_file():
        return Choice(DEFAULT_APP_SCENARIO)
    try:
        said = read_yaml(kept).data
        vehicle = said.get("vehicle", {})
        Choice(str(kept), vehicle.get("model", ""), said.get("world", "")).check()
    except (WorkbenchError, AttributeError, TypeError) as error:
        kept.unlink(missing_ok=True)
        raise WorkbenchError(f"the last scenario cannot be flown again: {error}") from error
    return Choice(str(kept))


def last_setup(store: "QSettings") -> Path:
    """Return the path of the last setup: beside the preferences."""
    return Path(store.fileName()).parent / LAST_SETUP_FILE


def save_setup(path: Path, scenario: "Scenario") -> None:
    """Save a setup for the next start, and make its folder if necessary.

    Args:
        path: result of `last_setup`.
        scenario: scenario to fly at the next start.

    Raises:
        WorkbenchError: if the file cannot be written.
    """
    from workbench.scenario.scenario_file import save_scenario

    make_folder(path.parent)
    try:
        save_scenario(scenario, path)
    except OSError as error:
        raise WorkbenchError(f"{path}: cannot be written: {error.strerror}") from error
