"""What stands where a screen should: it could not be made, or is being made."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QLabel, QVBoxLayout, QWidget

from workbench.gui.style import dressed


class MissingPage(QWidget):
    """A sentence in the middle.

    Args:
        title: of the screen.
        said: why it is not here.
        parent: in which it stands.
    """

    def __init__(self, title: str, said: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        heading = dressed(QLabel(title), "title")
        words = dressed(QLabel(said), "muted")
        words.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.addStretch(1)
        for label in (heading, words):
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
            layout.addWidget(label)
        layout.addStretch(2)
        self.setAccessibleName(f"{title} screen")
