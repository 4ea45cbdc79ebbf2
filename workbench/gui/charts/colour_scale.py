"""A colour map with numbers beside it."""

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QImage, QPainter

from workbench.gui.charts.ticks import make_ticks

WIDTH = 12.0
"""Of the strip of colours [pixels]."""


def image_of(colours: np.ndarray) -> QImage:
    """Return a picture of colours 0xffrrggbb (height, width); it has its own memory."""
    height, width = colours.shape
    data = np.ascontiguousarray(colours, dtype=np.uint32)
    return QImage(data.tobytes(), width, height, 4 * width, QImage.Format.Format_RGB32).copy()


def paint_scale(
    painter: QPainter,
    box: QRectF,
    low: float,
    high: float,
    table: np.ndarray,
    ink: QColor,
    name: str,
) -> None:
    """Paint a scale upright.

    Args:
        painter: on what.
        box: where; the strip stands at its left.
        low: value at the lower end.
        high: at the upper one.
        table: colours from low to high.
        ink: of the numbers.
        name: with the unit, above.
    """
    line = painter.fontMetrics().height()
    strip = QRectF(box.left(), box.top() + line + 4, WIDTH, box.height() - line - 4 - 0.5 * line)
    painter.drawImage(strip, image_of(table[::-1, None]))
    painter.setPen(ink)
    left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
    painter.drawText(QRectF(box.left(), box.top(), box.width(), line), left, name)
    ticks = make_ticks(low, high, max(2, int(strip.height() / 40)))
    span = max(high - low, 1e-9)
    for value, text in zip(ticks.values, ticks.texts(), strict=True):
        y = strip.bottom() - (value - low) / span * strip.height()
        painter.drawLine(QPointF(strip.right(), y), QPointF(strip.right() + 3, y))
        place = QRectF(strip.right() + 6, y - 0.5 * line, box.width() - WIDTH - 6, line)
        painter.drawText(place, left, text)
