"""Keys as sticks: W A S D are the left one, the arrows the right one."""

from collections.abc import Callable
from enum import Enum

from PyQt6.QtCore import QEvent, QObject, Qt
from PyQt6.QtGui import QGuiApplication, QKeyEvent
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QMenu,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

from workbench.gui.joystick.piloting import MIDDLE, Stick, Sticks, within_circle

FIELDS = (
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QMenu,
    QPlainTextEdit,
    QTextEdit,
)
"""Widgets that use letters or arrows themselves."""
_PLAIN = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.KeypadModifier,
    Qt.KeyboardModifier.ShiftModifier,
)

RUN_UP = 0.5
"""Time from the centre to full deflection while a key is held [s]."""


class StickKey(Enum):
    """The direction of a key: whether it belongs to the left stick, and its deflection."""

    CLIMB = (True, 0, 1)
    SINK = (True, 0, -1)
    TURN_LEFT = (True, -1, 0)
    TURN_RIGHT = (True, 1, 0)
    FORWARD = (False, 0, 1)
    BACK = (False, 0, -1)
    LEFT = (False, -1, 0)
    RIGHT = (False, 1, 0)


KEYS = {
    Qt.Key.Key_W: StickKey.CLIMB,
    Qt.Key.Key_S: StickKey.SINK,
    Qt.Key.Key_A: StickKey.TURN_LEFT,
    Qt.Key.Key_D: StickKey.TURN_RIGHT,
    Qt.Key.Key_Up: StickKey.FORWARD,
    Qt.Key.Key_Down: StickKey.BACK,
    Qt.Key.Key_Left: StickKey.LEFT,
    Qt.Key.Key_Right: StickKey.RIGHT,
}


class KeyboardSticks:
    """Two sticks that deflect while keys are held, and return to the centre on release.

    Attributes:
        sticks: their positions.
    """

    def __init__(self) -> None:
        self.sticks = Sticks()
        self._held: set[StickKey] = set()

    @property
    def is_held(self) -> bool:
        """Whether a key is down."""
        return bool(self._held)

    def press(self, key: StickKey) -> None:
        """Press a key; the stick starts to move with the next `advance`."""
        self._held.add(key)

    def release(self, key: StickKey) -> None:
        """Release a key: its axis is centred at once, unless the opposite key is held."""
        self._held.discard(key)
        self.advance(0.0)

    def release_all(self) -> None:
        """Release all keys."""
        self._held.clear()
        self.sticks = Sticks()

    def advance(self, duration: float) -> Sticks:
        """Move the sticks for a time [s], and return their positions."""
        step = duration / RUN_UP
        self.sticks = Sticks(
            self._moved(self.sticks.left, True, step), self._moved(self.sticks.right, False, step)
        )
        return self.sticks

    def _moved(self, stick: Stick, is_left: bool, step: float) -> Stick:
        keys = [key.value for key in self._held if key.value[0] is is_left]
        if not keys:
            return MIDDLE
        x = _run(stick.x, sum(key[1] for key in keys), step)
        y = _run(stick.y, sum(key[2] for key in keys), step)
        return within_circle(x, y)


def _run(place: float, towards: int, step: float) -> float:
    """Return an axis one step closer to its end; a reversal starts in the centre."""
    if towards == 0:
        return 0.0
    start = max(0.0, towards * place)
    return towards * min(1.0, start + step)


class KeyWatcher(QObject):
    """Watches the focused widget, which receives keys first.

    Args:
        page: keys count only in its window.
        pressed: called when a key is pressed.
        released: called when a key is released.
        lost: called when a field, or another window, has the focus.
    """

    def __init__(
        self,
        page: QWidget,
        pressed: Callable[[StickKey], None],
        released: Callable[[StickKey], None],
        lost: Callable[[], None],
    ) -> None:
        super().__init__(page)
        self._page = page
        self._pressed, self._released, self._lost = pressed, released, lost
        self._watched: QWidget | None = None

    def start(self) -> None:
        """Start watching."""
        application = QGuiApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._follow)
        self._follow(None, QApplication.focusWidget())

    def stop(self) -> None:
        """Stop watching."""
        application = QGuiApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.disconnect(self._follow)
        self._watch(None)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Handle the keys that move sticks; Qt's name."""
        if not isinstance(event, QKeyEvent) or event.key() not in KEYS:
            return False
        key = KEYS[Qt.Key(event.key())]
        if event.type() is QEvent.Type.KeyRelease:
            if not event.isAutoRepeat():
                self._released(key)
            return True
        if event.modifiers() not in _PLAIN:
            return False
        if event.type() is QEvent.Type.ShortcutOverride:
            event.accept()  # a single-letter shortcut does not apply here
        elif not event.isAutoRepeat():
            self._pressed(key)
        return True

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        """Watch the focused widget, unless it uses the keys itself."""
        window = self._page.window()
        if now is None or now.window() is not window or isinstance(now, FIELDS):
            self._watch(None)
            self._lost()
        else:
            self._watch(now)

    def _watch(self, widget: QWidget | None) -> None:
        if self._watched is not None:
            self._watched.removeEventFilter(self)
            self._watched.destroyed.disconnect(self._forget)
        self._watched = widget
        if widget is not None:
            widget.installEventFilter(self)
            widget.destroyed.connect(self._forget)

    def _forget(self) -> None:
        self._watched = None
        self._lost()
