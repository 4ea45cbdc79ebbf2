"""A card: what belongs together, on its own ground, with a heading."""

from PyQt6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from workbench.gui.help import explain
from workbench.gui.layout import ElidedLabel
from workbench.gui.style import dressed, set_class

SPACING = 6


class Card(QFrame):
    """A framed part of a screen.

    Args:
        title: its heading and accessible name.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        head: the line of the heading; buttons go to its end.
        said: a sentence beside the heading.
        body: below it.
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
    """A sentence that takes the room there is, in the colour of what it says."""

    def __init__(self, tone: str = "muted") -> None:
        super().__init__()
        self.setProperty("class", tone)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def say(self, text: str, tone: str = "muted") -> None:
        """Say something, as muted, good, warning or bad."""
        set_class(self, tone)
        if text != self.text():
            self.setText(text)
            self.setAccessibleName(text)


def wrapped(tone: str = "muted") -> QLabel:
    """Return a label whose text goes on in the next line."""
    label = QLabel()
    label.setProperty("class", tone)
    label.setWordWrap(True)
    return label
