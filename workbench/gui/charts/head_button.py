"""Small buttons over a chart, painted so that they are sharp in every size and colour."""

from enum import Enum

from PyQt6.QtCore import QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen
from PyQt6.QtWidgets import QAbstractButton, QWidget

from workbench.gui.theme import Look


class Sign(Enum):
    """What is painted on a button."""

    PAUSE = "pause"
    MENU = "menu"


class HeadButton(QAbstractButton):
    """A button without a frame.

    Args:
        look: colours.
        sign: painted on it.
        name: in words.
        help: what it does.
        parent: whose life it shares.
    """

    def __init__(
        self, look: Look, sign: Sign, name: str, help: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._look, self._sign = look, sign
        self.setText(name)
        self.setToolTip(help)
        self.setAccessibleName(name)
        self.setAccessibleDescription(help)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return a square as high as a line."""
        side = self.fontMetrics().height() + 4
        return QSize(side + 4, side)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(1, 1, -1, -1)
        lit = self.isChecked() or self.isDown()
        if lit:
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(self._look.colour("accent"))
            painter.drawRoundedRect(box, 4, 4)
        if self.hasFocus() or self.underMouse():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            colour = self._look.colour("accent" if self.hasFocus() else "line")
            painter.setPen(QPen(colour, 2 if self.hasFocus() else 1))
            painter.drawRoundedRect(box, 4, 4)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self._look.colour("on_accent" if lit else "muted"))
        middle, high = box.center(), 0.22 * box.height()
        if self._sign is Sign.PAUSE:
            for side in (-4.0, 1.5):
                painter.drawRect(QRectF(middle.x() + side, middle.y() - high, 2.5, 2.0 * high))
        else:
            for step in (-5.0, 0.0, 5.0):
                painter.drawEllipse(QRectF(middle.x() + step - 1.4, middle.y() - 1.4, 2.8, 2.8))
