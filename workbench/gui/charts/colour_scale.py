"""Values as colours, and their colour scale."""

import math

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QImage, QPainter
from pyqtgraph import colormap

from workbench.gui.charts.ticks import decimals_for_step, number_text, round_step

WIDTH = 12.0
"""Width of the strip of colours [pixels]."""
STEPS = 256


def colour_table(first: float = 0.0, last: float = 1.0) -> np.ndarray:
    """Return 256 colours as 0xffrrggbb (256), from a part of the colour map "viridis".

    The map is perceptually uniform, also for colour-blind users and in grey.

    Args:
        first: start of the part; 0 is dark blue.
        last: end of the part; 1 is yellow.
    """
    table = colormap.get("viridis").getLookupTable(first, last, STEPS, alpha=False)
    return colour_words(table)


def colour_words(colours: np.ndarray) -> np.ndarray:
    """Return red, green and blue bytes (..., 3) as colours 0xffrrggbb."""
    red, green, blue = np.moveaxis(colours.astype(np.uint32), -1, 0)
    words: np.ndarray = np.uint32(0xFF000000) | red << 16 | green << 8 | blue
    return words


def colours_of(values: np.ndarray, low: float, high: float, table: np.ndarray) -> np.ndarray:
    """Return the colours of values between two ends; values beyond are clipped."""
    span = max(high - low, 1e-9)
    places = np.clip((values - low) * ((STEPS - 1) / span), 0, STEPS - 1)
    return table[places.astype(np.intp)]


def image_of(colours: np.ndarray) -> QImage:
    """Return an image of colours 0xffrrggbb (height, width); it owns its memory."""
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
    """Paint a vertical scale.

    Args:
        painter: the painter.
        box: area; the strip is at its left.
        low: value at the lower end.
        high: value at the upper end.
        table: colours from low to high.
        ink: colour of the numbers.
        name: text above, with the unit.
    """
    line = painter.fontMetrics().height()
    strip = QRectF(box.left(), box.top() + line + 4, WIDTH, box.height() - line - 4 - 0.5 * line)
    painter.drawImage(strip, image_of(table[::-1, None]))
    painter.setPen(ink)
    left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
    painter.drawText(QRectF(box.left(), box.top(), box.width(), line), left, name)
    span = max(high - low, 1e-9)
    step = round_step(span, max(2, int(strip.height() / 40)))
    for number in range(math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6) + 1):
        y = strip.bottom() - (number * step - low) / span * strip.height()
        painter.drawLine(QPointF(strip.right(), y), QPointF(strip.right() + 3, y))
        place = QRectF(strip.right() + 6, y - 0.5 * line, box.width() - WIDTH - 6, line)
        painter.drawText(place, left, number_text(number * step, decimals_for_step(step)))
