"""Labels and tool tips, which show text from outside as it is.

Qt renders as HTML what looks like it, and would load the pictures that it names. So every label and
tool tip of the app is made here, see `tests/gui/test_foreign_text.py`.
"""

import re
from functools import lru_cache
from html import escape

from PyQt6.QtCore import QEvent, QSize, Qt
from PyQt6.QtGui import QAction, QResizeEvent, QStandardItem
from PyQt6.QtWidgets import QLabel, QSizePolicy, QTableWidgetItem, QWidget

from workbench.common.plain_text import MAX_SHOWN_NAME_CHARS, plain_name, plain_text

MAX_MENU_PATH_CHARACTERS = 200
"""Largest number of characters of a path in a menu."""

ZERO_WIDTH_SPACE = "\N{ZERO WIDTH SPACE}"
"""Where a word may be broken."""
_NAME_JOINTS = re.compile(r"[_.]+(?=\w)")
MAX_KNOWN_TIPS = 1024
"""Number of tool tips that are not made again: most are set many times."""
TIP_MARKUP = "<p style='white-space:pre-wrap'>"
"""Beginning of a tool tip whose text looks like HTML."""


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


class FixedLinesLabel(Label):
    """A text that wraps, in room for a number of lines, whatever it says: so it moves nothing.

    Args:
        lines: number of lines.
    """

    def __init__(self, lines: int) -> None:
        super().__init__()
        self._lines = lines
        self.setWordWrap(True)
        self._fit()

    def changeEvent(self, event: QEvent | None) -> None:
        """Make room for lines of another font, as that of a style."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._fit()

    def _fit(self) -> None:
        lines = "\n".join(["Ag"] * self._lines)
        self.setFixedHeight(self.fontMetrics().size(0, lines).height())


class WrappedLabel(Label):
    """A text that wraps. It needs no width, and the height of its lines at the present one.

    So it does without Qt's height for a width, which makes scroll areas scroll as soon as their
    content has less than its preferred height.

    Args:
        text: its text.
        lines: number of lines for which there is always room, so that longer texts move nothing.
    """

    def __init__(self, text: str = "", lines: int = 1) -> None:
        super().__init__(text)
        self._lines = lines
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.setWordWrap(True)

    def hasHeightForWidth(self) -> bool:
        """Return that the height is known without a width."""
        return False

    def minimumSizeHint(self) -> QSize:
        """Return the height of all lines, and no width."""
        least = self._lines * self.fontMetrics().lineSpacing()
        return QSize(0, max(least, self.heightForWidth(self.width()) if self.text() else 0))

    def sizeHint(self) -> QSize:
        """Return the same size."""
        return self.minimumSizeHint()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Ask for the lines at another width."""
        super().resizeEvent(event)
        if event is not None and event.size().width() != event.oldSize().width():
            self.updateGeometry()


class WrappedName(WrappedLabel):
    """A name in a column of fixed width, which also wraps after an underscore or a point."""

    def __init__(self) -> None:
        super().__init__()
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)

    def setText(self, text: str | None) -> None:
        """Show another name."""
        seen = plain_text(text or "")
        QLabel.setText(self, _NAME_JOINTS.sub(rf"\g<0>{ZERO_WIDTH_SPACE}", seen))

    def text(self) -> str:
        """Return the name, without the places where it may wrap."""
        return super().text().replace(ZERO_WIDTH_SPACE, "")


def set_tip(shown: QWidget | QAction | QStandardItem | QTableWidgetItem, text: str) -> None:
    """Set the tool tip of a widget, an action or an item; nothing is told if it is the same."""
    tip = tip_text(text)
    if tip != shown.toolTip():
        shown.setToolTip(tip)


@lru_cache(maxsize=MAX_KNOWN_TIPS)
def tip_text(text: str) -> str:
    """Return a text for Qt's tool tips, which render as HTML what looks like it."""
    seen = plain_text(text)
    if not Qt.mightBeRichText(seen):  # pyrefly: ignore[missing-attribute]
        return seen
    return f"{TIP_MARKUP}{escape(seen)}</p>"


def menu_text(name: str, longest: int = MAX_SHOWN_NAME_CHARS) -> str:
    """Return a name for a menu or a button, where `&` would underline a letter."""
    return plain_name(name, longest).replace("&", "&&")
