"""What is flown when the app is opened and nothing was named."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PyQt6.QtCore import QSettings

    from workbench.live.choice import Choice

DEFAULT_SCENARIO = "network"
"""On the ground between obstacles, with sensors."""


def first_flight(store: "QSettings") -> "Choice":
    """Return what was set up by hand last, or the default.

    Raises:
        WorkbenchError: if what was set up needs a file that is gone; it is forgotten then.
    """
    from workbench.common.errors import WorkbenchError
    from workbench.common.yaml_files import read_yaml
    from workbench.gui.settings.last_setup import last_setup
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
