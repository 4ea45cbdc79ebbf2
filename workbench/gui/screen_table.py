"""The screens of the app, in order; loads neither them nor Qt."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from workbench.common.errors import find_named_row


@dataclass(frozen=True)
class ScreenRow:
    """One screen.

    Attributes:
        name: name on the command line.
        title: title in the side bar.
        icon: name of its picture, see `icons`.
        module: its module, below `workbench.gui`.
        kind: name of its class.
        shortcut: its key, as Qt writes it.
    """

    name: str
    title: str
    icon: str
    module: str
    kind: str
    shortcut: str

    @property
    def path(self) -> str:
        """Full name of the module."""
        return f"workbench.gui.{self.module}"

    def load(self) -> Callable[..., Any]:
        """Import the screen's module and return its class."""
        module = importlib.import_module(self.path)
        kind: Callable[..., Any] = getattr(module, self.kind)
        return kind


DEFAULT_SCREEN = "home"
"""The first screen, until the app remembers the last one."""
SCREEN_TABLE: tuple[ScreenRow, ...] = (
    ScreenRow("start", "Start", "start", "start.start_screen", "StartScreen", "Ctrl+N"),
    ScreenRow("home", "Home", "home", "home.home_screen", "HomeScreen", "Ctrl+1"),
    ScreenRow("server", "Server", "server", "server.server_screen", "ServerScreen", "Ctrl+2"),
    ScreenRow(
        "joystick", "Joystick", "joystick", "joystick.joystick_screen", "JoystickScreen", "Ctrl+3"
    ),
    ScreenRow(
        "visualization",
        "Visualization",
        "visualization",
        "visualization.visualization_screen",
        "VisualizationScreen",
        "Ctrl+4",
    ),
    ScreenRow("tuning", "Tuning", "tuning", "tuning.tuning_screen", "TuningScreen", "Ctrl+5"),
    ScreenRow(
        "settings", "Settings", "settings", "settings.settings_screen", "SettingsScreen", "Ctrl+6"
    ),
)


def find_screen(name: str) -> ScreenRow:
    """Return the row of a screen.

    Raises:
        WorkbenchError: if there is no such screen.
    """
    return find_named_row("screen", name, SCREEN_TABLE)
