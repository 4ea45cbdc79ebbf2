"""Hears the keys that move sticks, wherever in the window the focus is, but not in a field."""

from collections.abc import Callable

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

from workbench.gui.joystick.keyboard_sticks import StickKey

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
"""Widgets that need letters or arrows for themselves."""
_PLAIN = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.KeypadModifier,
    Qt.KeyboardModifier.ShiftModifier,
)


class KeyWatcher(QObject):
    """Watches the one widget that has the focus, as keys come to it first.

    Args:
        page: keys count only in its window.
        pressed: told of a key that goes down.
        released: told of a key that is let go.
        lost: told when the focus is in a field, or in another window.
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
        """Listen from now on."""
        application = QGuiApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._follow)
        self._follow(None, QApplication.focusWidget())

    def stop(self) -> None:
        """Listen no more."""
        application = QGuiApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.disconnect(self._follow)
        self._watch(None)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Take the keys that move sticks; Qt's name."""
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
            event.accept()  # a shortcut of one letter is none here
        elif not event.isAutoRepeat():
            self._pressed(key)
        return True

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        """Watch the widget that has the focus now, where it leaves keys to the sticks."""
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
