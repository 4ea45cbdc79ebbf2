"""How the flight does: time, battery, speed reached, link, log and warnings in one line."""

from PyQt6.QtWidgets import QFrame, QHBoxLayout, QWidget

from workbench.gui.theme import Look
from workbench.gui.top_bar import wording
from workbench.gui.top_bar.chip import Chip
from workbench.live.view import LiveView

WARNINGS = 2
"""Places for warnings."""


class StatusStrip(QFrame):
    """One line of words with shapes.

    Args:
        look: colours.
        parent: in which it stands.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.time = Chip("Simulated time", look, 7)
        self.battery = Chip("Battery", look, 5)
        self.reached = Chip("Speed", look, 14)
        self.link = Chip("Link", look)
        self.recording = Chip("Recording", look)
        self.recording.hide()
        self.opening = Chip("Opening", look)
        self.opening.hide()
        self.warnings = [Chip("Warning", look) for _ in range(WARNINGS)]
        layout = QHBoxLayout(self)
        layout.setContentsMargins(20, 1, 12, 7)
        layout.setSpacing(24)
        for chip in (
            self.time,
            self.battery,
            self.reached,
            self.link,
            self.recording,
            self.opening,
        ):
            layout.addWidget(chip)
        layout.addStretch(1)
        for chip in self.warnings:
            layout.addWidget(chip)
        self.setMinimumHeight(self.sizeHint().height())

    def show_opening(self, said: str) -> None:
        """Show what is done to begin another flight; "" once it is over."""
        self.opening.setVisible(bool(said))
        if said:
            full = f"another flight is being prepared: {said}; the present one goes on until then"
            self.opening.show_said(wording.Said(f"opening: {said}", "pace", wording.MUTED, full))

    def show_view(self, view: LiveView) -> None:
        """Show the present."""
        self.time.show_said(wording.time_said(view))
        self.battery.show_said(wording.battery_said(view))
        self.reached.show_said(wording.reached_said(view))
        self.link.show_said(wording.link_said(view))
        said = wording.warnings_said(view)
        for at, chip in enumerate(self.warnings):
            chip.setVisible(at < len(said))
            if at < len(said):
                chip.show_said(said[at])
