"""The guard of the keyboard focus: who gets it, and which keys a field leaves to the app."""

from PyQt6 import sip
from PyQt6.QtCore import QEvent, QObject, Qt
from PyQt6.QtGui import QGuiApplication, QKeyEvent, QKeySequence
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

_TEXT_EDITORS = (QAbstractSpinBox, QLineEdit, QPlainTextEdit, QTextEdit)
_CONTROL_KEY = Qt.KeyboardModifier.ControlModifier
_SHIFT_KEY = Qt.KeyboardModifier.ShiftModifier
_EDITING_KEYS = {
    *((key, _CONTROL_KEY) for key in map(ord, "ACVXYZ")),
    (ord("Z"), _CONTROL_KEY | _SHIFT_KEY),
}
"""Keys with Ctrl that edit text on every system: select all, copy, paste, cut, redo, undo."""


class FocusGuard(QObject):
    """Watches the focused widget.

    When a focused button is disabled or hidden, as Take off after the take-off, Qt moves the focus
    to the next widget. That widget would then receive the space bar, which was not meant for it. So
    the focus moves to the frame around the button, which ignores keys; Tab continues from there.
    The same happens if the mouse has chosen a button or a box: Space then plays or pauses, and
    letters are for charts. With Tab, Space presses a button as everywhere.

    On X11 a field uses Ctrl+E, Ctrl+K and others itself, as in a terminal, which disables the app's
    shortcuts there. Here it keeps only the keys that edit text on every system, and those of undo
    and redo only if it has something to undo or redo.

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
        """Keep the app's shortcuts working in a field; Qt's name."""
        if not isinstance(event, QKeyEvent) or event.type() is not QEvent.Type.ShortcutOverride:
            return False
        key, modifiers = event.key(), event.modifiers()
        if _has_nothing_to_undo(watched, event):
            event.ignore()
            return True
        if (
            modifiers not in (_CONTROL_KEY, _CONTROL_KEY | _SHIFT_KEY)
            or (key, modifiers) in _EDITING_KEYS
        ):
            return False
        letter_or_digit = ord("A") <= key <= ord("Z") or ord("0") <= key <= ord("9")
        if not letter_or_digit and key != Qt.Key.Key_Return:
            return False
        event.ignore()
        return True

    def _follow(self, before: QWidget | None, now: QWidget | None) -> None:
        self._watch(now if isinstance(now, _TEXT_EDITORS) else None)
        if not isinstance(now, (QAbstractButton, QComboBox)):
            return
        if QGuiApplication.mouseButtons() != Qt.MouseButton.NoButton:
            if now.window() is self.parent():
                _focus_frame_of(now)
        elif before is None or (before.isEnabled() and before.isVisible()):
            return  # the user has moved the focus
        elif before.window() is now.window() and isinstance(now, QAbstractButton):
            _focus_frame_of(before)

    def _watch(self, field: QWidget | None) -> None:
        if self._field is not None and not sip.isdeleted(self._field):
            self._field.removeEventFilter(self)
        self._field = field
        if field is not None:
            field.installEventFilter(self)


def _focus_frame_of(widget: QWidget) -> None:
    """Move the focus to the nearest frame around a widget that is enabled and visible."""
    frame = widget.parentWidget()
    while frame is not None and not (frame.isEnabled() and frame.isVisible()):
        frame = frame.parentWidget()
    if frame is not None:
        frame.setFocus()


def _has_nothing_to_undo(field: QObject | None, event: QKeyEvent) -> bool:
    """Return whether a key would undo or redo the text of a field that has no such change."""
    line = field.findChild(QLineEdit) if isinstance(field, QAbstractSpinBox) else field
    if not isinstance(line, QLineEdit):
        return False
    if event.matches(QKeySequence.StandardKey.Undo):
        return not line.isUndoAvailable()
    return event.matches(QKeySequence.StandardKey.Redo) and not line.isRedoAvailable()
