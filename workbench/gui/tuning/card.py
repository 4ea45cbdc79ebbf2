"""A card: what belongs together, on its own ground, with a heading."""

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from workbench.gui.style import set_class

SPACING = 6


class Card(QFrame):
    """A framed part of a screen.

    Args:
        title: its heading and accessible name.
        parent: whose life it shares.

    Attributes:
        head: the line of the heading; buttons go to its end.
        said: a sentence beside the heading.
        body: below it.
    """

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setProperty("class", "card")
        self.setAccessibleName(title)
        heading = QLabel(title)
        heading.setProperty("class", "heading")
        self.said = Sentence()
        self.head = QHBoxLayout()
        self.head.setSpacing(SPACING)
        self.head.addWidget(heading)
        self.head.addWidget(self.said, 1)
        self.body = QVBoxLayout(self)
        self.body.setContentsMargins(9, 8, 9, 8)
        self.body.setSpacing(SPACING)
        self.body.addLayout(self.head)


class Sentence(QLabel):
    """A sentence that takes the room there is, and has its whole text as tool tip."""

    def __init__(self, tone: str = "muted") -> None:
        super().__init__()
        self.setProperty("class", tone)
        self.setWordWrap(False)
        self.setMinimumWidth(40)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.setTextInteractionFlags(Qt.TextInteractionFlag.NoTextInteraction)
        self._whole = ""

    @property
    def whole(self) -> str:
        """What is said, in full."""
        return self._whole

    def say(self, text: str, tone: str = "muted") -> None:
        """Say something, as muted, good, warning or bad."""
        set_class(self, tone)
        if text != self._whole:
            self._whole = text
            self.setToolTip(text)
            self.setAccessibleName(text)
            self._fit()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Fit the text anew."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        metrics = self.fontMetrics()
        self.setText(
            metrics.elidedText(self._whole, Qt.TextElideMode.ElideRight, max(40, self.width()))
        )


def wrapped(tone: str = "muted") -> QLabel:
    """Return a label whose text goes on in the next line."""
    label = QLabel()
    label.setProperty("class", tone)
    label.setWordWrap(True)
    return label
