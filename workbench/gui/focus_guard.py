"""Where the keyboard's focus goes by itself, and which keys a field may take from the app."""

from PyQt6.QtCore import QEvent, QObject, Qt
from PyQt6.QtGui import QGuiApplication, QKeyEvent
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

_FIELDS = (QAbstractSpinBox, QLineEdit, QPlainTextEdit, QTextEdit)
_CONTROL = Qt.KeyboardModifier.ControlModifier
_SHIFT = Qt.KeyboardModifier.ShiftModifier
_EDITS = {
    *((key, _CONTROL) for key in map(ord, "ACVXYZ")),
    (ord("Z"), _CONTROL | _SHIFT),
}
"""Letters with Ctrl that edit text everywhere: all, copy, paste, cut, redo, undo."""


class FocusGuard(QObject):
    """Watches the widget that has the focus.

    Qt moves the focus on to the next widget when a button that has it is disabled or hidden, as
    Take off is once the drone takes off. The next one would then hear the space bar: a key that
    nobody meant for it. So the focus goes to the frame that the button stands in, which hears no
    key; Tab leads on from there.

    On X11 a field takes Ctrl+E, Ctrl+K and others for itself, as in a terminal, and the app's
    shortcuts are dead in it. It keeps the keys that edit text on every system, and no others.

    Args:
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self._field: QWidget | None = None
        application = QGuiApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._follow)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep the keys of the app's shortcuts from a field; Qt's name."""
        if not isinstance(event, QKeyEvent) or event.type() is not QEvent.Type.ShortcutOverride:
            return False
        key, modifiers = event.key(), event.modifiers()
        if modifiers not in (_CONTROL, _CONTROL | _SHIFT) or (key, modifiers) in _EDITS:
            return False
        if not (ord("A") <= key <= ord("Z") or ord("0") <= key <= ord("9")):
            return False
        event.ignore()
        return True

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        self._watch(now if isinstance(now, _FIELDS) else None)
        if now is None or before is None or not isinstance(now, QAbstractButton):
            return
        if before.isEnabled() and before.isVisible():
            return  # the user has moved it
        frame = before.parentWidget()
        while frame is not None and not (frame.isEnabled() and frame.isVisible()):
            frame = frame.parentWidget()
        if frame is not None and frame.window() is now.window():
            frame.setFocus()

    def _watch(self, field: QWidget | None) -> None:
        if self._field is not None:
            self._field.removeEventFilter(self)
            self._field.destroyed.disconnect(self._forget)
        self._field = field
        if field is not None:
            field.installEventFilter(self)
            field.destroyed.connect(self._forget)

    def _forget(self) -> None:
        self._field = None
