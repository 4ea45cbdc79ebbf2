"""Cards of the tuning screen, and parts that they share."""

from collections.abc import Mapping, Sequence

from PyQt6.QtCore import QSignalBlocker
from PyQt6.QtWidgets import (
    QComboBox,
    QFrame,
    QGridLayout,
    QSizePolicy,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.gui.help import explain
from workbench.gui.labels import ElidedLabel, Label
from workbench.gui.layout import NO_MARGINS, buddy, grid, hbox, label, vbox
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
        dressed(self, "card")
        self.setAccessibleName(title)
        explain(self, title)
        self.said = Sentence()
        self.head = hbox(label(title, "heading"), (self.said, 1), spacing=SPACING)
        self.body = vbox(self.head, of=self, margins=(9, 8, 9, 8), spacing=SPACING)

    def set_seen(self, seen: bool) -> None:
        """Ask and draw only while the card is visible."""


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


def wrapped(tone: str = "muted") -> Label:
    """Return a label with wrapped text."""
    return label(kind=tone, wraps=True)


def fields_beside(
    fields: Sequence[tuple[str, QWidget]],
    widths: Sequence[int] | int = 78,
    *,
    of: QWidget | None = None,
    gap: int = SPACING,
) -> QGridLayout:
    """Return fields side by side, each below its label.

    Args:
        fields: text of the label, and the field.
        widths: least widths of the fields, or the same for all [px]; wider ones get more space.
        of: widget that gets the layout, None for a nested layout.
        gap: between a label and its field [px].
    """
    shares = [widths] * len(fields) if isinstance(widths, int) else widths
    for (_, field), width in zip(fields, shares, strict=True):
        field.setMinimumWidth(width)
    return grid(
        [buddy(text, field) for text, field in fields],
        [field for _, field in fields],
        of=of,
        margins=NO_MARGINS,
        spacing=(SPACING, gap),
        stretches=shares,
    )


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
            box.addItem(plain_name(text), data)
        box.setCurrentIndex(max(0, box.findData(chosen if chosen in texts else first)))
    return True
