"""Which gain moves a metric most, as bars to either side."""

import math
from collections.abc import Callable, Sequence

from PyQt6.QtCore import QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.analysis.replies import Weight
from workbench.gui.theme import Look
from workbench.gui.tuning.limit_table import Limit

PERCENT = 10.0
"""By so much more of a gain a bar is long."""
MOST = 8
LEAST = 0.02
"""Share of the longest bar below which a gain does nothing to speak of."""


def weight_text(weight: Weight, limit: Limit) -> str:
    """Return what a gain does, in words."""
    change = limit.factor * PERCENT * weight.slope
    decimals = limit.decimals + 1
    sign = "+" if change >= 0.0 else "−"
    number = f"{sign}{abs(change):.{decimals}f} {limit.unit}".rstrip()
    return f"{PERCENT:g} % more {weight.gain}: {limit.label.lower()} {number}"


def strongest(weights: Sequence[Weight]) -> tuple[Weight, ...]:
    """Return the gains that do something, the strongest first."""
    known = [weight for weight in weights if math.isfinite(weight.slope)]
    known.sort(key=lambda weight: -abs(weight.slope))
    if not known or known[0].slope == 0.0:
        return ()
    most = abs(known[0].slope)
    return tuple(weight for weight in known if abs(weight.slope) >= LEAST * most)[:MOST]


class WeightBars(QWidget):
    """Paints a bar for each gain: to the left where more of it makes the number smaller.

    Args:
        look: colours.
        words: from a gain's name to how it is called.
    """

    def __init__(self, look: Look, words: Callable[[str], str]) -> None:
        super().__init__()
        self._look, self._words = look, words
        self._weights: tuple[Weight, ...] = ()
        self._limit: Limit | None = None
        self.setMinimumHeight(120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("What each gain does to the metric")
        look.changed.connect(self.update)

    @property
    def texts(self) -> tuple[str, ...]:
        """What is shown, in words."""
        if self._limit is None:
            return ()
        return tuple(weight_text(weight, self._limit) for weight in self._weights)

    def show_weights(self, weights: Sequence[Weight], limit: Limit) -> None:
        """Show what gains do to a number."""
        self._weights, self._limit = strongest(weights), limit
        self.setAccessibleDescription("; ".join(self.texts))
        self.setToolTip("\n".join(self.texts))
        self.update()

    def sizeHint(self) -> QSize:
        """Return room for all bars."""
        return QSize(320, MOST * (self.fontMetrics().height() + 8))

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the bars, their names and their numbers."""
        painter = QPainter(self)
        colour = self._look.colour
        if not self._weights or self._limit is None:
            painter.setPen(colour("muted"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "Not known yet")
            return
        height = min(self.height() / len(self._weights), self.fontMetrics().height() + 12.0)
        names = [self._words(weight.gain) for weight in self._weights]
        label = max(self.fontMetrics().horizontalAdvance(name) for name in names) + 10.0
        numbers = [text.rsplit(" ", 2 if self._limit.unit else 1) for text in self.texts]
        shown = [" ".join(parts[1:]) for parts in numbers]
        number = max(self.fontMetrics().horizontalAdvance(text) for text in shown) + 10.0
        room = (self.width() - label - number) / 2.0
        most = abs(self._weights[0].slope)
        middle = label + room
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        for index, weight in enumerate(self._weights):
            top = index * height
            painter.setPen(colour("ink"))
            painter.drawText(QRectF(0.0, top, label, height), left, names[index])
            painter.drawText(QRectF(0.0, top, self.width(), height), right, shown[index])
            width = room * weight.slope / most
            bar = QRectF(middle, top + 0.28 * height, width, 0.44 * height).normalized()
            painter.fillRect(bar, self._look.curve(0 if weight.slope < 0.0 else 1))
        painter.setPen(colour("muted"))
        painter.drawLine(round(middle), 0, round(middle), round(len(self._weights) * height))
