"""The guard of buttons that appear, or get another action, just before a click."""

from time import monotonic

from PyQt6.QtCore import QEvent, QObject
from PyQt6.QtGui import QCursor, QMoveEvent
from PyQt6.QtWidgets import QAbstractButton

FRESH_BUTTON_S = 0.5
"""A click so soon after a button came was aimed at what was there before [s]."""
_PRESSES = (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick)


class ClickGuard(QObject):
    """Makes a button ignore the mouse for half a second after it has changed.

    It has changed if it was shown by itself, not with its page; if a layout has moved it under the
    pointer; or if the words of its text are others, as Stop in place of Start. A number or a sign
    in the text is no such change. The keyboard is not affected, as the focus does not move.

    Args:
        button: the guarded button.
    """

    def __init__(self, button: QAbstractButton) -> None:
        super().__init__(button)
        self._button = button
        self._words: str | None = None
        self._changed = -FRESH_BUTTON_S
        self._comes = False  # into a page that is already shown
        button.installEventFilter(self)

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Note changes, and swallow presses soon after one; Qt's name."""
        if event is None:
            return False
        kind = event.type()
        if kind == QEvent.Type.Paint:
            self._look()
        elif kind == QEvent.Type.ParentChange:
            page = self._button.parentWidget()
            self._comes = page is not None and page.isVisible()
        elif kind == QEvent.Type.HideToParent:
            self._comes = True
        elif kind == QEvent.Type.ShowToParent:
            if self._comes and self._button.isVisible():
                self._changed = monotonic()
            self._comes = False
        elif isinstance(event, QMoveEvent):
            if self._button.isVisible() and self._came_under_pointer(event):
                self._changed = monotonic()
        elif kind in _PRESSES:
            self._look()
            return monotonic() < self._changed + FRESH_BUTTON_S
        return False

    def _look(self) -> None:
        before, self._words = self._words, _words(self._button)
        if before is not None and self._words != before:
            self._changed = monotonic()

    def _came_under_pointer(self, event: QMoveEvent) -> bool:
        place, rect = self._button.mapFromGlobal(QCursor.pos()), self._button.rect()
        return rect.contains(place) and not rect.contains(place + event.pos() - event.oldPos())


def _words(button: QAbstractButton) -> str:
    """Return the letters of a button's text."""
    return "".join(filter(str.isalpha, button.text()))
