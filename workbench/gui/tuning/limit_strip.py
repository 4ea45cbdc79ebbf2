"""How near a response comes to the flight's limits: three small charts in shares of each limit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent, QPen, QPolygonF
from PyQt6.QtWidgets import QSizePolicy, QWidget
from pyqtgraph.functions import arrayToQPolygonF

from workbench.gui.theme import Look
from workbench.gui.tuning.marks import TONES, draw_mark
from workbench.gui.tuning.table_rows import State
from workbench.gui.units import Unit

ROOM = 1.15
"""Share of a limit at the upper edge."""
NEAR = 0.999
"""From this share on, a limit is reached."""
GAP = 12.0
MARK = 8.0


@dataclass(frozen=True)
class Use:
    """How much of a limit is used over time.

    Attributes:
        label: of what.
        time: (N) from the edge on [s].
        value: (N), in SI.
        limit: in SI.
        unit: how both are shown.
        decimals: as shown.
    """

    label: str
    time: np.ndarray
    value: np.ndarray
    limit: float
    unit: Unit
    decimals: int = 0

    @property
    def peak(self) -> float:
        """Largest size so far; NaN before the first."""
        return float(np.abs(self.value).max()) if len(self.value) else float("nan")

    @property
    def state(self) -> State:
        """Whether the limit was reached."""
        if not len(self.value):
            return State.NONE
        return State.OVER if self.peak >= NEAR * self.limit else State.GOOD

    @property
    def text(self) -> str:
        """Peak and limit in words."""
        plain = Unit("", self.unit.factor).text(self.peak, self.decimals)
        return f"{plain} of {self.unit.text(self.limit, self.decimals)}"


class LimitStrip(QWidget):
    """Charts side by side, each with its limit as a line and the peak as a number.

    Args:
        look: colours.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self._uses: tuple[Use, ...] = ()
        self._length = 1.0
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName("Use of the flight's limits")
        look.changed.connect(self.update)

    @property
    def uses(self) -> tuple[Use, ...]:
        """What is shown."""
        return self._uses

    def show_uses(self, uses: Sequence[Use], length: float) -> None:
        """Show these over a time [s]."""
        self._uses, self._length = tuple(uses), max(length, 1e-3)
        self.update()

    def describe(self) -> None:
        """Say in words what is shown: once a response is over, not with every frame."""
        self.setAccessibleDescription("; ".join(f"{use.label} {use.text}" for use in self._uses))

    def sizeHint(self) -> QSize:
        """Return room for a line of text and a chart."""
        return QSize(320, 2 * self.fontMetrics().height() + 22)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the charts."""
        if not self._uses:
            return
        painter = QPainter(self)
        width = (self.width() - GAP * (len(self._uses) - 1)) / len(self._uses)
        for index, use in enumerate(self._uses):
            self._paint_use(painter, QRectF(index * (width + GAP), 0.0, width, self.height()), use)

    def _paint_use(self, painter: QPainter, box: QRectF, use: Use) -> None:
        colour = self._look.colour
        line = float(self.fontMetrics().height())
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.setPen(colour("muted"))
        painter.drawText(QRectF(box.left(), box.top(), box.width(), line), left, use.label)
        tone = colour("warning" if use.state is State.OVER else "ink")
        painter.setPen(tone)
        second = QRectF(box.left(), box.top() + line, box.width() - 2.0 * MARK, line)
        painter.drawText(second, left, use.text)
        if use.state is not State.NONE:
            mark = QRectF(box.right() - MARK, second.center().y() - MARK / 2.0, MARK, MARK)
            draw_mark(painter, mark, use.state, colour(TONES[use.state]))
        chart = box.adjusted(0.0, 2.0 * line + 2.0, 0.0, -1.0)
        painter.fillRect(chart, colour("ground"))
        top = chart.bottom() - chart.height() / ROOM
        painter.setPen(QPen(colour("warning"), 1, Qt.PenStyle.DashLine))
        painter.drawLine(QPointF(chart.left(), top), QPointF(chart.right(), top))
        if len(use.time) > 1:
            painter.setPen(QPen(tone, 1))
            painter.drawPolyline(self._line(chart, use))

    def _line(self, chart: QRectF, use: Use) -> QPolygonF:
        skip = max(1, len(use.time) // max(1, int(chart.width())))
        share = np.minimum(np.abs(use.value) / use.limit, ROOM)
        # The largest of every few samples: a peak must not fall between two pixels.
        size = len(share) // skip * skip
        peaks = share[:size].reshape(-1, skip).max(axis=1)
        times = use.time[:size:skip] / self._length
        x = chart.left() + np.clip(times, 0.0, 1.0) * chart.width()
        y = chart.bottom() - peaks / ROOM * chart.height()
        return arrayToQPolygonF(x, y)
