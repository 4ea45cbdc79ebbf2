"""Paints what stands still behind the curves: field, grid, axes and limits."""

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QPainter, QPen

from workbench.gui.charts.layout import Layout
from workbench.gui.charts.scene import Axis, Limit, Scene
from workbench.gui.charts.ticks import Ticks, make_ticks
from workbench.gui.theme import Look

ROW = 27.0
"""Between two marks of the value axis [pixels]."""
COLUMN = 62.0
"""Between two marks of the time axis [pixels]."""
MOST_ROWS = 8

_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_CENTRE = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignVCenter


class Background:
    """Draws grid and axes of a scene into whatever a painter paints on.

    Args:
        look: colours.
    """

    def __init__(self, look: Look) -> None:
        self._look = look

    def paint(self, painter: QPainter, scene: Scene, layout: Layout) -> None:
        """Paint."""
        plot = layout.plot
        painter.fillRect(plot, self._look.colour("field"))
        self._paint_time(painter, scene, layout)
        for index, axis in enumerate(scene.axes):
            self._paint_axis(painter, axis, index, layout)
        for limit in scene.limits:
            if limit.axis < len(scene.axes):
                self._paint_limit(painter, limit, scene.axes[limit.axis], layout)
        painter.setPen(QPen(self._look.colour("line"), 0))
        painter.drawRect(plot)
        if not scene.lines and scene.hint:
            self._paint_hint(painter, scene.hint, plot.adjusted(12, 0, -12, 0))

    def _paint_hint(self, painter: QPainter, hint: str, room: QRectF) -> None:
        """Say what is to be done, on a ground that hides the grid."""
        flags = int(_CENTRE | Qt.TextFlag.TextWordWrap)
        painter.setPen(self._look.colour("muted"))
        place = painter.boundingRect(room, flags, hint)
        painter.fillRect(place.adjusted(-6, -3, 6, 3), self._look.colour("field"))
        painter.drawText(room, flags, hint)

    def _paint_time(self, painter: QPainter, scene: Scene, layout: Layout) -> None:
        plot, line = layout.plot, painter.fontMetrics().height()
        count = max(2, int(plot.width() / COLUMN))
        ticks = make_ticks(scene.left - scene.origin, scene.right - scene.origin, count)
        places = [layout.x_of(scene, value + scene.origin) for value in ticks.values]
        painter.setPen(QPen(self._look.colour("line"), 0))
        for x in places:
            painter.drawLine(QPointF(x, plot.top()), QPointF(x, plot.bottom()))
        painter.setPen(self._look.colour("muted"))
        label_width = painter.fontMetrics().horizontalAdvance(scene.x_label)
        edge = plot.right() + layout.gutter
        for x, text in zip(places, ticks.texts(), strict=True):
            half = 0.5 * painter.fontMetrics().horizontalAdvance(text)
            if x + half > edge - label_width - 8.0:
                continue  # the axis's name stands there
            painter.drawText(QRectF(x - 60, plot.bottom() + 3, 120, line), _CENTRE, text)
        box = QRectF(edge - label_width - 4, plot.bottom() + 3, label_width + 4, line)
        painter.drawText(box, _RIGHT, scene.x_label)

    def _paint_axis(self, painter: QPainter, axis: Axis, index: int, layout: Layout) -> None:
        plot, box = layout.plot, layout.axis_box(index)
        line = painter.fontMetrics().height()
        flags = _RIGHT if index % 2 == 0 else _LEFT
        ticks = axis_ticks(axis, layout)
        for value, text in zip(ticks.values, ticks.texts(), strict=True):
            y = layout.y_of(axis, value)
            if index == 0:
                is_zero = abs(value) < 1e-9 * (axis.high - axis.low)
                painter.setPen(QPen(self._look.colour("command" if is_zero else "line"), 0))
                painter.drawLine(QPointF(plot.left(), y), QPointF(plot.right(), y))
            painter.setPen(self._look.colour("muted"))
            place = QRectF(box.left() + 5, y - 0.5 * line, box.width() - 10, line)
            painter.drawText(place, flags, text)
        name = " ".join(part for part in (axis.label, axis.unit.symbol) if part)
        painter.setPen(self._look.colour("ink"))
        top = plot.top() - 1.5 * line - 2  # clear of the uppermost number
        if index % 2 == 0:
            left = 5.0 if index >= 2 or axis.label else box.left() + 5
            width = 260.0 if axis.label else box.width() - 10
            painter.drawText(
                QRectF(left, top, width, line), _LEFT if axis.label else _RIGHT, name or "–"
            )
        else:
            painter.drawText(QRectF(box.left() + 5, top, box.width() - 5, line), _LEFT, name or "–")

    def _paint_limit(self, painter: QPainter, limit: Limit, axis: Axis, layout: Layout) -> None:
        y, plot = layout.y_of(axis, axis.unit.shown(limit.value)), layout.plot
        if not plot.top() <= y <= plot.bottom():
            return
        line = painter.fontMetrics().height()
        painter.setPen(QPen(self._look.colour("bad"), 0, Qt.PenStyle.DashDotLine))
        painter.drawLine(QPointF(plot.left(), y), QPointF(plot.right(), y))
        above = y - line - 1 >= plot.top()
        place = QRectF(plot.left() + 6, y - line - 1 if above else y + 1, plot.width() - 12, line)
        painter.drawText(place, _RIGHT, limit.label)


def axis_ticks(axis: Axis, layout: Layout) -> Ticks:
    """Return the marks of an axis of values."""
    count = min(MOST_ROWS, max(2, int(layout.plot.height() / ROW)))
    return make_ticks(axis.low, axis.high, count)
