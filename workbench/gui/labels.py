"""Labels and tool tips, which show text from outside as it is.

Qt renders as HTML what looks like it, and would load the pictures that it names. So every label and
tool tip of the app is made here, see `tests/gui/test_foreign_text.py`.
"""

from html import escape
from typing import Protocol

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent
from PyQt6.QtWidgets import QLabel, QWidget

from workbench.common.plain_text import LONGEST_NAME, plain_name, plain_text

LONGEST_PATH = 200
"""Largest number of characters of a path in a menu."""

MARKUP = "<p style='white-space:pre-wrap'>"
"""Beginning of a tool tip whose text looks like HTML."""


class HasTip(Protocol):
    """A widget, an action, or an item of a table."""

    def setToolTip(self, text: str | None, /) -> None:
        """Set the tool tip."""


class Label(QLabel):
    """A label that shows its text as it is, shortened if it is longer than anybody reads.

    Args:
        text: its text.
        parent: the Qt parent.
    """

    def __init__(self, text: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setText(text)

    def setText(self, text: str | None) -> None:
        """Show another text."""
        super().setText(plain_text(text or ""))


class ElidedLabel(Label):
    """A label that needs no width: long text is elided, and the tool tip has all of it."""

    def setText(self, text: str | None) -> None:
        """Show another text."""
        super().setText(text)
        set_tip(self, text or "")

    def minimumSizeHint(self) -> QSize:
        """Return almost no width."""
        return QSize(24, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the text that fits."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        room = self.contentsRect()
        text = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, room.width())
        painter.drawText(room, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text)


def set_tip(shown: HasTip, text: str) -> None:
    """Set the tool tip of a widget, an action or an item."""
    shown.setToolTip(tip_text(text))


def tip_text(text: str) -> str:
    """Return a text for Qt's tool tips, which render as HTML what looks like it."""
    seen = plain_text(text)
    if not Qt.mightBeRichText(seen):  # pyrefly: ignore[missing-attribute]
        return seen
    return f"{MARKUP}{escape(seen)}</p>"


def menu_text(name: str, longest: int = LONGEST_NAME) -> str:
    """Return a name for a menu or a button, where `&` would underline a letter."""
    return plain_name(name, longest).replace("&", "&&")
