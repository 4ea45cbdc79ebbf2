"""The screens of the app, in order; loads neither them nor Qt."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from workbench.common.errors import find_row


@dataclass(frozen=True)
class ScreenRow:
    """One screen.

    Attributes:
        name: name on the command line.
        title: title in the side bar.
        icon: name of its picture, see `icons`.
        module: its module, below `workbench.gui`.
        kind: name of its class.
    """

    name: str
    title: str
    icon: str
    module: str
    kind: str

    @property
    def path(self) -> str:
        """Full name of the module."""
        return f"workbench.gui.{self.module}"

    def load(self) -> Callable[..., Any]:
        """Import the screen's module and return its class."""
        module = importlib.import_module(self.path)
        kind: Callable[..., Any] = getattr(module, self.kind)
        return kind


SCREENS: tuple[ScreenRow, ...] = (
    ScreenRow("home", "Home", "home", "home.home_screen", "HomeScreen"),
    ScreenRow("server", "Server", "server", "server.server_screen", "ServerScreen"),
    ScreenRow("joystick", "Joystick", "joystick", "joystick.joystick_screen", "JoystickScreen"),
    ScreenRow(
        "visualization",
        "Visualization",
        "visualization",
        "visualization.visualization_screen",
        "VisualizationScreen",
    ),
    ScreenRow("tuning", "Tuning", "tuning", "tuning.tuning_screen", "TuningScreen"),
    ScreenRow("settings", "Settings", "settings", "settings.settings_screen", "SettingsScreen"),
)


def find_screen(name: str) -> ScreenRow:
    """Return the row of a screen.

    Raises:
        WorkbenchError: if there is no such screen.
    """
    return find_row("screen", name, SCREENS)
