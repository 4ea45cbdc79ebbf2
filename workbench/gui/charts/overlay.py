"""Paints what lies over the curves: their numbers, cursors, and why a picture stands still."""

from collections.abc import Sequence

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QColor, QPainter, QPen, QStaticText

from workbench.gui.charts.layout import Layout
from workbench.gui.charts.scene import Scene
from workbench.gui.charts.strokes import Stroke
from workbench.gui.charts.ticks import number_text
from workbench.gui.charts.window_statistics import value_at
from workbench.gui.theme import Look

_CENTRE = Qt.AlignmentFlag.AlignCenter
DOT = 3.0
"""Radius of the dots where a cursor meets a curve [pixels]."""


class Overlay:
    """Draws over a chart.

    Args:
        look: colours.
    """

    def __init__(self, look: Look) -> None:
        self._look = look
        self._numbers: dict[int, QStaticText] = {}

    def paint_numbers(self, painter: QPainter, strokes: Sequence[Stroke], layout: Layout) -> None:
        """Write each curve's number at its end, so that colour is not all that tells them."""
        line, plot = painter.fontMetrics().height(), layout.plot
        ended = [(s.end.y(), s) for s in strokes if s.number and s.end is not None]
        ended.sort(key=lambda each: each[0])
        heights = spread([y for y, _ in ended], plot.top(), plot.bottom(), 0.8 * line)
        for y, (_, stroke) in zip(heights, ended, strict=True):
            painter.setPen(stroke.pen)
            place = QPointF(plot.right() + 4.0, y - 0.5 * line)
            painter.drawStaticText(place, self._number(stroke.number))

    def _number(self, number: int) -> QStaticText:
        """Return a number that is laid out once."""
        if number not in self._numbers:
            self._numbers[number] = QStaticText(str(number))
        return self._numbers[number]

    def paint_cursor(self, painter: QPainter, scene: Scene, layout: Layout, time: float) -> None:
        """Draw the crosshair, with a dot on every curve."""
        self._paint_line(painter, scene, layout, time, "ink", "")
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for line in scene.lines:
            value = value_at(line.time, line.values, time)
            if value == value:
                axis = scene.axes[line.axis]
                place = QPointF(layout.x_of(scene, time), layout.y_of(axis, axis.unit.shown(value)))
                if layout.plot.contains(place):
                    painter.setPen(QPen(self._look.colour("field"), 1))
                    painter.setBrush(QColor(line.colour))
                    painter.drawEllipse(place, DOT, DOT)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)

    def paint_marks(self, painter: QPainter, scene: Scene, layout: Layout) -> None:
        """Draw the cursors that stay."""
        for mark in scene.marks:
            self._paint_line(painter, scene, layout, mark.time, "accent", mark.name)

    def paint_state(self, painter: QPainter, state: str, layout: Layout) -> None:
        """Say why the picture does not move."""
        metrics = painter.fontMetrics()
        width = metrics.horizontalAdvance(state) + 14
        box = QRectF(layout.plot.left() + 6, layout.plot.top() + 5, width, metrics.height() + 4)
        painter.fillRect(box, self._look.colour("accent"))
        painter.setPen(self._look.colour("on_accent"))
        painter.drawText(box, _CENTRE, state)

    def _paint_line(
        self, painter: QPainter, scene: Scene, layout: Layout, time: float, ink: str, name: str
    ) -> None:
        plot, metrics = layout.plot, painter.fontMetrics()
        x = layout.x_of(scene, time)
        if not plot.left() <= x <= plot.right():
            return
        colour = self._look.colour(ink)
        painter.setPen(QPen(colour, 0, Qt.PenStyle.DotLine if not name else Qt.PenStyle.SolidLine))
        painter.drawLine(QPointF(x, plot.top()), QPointF(x, plot.bottom()))
        text = f"{name} {number_text(time - scene.origin, 3)}\N{NO-BREAK SPACE}s".strip()
        width = metrics.horizontalAdvance(text) + 8
        left = min(max(x - 0.5 * width, plot.left()), plot.right() - width)
        box = QRectF(left, plot.bottom() + 2, width, metrics.height() + 2)
        painter.fillRect(box, colour)
        painter.setPen(self._look.colour("on_accent" if name else "card"))
        painter.drawText(box, _CENTRE, text)


def spread(places: Sequence[float], low: float, high: float, gap: float) -> list[float]:
    """Return rising places moved apart, as far as there is room between two ends."""
    gap = min(gap, (high - low) / max(1, len(places) - 1))
    found: list[float] = []
    for place in places:
        least = found[-1] + gap if found else low
        found.append(min(max(place, least), high))
    for index in range(len(found) - 2, -1, -1):
        found[index] = min(found[index], found[index + 1] - gap)
    return found
