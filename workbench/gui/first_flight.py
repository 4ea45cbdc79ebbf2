"""What is flown when the app is opened and nothing was named: the last setup, or the default."""

from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from PyQt6.QtCore import QSettings

    from workbench.live.choice import Choice
    from workbench.scenario.scenario import Scenario

DEFAULT_SCENARIO = "network"
"""On the ground between obstacles, with sensors."""
NAME = "last-flight.yaml"
"""Of the scenario that was set up by hand last."""


def first_flight(store: "QSettings") -> "Choice":
    """Return what was set up by hand last, or the default.

    Raises:
        WorkbenchError: if what was set up needs a file that is gone; it is forgotten then.
    """
    from workbench.common.yaml_files import read_yaml
    from workbench.live.choice import Choice

    kept = last_setup(store)
    if not kept.is_file():
        return Choice(DEFAULT_SCENARIO)
    try:
        said = read_yaml(kept).data
        vehicle = said.get("vehicle", {})
        Choice(str(kept), vehicle.get("model", ""), said.get("world", "")).check()
    except (WorkbenchError, AttributeError, TypeError) as error:
        kept.unlink(missing_ok=True)
        raise WorkbenchError(f"what was flown last cannot be flown again: {error}") from error
    return Choice(str(kept))


def last_setup(store: "QSettings") -> Path:
    """Return where the last setup is kept: beside the preferences."""
    return Path(store.fileName()).parent / NAME


def keep_setup(path: Path, scenario: "Scenario") -> None:
    """Keep a setup for the next start; the folder is made where there is none.

    Args:
        path: from `last_setup`.
        scenario: to be flown at the next start.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    from workbench.scenario.scenario import save_scenario

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        save_scenario(scenario, path)
    except OSError as error:
        raise WorkbenchError(f"{path}: cannot be written: {error.strerror}") from error
