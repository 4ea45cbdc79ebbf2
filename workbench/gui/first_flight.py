"""What is flown when the app is opened and nothing was named."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PyQt6.QtCore import QSettings

    from workbench.live.choice import Choice

DEFAULT_SCENARIO = "network"
"""On the ground between obstacles, with sensors."""


def first_flight(store: "QSettings") -> "Choice":
    """Return what was set up by hand last, or the default."""
    from workbench.gui.settings.last_setup import last_setup
    from workbench.live.choice import Choice

    kept = last_setup(store)
    return Choice(str(kept)) if kept.is_file() else Choice(DEFAULT_SCENARIO)
