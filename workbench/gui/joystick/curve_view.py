"""Draws the curve of the sticks: how far pushed along, how much asked for up."""

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen, QPixmap, QPolygonF
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.joystick.stick_curve import StickCurve
from workbench.gui.joystick.sticks import NEUTRAL, Sticks
from workbench.gui.theme import Look

POINTS = 81
DOT = 3.5


class CurveView(QWidget):
    """Raw against shaped, with a dot for each axis that is pushed.

    Args:
        look: colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._curve, self._sticks = StickCurve(), NEUTRAL
        self._ground = QPixmap()
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(130, 120)
        look.changed.connect(self._repaint)

    def sizeHint(self) -> QSize:
        """Return a small square."""
        return QSize(180, 170)

    def show_curve(self, curve: StickCurve) -> None:
        """Show a curve."""
        if curve != self._curve:
            self._curve = curve
            self._repaint()
        self.setAccessibleName(
            "Curve of the sticks: half stick asks for "
            f"{curve.shaped(0.5):.0%}, full stick for {curve.shaped(1.0):.0%}"
        )

    def show_sticks(self, sticks: Sticks) -> None:
        """Show where the sticks are on it."""
        if sticks != self._sticks:
            self._sticks = sticks
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        ratio = self.devicePixelRatioF()
        if self._ground.size() != (self.size().toSizeF() * ratio).toSize():
            self._paint_ground(ratio)
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._ground)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self._look.colour("card"), 1.0))
        painter.setBrush(self._look.colour("accent"))
        left, right = self._sticks.left, self._sticks.right
        for raw in (left.x, left.y, right.x, right.y):
            if raw != 0.0:
                painter.drawEllipse(self._at(raw, self._curve.shaped(raw)), DOT, DOT)

    @property
    def _box(self) -> QRectF:
        """The square from -1 to 1."""
        line = self.fontMetrics().height()
        side = max(20.0, min(self.width() - 4.0, self.height() - line - 6.0))
        return QRectF((self.width() - side) / 2, 2.0, side, side)

    def _at(self, raw: float, shaped: float) -> QPointF:
        box = self._box
        return QPointF(
            box.left() + (raw + 1.0) / 2 * box.width(),
            box.bottom() - (shaped + 1.0) / 2 * box.height(),
        )

    def _repaint(self) -> None:
        self._ground = QPixmap()
        self.update()

    def _paint_ground(self, ratio: float) -> None:
        self._ground = QPixmap((self.size().toSizeF() * ratio).toSize())
        self._ground.setDevicePixelRatio(ratio)
        self._ground.fill(Qt.GlobalColor.transparent)
        look, box = self._look, self._box
        painter = QPainter(self._ground)
        painter.setFont(self.font())
        painter.setPen(QPen(look.colour("line"), 1.0))
        painter.setBrush(look.colour("field"))
        painter.drawRect(box)
        dead = self._curve.dead_band
        painter.fillRect(QRectF(self._at(-dead, 1.0), self._at(dead, -1.0)), look.colour("line"))
        painter.drawLine(self._at(-1.0, 0.0), self._at(1.0, 0.0))
        painter.drawLine(self._at(0.0, -1.0), self._at(0.0, 1.0))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(look.colour("muted"), 1.0, Qt.PenStyle.DotLine))
        painter.drawLine(self._at(-1.0, -1.0), self._at(1.0, 1.0))
        painter.setPen(QPen(look.colour("accent"), 2.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        raws = np.linspace(-1.0, 1.0, POINTS)
        painter.drawPolyline(
            QPolygonF([self._at(raw, self._curve.shaped(raw)) for raw in raws.tolist()])
        )
        painter.setPen(look.colour("muted"))
        under = QRectF(0.0, box.bottom() + 3.0, self.width(), self.fontMetrics().height())
        painter.drawText(under, Qt.AlignmentFlag.AlignHCenter, "pushed → asked for ↑")
        painter.end()
