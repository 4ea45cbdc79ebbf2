"""The flight mode, in words and by a shape."""

from PyQt6.QtWidgets import QFrame, QHBoxLayout, QWidget

from workbench.gui.theme import Look
from workbench.gui.top_bar.chip import Chip
from workbench.gui.top_bar.wording import mode_said
from workbench.live.view import LiveView

LONGEST = 15
"""Of the usual texts, in digits."""


class ModeBadge(QFrame):
    """What the drone does.

    Args:
        look: colours.
        parent: in which it stands.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("mode_badge")
        self.chip = Chip("Flight", look, LONGEST)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(9, 4, 9, 4)
        layout.addWidget(self.chip)

    def show_view(self, view: LiveView) -> None:
        """Show the present."""
        self.chip.show_said(mode_said(view))
