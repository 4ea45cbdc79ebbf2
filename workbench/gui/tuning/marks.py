"""Shapes that stand for a state beside its word, so that no state is told by colour alone."""

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QPainter, QPen, QPolygonF

from workbench.gui.tuning.table_rows import State

TONES = {
    State.GOOD: "good",
    State.OVER: "warning",
    State.LOW: "warning",
    State.MISSED: "warning",
    State.BROKEN: "bad",
    State.WAITING: "muted",
    State.NONE: "muted",
}


def draw_mark(painter: QPainter, box: QRectF, state: State, colour: QColor) -> None:
    """Draw a tick for what is well, a triangle for what is over or low, a cross for what breaks."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    pen = QPen(colour, 1.8, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
    painter.setPen(pen)
    x, y, size = box.center().x(), box.center().y(), min(box.width(), box.height()) / 2.0
    if state is State.GOOD:
        painter.drawPolyline(
            QPolygonF(
                [
                    QPointF(x - size, y),
                    QPointF(x - 0.3 * size, y + 0.7 * size),
                    QPointF(x + size, y - 0.7 * size),
                ]
            )
        )
    elif state in (State.OVER, State.LOW):
        way = -1.0 if state is State.OVER else 1.0
        painter.setBrush(colour)
        painter.drawPolygon(
            QPolygonF(
                [
                    QPointF(x, y + 0.8 * way * size),
                    QPointF(x - 0.9 * size, y - 0.7 * way * size),
                    QPointF(x + 0.9 * size, y - 0.7 * way * size),
                ]
            )
        )
    elif state in (State.BROKEN, State.MISSED):
        painter.drawLine(QPointF(x - size, y - size), QPointF(x + size, y + size))
        painter.drawLine(QPointF(x - size, y + size), QPointF(x + size, y - size))
    painter.restore()
