"""Where the parts of a chart stand, and which pixel shows which value."""

from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QRectF, QSize
from PyQt6.QtGui import QFontMetrics

from workbench.gui.charts.scene import Axis, Scene

DIGITS = "\N{MINUS SIGN}00.00"
"""The widest number that an axis has as a rule."""
FARTHEST = 30000.0
"""From the chart that anything is drawn [pixels]."""


@dataclass(frozen=True)
class Layout:
    """Parts of a chart in logical pixels.

    Attributes:
        plot: where the curves are.
        axis_width: of one axis.
        gutter: right of the plot, for the numbers of the curves.
    """

    plot: QRectF
    axis_width: float
    gutter: float

    def axis_box(self, index: int) -> QRectF:
        """Return the place of an axis: the first left, the second right, then farther out."""
        out = index // 2
        if index % 2 == 0:
            left = self.plot.left() - (out + 1) * self.axis_width
        else:
            left = self.plot.right() + self.gutter + out * self.axis_width
        return QRectF(left, self.plot.top(), self.axis_width, self.plot.height())

    def x_of(self, scene: Scene, time: float) -> float:
        """Return the pixel of a time [s]."""
        return self.plot.left() + (time - scene.left) * self._x_scale(scene)

    def time_at(self, scene: Scene, x: float) -> float:
        """Return the time of a pixel [s]."""
        return scene.left + (x - self.plot.left()) / self._x_scale(scene)

    def y_of(self, axis: Axis, shown: float) -> float:
        """Return the pixel of a value as it is shown."""
        return self.plot.bottom() - (shown - axis.low) * self._y_scale(axis)

    def points(self, scene: Scene, axis: Axis, time: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the pixels of points in SI (n, 2)."""
        placed = np.empty((len(time), 2))
        np.subtract(time, scene.left, out=placed[:, 0])
        placed[:, 0] *= self._x_scale(scene)
        placed[:, 0] += self.plot.left()
        np.multiply(values, -axis.unit.factor * self._y_scale(axis), out=placed[:, 1])
        placed[:, 1] += self.plot.bottom() + axis.low * self._y_scale(axis)
        return placed.clip(-FARTHEST, FARTHEST, out=placed)

    def _x_scale(self, scene: Scene) -> float:
        return self.plot.width() / max(scene.right - scene.left, 1e-12)

    def _y_scale(self, axis: Axis) -> float:
        return self.plot.height() / max(axis.high - axis.low, 1e-300)


def make_layout(size: QSize, metrics: QFontMetrics, axes: int) -> Layout:
    """Return the layout of a chart of a size with so many axes."""
    width = metrics.horizontalAdvance(DIGITS) + 10.0
    line = metrics.height()
    gutter = metrics.horizontalAdvance("00") + 6.0
    left, right = max(1, (axes + 1) // 2) * width, (axes // 2) * width
    plot = QRectF(
        left,
        1.5 * line + 4.0,
        max(20.0, size.width() - left - right - gutter),
        max(20.0, size.height() - 2.5 * line - 12.0),
    )
    return Layout(plot, width, gutter)
