"""The use of limits over time, as a strip of small charts."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen, QPolygonF
from PyQt6.QtWidgets import QSizePolicy, QWidget
from pyqtgraph.functions import arrayToQPolygonF

from workbench.common.quantity import DisplayUnit
from workbench.gui.theme import Look
from workbench.gui.tuning.number_row import RowState

STRIP_TOP_FACTOR = 1.15
"""Upper edge of a chart, as a multiple of its limit."""
REACHED_LIMIT_SHARE = 0.999
"""Share of a limit at which it counts as reached."""
STRIP_GAP_PX = 12.0


@dataclass(frozen=True)
class LimitUse:
    """Use of a limit over time.

    Attributes:
        label: name of the quantity.
        time: (N) time from the edge on [s].
        value: (N) values, in SI.
        limit: limit, in SI.
        unit: unit in which both are shown.
    """

    label: str
    time: np.ndarray
    value: np.ndarray
    limit: float
    unit: DisplayUnit

    @property
    def peak(self) -> float:
        """Largest magnitude so far; NaN before the first value."""
        return float(np.abs(self.value).max()) if len(self.value) else float("nan")

    @property
    def state(self) -> RowState:
        """Whether the limit was reached."""
        if not len(self.value):
            return RowState.NONE
        return RowState.OVER if self.peak >= REACHED_LIMIT_SHARE * self.limit else RowState.GOOD

    @property
    def text(self) -> str:
        """Peak and limit in words."""
        return f"{self.unit.number(self.peak)} of {self.unit.text(self.limit)}"


class LimitStrip(QWidget):
    """Charts side by side, each with its limit as a line and its peak as a number.

    Args:
        look: source of colours.

    Attributes:
        uses: the shown quantities.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.uses: tuple[LimitUse, ...] = ()
        self._length = 1.0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName("Use of the flight's limits")
        look.changed.connect(self.update)

    def show_uses(self, uses: Sequence[LimitUse], length: float) -> None:
        """Show quantities over a time [s]."""
        self.uses, self._length = tuple(uses), max(length, 1e-3)
        self.update()

    def describe(self) -> None:
        """Describe the charts in words: after a response, not with every frame."""
        self.setAccessibleDescription("; ".join(f"{use.label} {use.text}" for use in self.uses))

    def sizeHint(self) -> QSize:
        """Return the size of two lines of text and a chart."""
        return QSize(320, 2 * self.fontMetrics().height() + 22)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the charts."""
        if not self.uses:
            return
        painter = QPainter(self)
        width = (self.width() - STRIP_GAP_PX * (len(self.uses) - 1)) / len(self.uses)
        for index, use in enumerate(self.uses):
            self._paint_use(
                painter, QRectF(index * (width + STRIP_GAP_PX), 0.0, width, self.height()), use
            )

    def _paint_use(self, painter: QPainter, box: QRectF, use: LimitUse) -> None:
        colour = self._look.colour
        line = float(self.fontMetrics().height())
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.setPen(colour("muted"))
        first = QRectF(box.left(), box.top(), box.width(), line)
        painter.drawText(first, left, use.state.with_shape(use.label))
        tone = colour("warning" if use.state is RowState.OVER else "ink")
        painter.setPen(tone)
        second = QRectF(box.left(), box.top() + line, box.width(), line)
        painter.drawText(second, left, use.text)
        chart = box.adjusted(0.0, 2.0 * line + 2.0, 0.0, -1.0)
        painter.fillRect(chart, colour("ground"))
        top = chart.bottom() - chart.height() / STRIP_TOP_FACTOR
        painter.setPen(QPen(colour("warning"), 1, Qt.PenStyle.DashLine))
        painter.drawLine(QPointF(chart.left(), top), QPointF(chart.right(), top))
        if len(use.time) > 1:
            painter.setPen(QPen(tone, 1))
            painter.drawPolyline(self._line(chart, use))

    def _line(self, chart: QRectF, use: LimitUse) -> QPolygonF:
        skip = max(1, len(use.time) // max(1, int(chart.width())))
        share = np.minimum(np.abs(use.value) / use.limit, STRIP_TOP_FACTOR)
        # The largest of several samples, so that no peak is lost between two pixels.
        size = len(share) // skip * skip
        peaks = share[:size].reshape(-1, skip).max(axis=1)
        times = use.time[:size:skip] / self._length
        x = chart.left() + np.clip(times, 0.0, 1.0) * chart.width()
        y = chart.bottom() - peaks / STRIP_TOP_FACTOR * chart.height()
        return arrayToQPolygonF(x, y)
