"""Small shapes that say how things are, so that no colour has to."""

from enum import Enum

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QPainter, QPen, QPolygonF


class Sign(Enum):
    """How something is; the value is the name of its colour."""

    GOOD = "good"
    """A full circle."""
    WARNING = "warning"
    """A triangle with a stroke."""
    BAD = "bad"
    """A square with a cross."""
    OFF = "muted"
    """An empty circle."""


def paint_sign(painter: QPainter, place: QRectF, sign: Sign, colour: QColor, on: QColor) -> None:
    """Paint a sign.

    Args:
        painter: with antialiasing.
        place: a square.
        sign: to paint.
        colour: of it.
        on: of what stands on it.
    """
    thickness = max(1.2, place.width() / 9.0)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    match sign:
        case Sign.GOOD:
            inset = 0.12 * place.width()
            painter.drawEllipse(place.adjusted(inset, inset, -inset, -inset))
        case Sign.OFF:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(colour, thickness))
            inset = 0.2 * place.width()
            painter.drawEllipse(place.adjusted(inset, inset, -inset, -inset))
        case Sign.WARNING:
            top = QPointF(place.center().x(), place.top())
            painter.drawPolygon(QPolygonF([top, place.bottomRight(), place.bottomLeft()]))
            painter.setPen(QPen(on, thickness))
            x, height = place.center().x(), place.height()
            painter.drawLine(
                QPointF(x, place.top() + 0.4 * height), QPointF(x, place.top() + 0.66 * height)
            )
            painter.drawPoint(QPointF(x, place.top() + 0.86 * height))
        case Sign.BAD:
            painter.drawRoundedRect(place, 0.15 * place.width(), 0.15 * place.width())
            painter.setPen(QPen(on, thickness))
            inset = 0.27 * place.width()
            inner = place.adjusted(inset, inset, -inset, -inset)
            painter.drawLine(inner.topLeft(), inner.bottomRight())
            painter.drawLine(inner.topRight(), inner.bottomLeft())
