"""A shape for each flight mode."""

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QPainter, QPen, QPolygonF

from workbench.control.mode import FlightMode

UP = ((0.5, 0.08), (0.95, 0.62), (0.05, 0.62))
DOWN = ((0.5, 0.92), (0.95, 0.38), (0.05, 0.38))
ALONG = ((0.92, 0.5), (0.38, 0.95), (0.38, 0.05))
DIAMOND = ((0.5, 0.05), (0.95, 0.5), (0.5, 0.95), (0.05, 0.5))
"""Corners in a square of side 1, from its top left."""


def paint_mode(painter: QPainter, place: QRectF, mode: FlightMode, colour: QColor) -> None:
    """Paint the shape of a mode.

    Off is an empty circle, armed one with a dot; hovering a diamond; climbing a triangle up, with
    the ground under it at a take-off; so downwards; cruising a triangle to the right.

    Args:
        painter: with antialiasing.
        place: a square.
        mode: to paint.
        colour: of it.
    """
    thick = QPen(colour, max(1.5, place.width() / 11.0))
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(colour)
    match mode:
        case FlightMode.OFF | FlightMode.ARMED:
            inset = 0.14 * place.width()
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(thick)
            painter.drawEllipse(place.adjusted(inset, inset, -inset, -inset))
            if mode is FlightMode.ARMED:
                painter.setBrush(colour)
                painter.drawEllipse(place.center(), inset, inset)
        case FlightMode.HOVERING:
            _paint_corners(painter, place, DIAMOND)
        case FlightMode.CRUISING:
            _paint_corners(painter, place, ALONG)
        case FlightMode.TAKING_OFF | FlightMode.ASCENDING:
            _paint_corners(painter, place, UP)
        case FlightMode.LANDING | FlightMode.DESCENDING:
            _paint_corners(painter, place.translated(0.0, -0.1 * place.height()), DOWN)
    if mode in (FlightMode.TAKING_OFF, FlightMode.LANDING):
        painter.setPen(thick)
        y = place.top() + 0.93 * place.height()
        painter.drawLine(QPointF(place.left(), y), QPointF(place.right(), y))


def _paint_corners(
    painter: QPainter, place: QRectF, corners: tuple[tuple[float, float], ...]
) -> None:
    painter.drawPolygon(
        QPolygonF(
            [
                QPointF(place.left() + x * place.width(), place.top() + y * place.height())
                for x, y in corners
            ]
        )
    )
