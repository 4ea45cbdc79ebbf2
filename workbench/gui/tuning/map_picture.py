"""The picture of a map: colours, lines of equal value, what was lost, and the axes."""

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QBrush, QColor, QFont, QFontMetrics, QPainter, QPen

from workbench.analysis.replies import Mapped
from workbench.gui.charts.colour_scale import colour_table, colours_of, image_of
from workbench.gui.theme import Look
from workbench.gui.tuning.contours import Segment, contour_levels, contour_segments, value_range
from workbench.gui.tuning.map_grid import MapGrid

LINES = 6
"""About so many lines of equal value."""
LONG = 6
"""Pieces of a line that has a number."""


class MapPicture:
    """Paints a map once; it is kept as a pixmap by who shows it.

    Args:
        mapped: the map.
        grid: where its points stand.
        look: colours of what is around it.
        font: of its numbers.
    """

    def __init__(self, mapped: Mapped, grid: MapGrid, look: Look, font: QFont) -> None:
        self._mapped, self._grid, self._look, self._font = mapped, grid, look, font

    def paint(self, painter: QPainter) -> None:
        """Paint it all."""
        values = self._mapped.values
        low, high = value_range(values)
        known = np.where(np.isfinite(values), values, low)
        colours = colours_of(known, low, high, colour_table())
        painter.drawImage(self._grid.box, image_of(colours[::-1]))
        self._hatch(painter, self._grid.box)
        self._paint_lines(painter)
        self._paint_axes(painter, self._grid.box)

    def _hatch(self, painter: QPainter, box: QRectF) -> None:
        """Cover what was lost, or never got there."""
        rows, columns = self._mapped.values.shape
        width, height = box.width() / columns, box.height() / rows
        lines = QBrush(self._look.colour("bad"), Qt.BrushStyle.BDiagPattern)
        for row, column in zip(*np.nonzero(~np.isfinite(self._mapped.values)), strict=True):
            cell = QRectF(
                box.left() + column * width, box.bottom() - (row + 1) * height, width, height
            )
            painter.fillRect(cell, self._look.colour("field"))
            painter.fillRect(cell, lines)

    def _paint_lines(self, painter: QPainter) -> None:
        values, factor = self._mapped.values, 100.0 if self._mapped.unit == "1" else 1.0
        small = QFont(self._font)
        small.setWeight(QFont.Weight.DemiBold)
        painter.setFont(small)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        taken: list[QPointF] = []
        for level in contour_levels(*value_range(values), LINES):
            pieces = contour_segments(values, level)
            for pen in (QPen(QColor(0, 0, 0, 110), 2.0), QPen(QColor(255, 255, 255, 210), 1.0)):
                painter.setPen(pen)
                for x0, y0, x1, y1 in pieces:
                    painter.drawLine(self._grid.cell(x0, y0), self._grid.cell(x1, y1))
            if len(pieces) >= LONG:
                self._label(painter, f"{level * factor:.3g}", pieces, taken)

    def _label(
        self,
        painter: QPainter,
        text: str,
        pieces: list[Segment],
        taken: list[QPointF],
    ) -> None:
        """Write a value on its line, where no other one stands."""
        box = self._grid.box
        for x, y, *_ in sorted(pieces, key=lambda piece: abs(piece[0] - piece[1])):
            at = self._grid.cell(x, y)
            inside = box.adjusted(16.0, 8.0, -16.0, -8.0).contains(at)
            if inside and all((at - other).manhattanLength() > 34.0 for other in taken):
                taken.append(at)
                place = QRectF(at.x() - 24.0, at.y() - 9.0, 48.0, 18.0)
                painter.setPen(QColor(0, 0, 0, 170))
                for way in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
                    shifted = place.translated(QPointF(*map(float, way)))
                    painter.drawText(shifted, Qt.AlignmentFlag.AlignCenter, text)
                painter.setPen(QColor("white"))
                painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)
                return

    def _paint_axes(self, painter: QPainter, box: QRectF) -> None:
        painter.setFont(self._font)
        painter.setPen(self._look.colour("muted"))
        line = QFontMetrics(self._font).height()
        for share in (0.0, 0.5, 1.0):
            x = self._mapped.x[round(share * (len(self._mapped.x) - 1))]
            y = self._mapped.y[round(share * (len(self._mapped.y) - 1))]
            wide = QRectF(box.left() + share * box.width() - 40.0, box.bottom() + 2.0, 80.0, line)
            wide.moveLeft(min(max(wide.left(), box.left() - 40.0 * share), box.right() - 40.0))
            side = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter)[share > 0.0]
            if share == 1.0:
                wide.moveRight(box.right())
                side = Qt.AlignmentFlag.AlignRight
            elif share == 0.0:
                wide.moveLeft(box.left())
            painter.drawText(wide, side, f"{x:.3g}")
            top = box.bottom() - share * box.height()
            tall = QRectF(0.0, top - share * line, box.left() - 5.0, line)
            tall.moveTop(min(max(top - 0.5 * line, box.top()), box.bottom() - line))
            painter.drawText(tall, Qt.AlignmentFlag.AlignRight, f"{y:.3g}")
