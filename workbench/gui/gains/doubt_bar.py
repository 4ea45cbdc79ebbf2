"""Says why gains are not flown, and asks whether to fly them all the same."""

from PyQt6.QtGui import QKeySequence, QShortcut
from PyQt6.QtWidgets import QFrame, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from workbench.gui.gains.gain_desk import GainDesk


class DoubtBar(QFrame):
    """Stands above the gains while something of them is doubted.

    Args:
        desk: what is doubted.
        parent: whose life it shares.
    """

    def __init__(self, desk: GainDesk, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setProperty("class", "card")
        self.said = QLabel(self)
        self.said.setWordWrap(True)
        self.said.setAccessibleName("Why the gains are not flown")
        self.fly = QPushButton("&Fly it anyway", self)
        self.fly.setToolTip("Fly what is proposed although it is doubted (Ctrl+Return)")
        QShortcut(QKeySequence("Ctrl+Return"), self).activated.connect(desk.confirm)
        self.back = QPushButton("&Back", self)
        self.back.setToolTip("Propose again what flies (Esc)")
        self.back.setProperty("class", "primary")
        buttons = QHBoxLayout()
        buttons.addStretch()
        buttons.addWidget(self.fly)
        buttons.addWidget(self.back)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 6, 8, 6)
        layout.setSpacing(5)
        layout.addWidget(self.said)
        layout.addLayout(buttons)
        self.fly.clicked.connect(desk.confirm)
        self.back.clicked.connect(lambda: desk.back())
        desk.doubt_raised.connect(self._show)
        desk.doubt_cleared.connect(self.hide)
        self.setVisible(bool(desk.doubt))

    def _show(self, said: str) -> None:
        self.said.setText(f"▲ <b>Not flown:</b> {said.rstrip('.')}.")
        self.show()
