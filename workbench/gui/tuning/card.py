"""Cards of the tuning screen, and parts that they share."""

from collections.abc import Mapping, Sequence

from PyQt6.QtCore import QSignalBlocker
from PyQt6.QtWidgets import (
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.help import explain
from workbench.gui.layout import ElidedLabel
from workbench.gui.number_field import buddy
from workbench.gui.style import dressed, set_class

SPACING = 6


class Card(QFrame):
    """A framed part of a screen, with a heading.

    Args:
        title: heading and accessible name.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        head: line with the heading; buttons are at its end.
        said: sentence beside the heading.
        body: layout below the heading.
    """

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setProperty("class", "card")
        self.setAccessibleName(title)
        explain(self, title)
        heading = dressed(QLabel(title), "heading")
        self.said = Sentence()
        self.head = QHBoxLayout()
        self.head.setSpacing(SPACING)
        self.head.addWidget(heading)
        self.head.addWidget(self.said, 1)
        self.body = QVBoxLayout(self)
        self.body.setContentsMargins(9, 8, 9, 8)
        self.body.setSpacing(SPACING)
        self.body.addLayout(self.head)


class Sentence(ElidedLabel):
    """A sentence in one line that is elided if necessary, coloured by its tone."""

    def __init__(self, tone: str = "muted") -> None:
        super().__init__()
        self.setProperty("class", tone)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def say(self, text: str, tone: str = "muted") -> None:
        """Show a sentence as muted, good, warning or bad."""
        set_class(self, tone)
        if text != self.text():
            self.setText(text)
            self.setAccessibleName(text)


def wrapped(tone: str = "muted") -> QLabel:
    """Return a label with wrapped text."""
    label = QLabel()
    label.setProperty("class", tone)
    label.setWordWrap(True)
    return label


def fields_beside(fields: Sequence[tuple[str, QWidget]], narrowest: int = 78) -> QGridLayout:
    """Return fields side by side, each below its label.

    Args:
        fields: text of the label, and the field.
        narrowest: least width of a field [px].
    """
    grid = QGridLayout()
    grid.setSpacing(SPACING)
    for column, (text, field) in enumerate(fields):
        grid.addWidget(buddy(text, field), 0, column)
        grid.addWidget(field, 1, column)
        grid.setColumnStretch(column, 1)
        field.setMinimumWidth(narrowest)
    return grid


def offer(box: QComboBox, texts: Mapping[str, str], first: str | None = None) -> bool:
    """Set the items of a box, without a signal; return whether they differ from the present ones.

    Args:
        box: the box, which keeps its selection if possible.
        texts: texts of the items, by their data.
        first: default selection; the first item if it is not among them.
    """
    if [*texts] == [box.itemData(index) for index in range(box.count())]:
        return False
    chosen = box.currentData()
    with QSignalBlocker(box):
        box.clear()
        for data, text in texts.items():
            box.addItem(text, data)
        box.setCurrentIndex(max(0, box.findData(chosen if chosen in texts else first)))
    return True
