"""Keys as sticks: by default W A S D are the left one, the arrows the right one."""

from PyQt6.QtCore import QEvent, QObject, Qt, pyqtSignal
from PyQt6.QtGui import QGuiApplication, QKeyEvent, QKeySequence
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

from workbench.gui.joystick.piloting import CENTRED_STICKS, Sticks, within_circle
from workbench.gui.key_map import KeyMap

KEY_CONSUMING_WIDGETS = (
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
_STICK_KEY_MODIFIERS = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.KeypadModifier,
    Qt.KeyboardModifier.ShiftModifier,
)

FULL_DEFLECTION_TIME_S = 0.5
"""Time from the centre to full deflection while a key is held [s]."""

KEY_DIRECTIONS = {
    "stick_climb": Sticks(climb=1.0),
    "stick_sink": Sticks(climb=-1.0),
    "stick_turn_left": Sticks(turn=-1.0),
    "stick_turn_right": Sticks(turn=1.0),
    "stick_forward": Sticks(forward=1.0),
    "stick_back": Sticks(forward=-1.0),
    "stick_left": Sticks(right=-1.0),
    "stick_right": Sticks(right=1.0),
}
"""Where each key moves the sticks, by its row in the table of keys: up, down, left and right of the
left stick, then of the right one."""


class KeyboardSticks(QObject):
    """Two sticks that deflect while keys are held, and return to the centre on release.

    It watches the focused widget, which receives keys first.

    Args:
        keys: keys of all actions.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        sticks: their positions.
    """

    changed = pyqtSignal()
    """A key was pressed or released."""

    def __init__(self, keys: KeyMap, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.sticks = CENTRED_STICKS
        self._keys = keys
        self._held: set[str] = set()
        self._page: QWidget | None = None
        self._watched: QWidget | None = None

    @property
    def is_held(self) -> bool:
        """Whether a key is down."""
        return bool(self._held)

    def press(self, name: str) -> None:
        """Press the key of a row; the stick starts to move with the next `advance`."""
        self._held.add(name)

    def release(self, name: str) -> None:
        """Release a key: its axis is centred at once, unless the opposite key is held."""
        self._held.discard(name)
        self.advance(0.0)

    def release_all(self) -> None:
        """Release all keys."""
        self._held.clear()
        self.sticks = CENTRED_STICKS

    def advance(self, duration: float) -> Sticks:
        """Move the sticks for a time [s], and return their positions."""
        step = duration / FULL_DEFLECTION_TIME_S
        directions = zip(CENTRED_STICKS, *map(KEY_DIRECTIONS.__getitem__, self._held), strict=True)
        axes = [
            _stepped_axis(place, sum(towards), step)
            for place, towards in zip(self.sticks, directions, strict=True)
        ]
        self.sticks = Sticks(*within_circle(*axes[:2]), *within_circle(*axes[2:]))
        return self.sticks

    def watch(self, page: QWidget) -> None:
        """Start to watch keys; they count only in the window of a page."""
        self._page = page
        _application().focusChanged.connect(self._follow)
        self._follow(None, QApplication.focusWidget())

    def stop(self) -> None:
        """Stop watching."""
        _application().focusChanged.disconnect(self._follow)
        self._watch(None)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Handle the keys that move sticks; Qt's name."""
        if not isinstance(event, QKeyEvent):
            return False
        typed = QKeySequence(event.key()).toString()
        name = next((each for each in KEY_DIRECTIONS if self._keys.key(each) == typed), "")
        if not name:
            return False
        if event.type() is QEvent.Type.KeyRelease:
            if not event.isAutoRepeat():
                self.release(name)
                self.changed.emit()
            return True
        if event.modifiers() not in _STICK_KEY_MODIFIERS:
            return False
        if event.type() is QEvent.Type.ShortcutOverride:
            event.accept()  # a single-letter shortcut does not apply here
        elif not event.isAutoRepeat():
            self.press(name)
            self.changed.emit()
        return True

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        """Watch the focused widget, unless it uses the keys itself."""
        window = self._page.window() if self._page is not None else None
        if now is None or now.window() is not window or isinstance(now, KEY_CONSUMING_WIDGETS):
            self._watch(None)
            self.release_all()
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
        self.release_all()


def _application() -> QApplication:
    application = QGuiApplication.instance()
    assert isinstance(application, QApplication)
    return application


def _stepped_axis(place: float, towards: float, step: float) -> float:
    """Return an axis one step closer to its end; a reversal starts in the centre."""
    if towards == 0.0:
        return 0.0
    start = max(0.0, towards * place)
    return towards * min(1.0, start + step)
