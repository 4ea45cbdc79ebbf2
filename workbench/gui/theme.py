"""Colours of the app, light and dark; text has a contrast of at least 4.5 on any background."""

from dataclasses import dataclass

from PyQt6.QtCore import QObject, Qt, pyqtSignal
from PyQt6.QtGui import QColor, QGuiApplication

from workbench.gui.preferences import Preferences


@dataclass(frozen=True)
class Colours:
    """Colours by their purpose, as #rrggbb.

    Attributes:
        ground: background of the window.
        card: background of cards.
        field: background of input fields and charts.
        line: borders and grids.
        ink: text.
        muted: less prominent text: labels, units.
        accent: selected items, and the next button to press.
        on_accent: text on the accent colour.
        good: all is well; always with a word or a shape.
        warning: needs attention.
        bad: broken, or beyond a limit.
        command: commands, in charts.
        curves: curves of charts, in order; distinguishable by the colour-blind, too.
        sky: upper half of the attitude indicator.
        earth: its lower half.
    """

    ground: str
    card: str
    field: str
    line: str
    ink: str
    muted: str
    accent: str
    on_accent: str
    good: str
    warning: str
    bad: str
    command: str
    curves: tuple[str, ...]
    sky: str
    earth: str


LIGHT_COLOURS = Colours(
    ground="#eef1f5",
    card="#ffffff",
    field="#ffffff",
    line="#d3d9e2",
    ink="#1a2230",
    muted="#566173",
    accent="#1d63d1",
    on_accent="#ffffff",
    good="#1a7a3c",
    warning="#8f5a00",
    bad="#c22030",
    command="#5b6472",
    curves=(
        "#0067a5",
        "#c1440e",
        "#00826a",
        "#9c3f8e",
        "#8a6d00",
        "#3b3fb5",
        "#a3274b",
        "#4d6b0f",
    ),
    sky="#6aa6dd",
    earth="#9a7350",
)
DARK_COLOURS = Colours(
    ground="#12161d",
    card="#1b212b",
    field="#151a22",
    line="#323b49",
    ink="#e7ebf1",
    muted="#9aa5b5",
    accent="#5ea3ff",
    on_accent="#0b1018",
    good="#52c878",
    warning="#e5b64a",
    bad="#ff7c78",
    command="#a3adbb",
    curves=(
        "#56b4f0",
        "#f28c55",
        "#3ecfae",
        "#e08ad0",
        "#e0c14b",
        "#9ea2ff",
        "#ff8fae",
        "#a9cc5c",
    ),
    sky="#2f6ea8",
    earth="#6d4f35",
)


class Look(QObject):
    """The present colours: those of the desktop, or those that the user prefers.

    Args:
        preferences: source of the theme.
    """

    changed = pyqtSignal()
    """The colours have changed: repaint."""

    def __init__(self, preferences: Preferences) -> None:
        super().__init__()
        self._preferences = preferences
        self.colours = self._wanted()
        preferences.changed.connect(lambda name: self._update() if name == "theme" else None)
        hints = QGuiApplication.styleHints()
        if hints is not None:
            hints.colorSchemeChanged.connect(self._update)

    @property
    def is_dark(self) -> bool:
        """Whether the text is lighter than its background."""
        return self.colours is DARK_COLOURS

    def colour(self, name: str) -> QColor:
        """Return a colour by the name of its attribute, as "accent"."""
        return QColor(getattr(self.colours, name))

    def curve(self, index: int) -> QColor:
        """Return the colour of a chart's curve; that of commands for -1, of limits for -2."""
        if index < 0:
            return QColor(self.colours.command if index == -1 else self.colours.bad)
        return QColor(self.colours.curves[index % len(self.colours.curves)])

    def _update(self) -> None:
        wanted = self._wanted()
        if wanted is not self.colours:
            self.colours = wanted
            self.changed.emit()

    def _wanted(self) -> Colours:
        theme = self._preferences.text("theme")
        hints = QGuiApplication.styleHints()
        if theme == "system" and hints is not None:
            return DARK_COLOURS if hints.colorScheme() == Qt.ColorScheme.Dark else LIGHT_COLOURS
        return DARK_COLOURS if theme == "dark" else LIGHT_COLOURS
