"""What keys ask of a chart."""

from collections.abc import Callable
from enum import Enum, auto
from typing import TYPE_CHECKING

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QKeyEvent, QKeySequence

if TYPE_CHECKING:
    from workbench.gui.charts.strip_chart import StripChart

STEP = 0.02
"""Of the window that an arrow key moves the crosshair."""
PAGE = 0.25
"""Of the window that a page is."""
ZOOM = 0.8
"""Of the window that is left by one key."""


class ChartKey(Enum):
    """Something that a key asks for."""

    PAUSE = auto()
    FOLLOW = auto()
    LEFT = auto()
    RIGHT = auto()
    EARLIER = auto()
    LATER = auto()
    CLOSER = auto()
    FARTHER = auto()
    MARK_A = auto()
    MARK_B = auto()
    STATISTICS = auto()
    ZERO = auto()
    COPY = auto()
    MENU = auto()


_KEYS = {
    Qt.Key.Key_Space: ChartKey.PAUSE,
    Qt.Key.Key_Escape: ChartKey.FOLLOW,
    Qt.Key.Key_Home: ChartKey.FOLLOW,
    Qt.Key.Key_Left: ChartKey.LEFT,
    Qt.Key.Key_Right: ChartKey.RIGHT,
    Qt.Key.Key_PageUp: ChartKey.EARLIER,
    Qt.Key.Key_PageDown: ChartKey.LATER,
    Qt.Key.Key_Plus: ChartKey.CLOSER,
    Qt.Key.Key_Equal: ChartKey.CLOSER,
    Qt.Key.Key_Minus: ChartKey.FARTHER,
    Qt.Key.Key_A: ChartKey.MARK_A,
    Qt.Key.Key_B: ChartKey.MARK_B,
    Qt.Key.Key_S: ChartKey.STATISTICS,
    Qt.Key.Key_Z: ChartKey.ZERO,
    Qt.Key.Key_Menu: ChartKey.MENU,
}


def key_of(event: QKeyEvent) -> ChartKey | None:
    """Return what a key asks for, None where it is none of ours."""
    if event.matches(QKeySequence.StandardKey.Copy):
        return ChartKey.COPY
    held = event.modifiers() & ~(
        Qt.KeyboardModifier.KeypadModifier | Qt.KeyboardModifier.ShiftModifier
    )
    if held != Qt.KeyboardModifier.NoModifier:
        return None
    return _KEYS.get(Qt.Key(event.key())) if event.key() in _NUMBERS else None


def obey(chart: "StripChart", key: ChartKey) -> None:
    """Let a chart do what a key asks for."""
    actions: dict[ChartKey, Callable[[], object]] = {
        ChartKey.PAUSE: lambda: chart.set_paused(not chart.is_paused),
        ChartKey.FOLLOW: chart.follow,
        ChartKey.LEFT: lambda: chart.step_cursor(-STEP),
        ChartKey.RIGHT: lambda: chart.step_cursor(STEP),
        ChartKey.EARLIER: lambda: chart.move_by(-PAGE),
        ChartKey.LATER: lambda: chart.move_by(PAGE),
        ChartKey.CLOSER: lambda: chart.zoom_by(ZOOM),
        ChartKey.FARTHER: lambda: chart.zoom_by(1.0 / ZOOM),
        ChartKey.MARK_A: lambda: chart.set_mark("A"),
        ChartKey.MARK_B: lambda: chart.set_mark("B"),
        ChartKey.STATISTICS: lambda: chart.set_statistics_shown(not chart.are_statistics_shown),
        ChartKey.ZERO: lambda: chart.set_zero_shown(not chart.is_zero_shown),
        ChartKey.COPY: chart.copy_data,
        ChartKey.MENU: chart.head.open_menu,
    }
    actions[key]()


_NUMBERS = {key.value for key in _KEYS}
