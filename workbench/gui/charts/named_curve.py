"""A finished curve with a name."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from workbench.gui.charts.curve_style import CurveStyle


@dataclass(frozen=True, eq=False)
class NamedCurve:
    """A curve of a plot.

    Attributes:
        name: in the legend.
        time: of its samples (n), rising [s].
        values: (n), in SI.
        style: of its stroke.
        colour: number of its colour.
        visible: whether it is drawn.
    """

    name: str
    time: np.ndarray
    values: np.ndarray
    style: CurveStyle
    colour: int
    visible: bool

    def cut(self, left: float, right: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the samples from a time to another [s], and one more at either side."""
        first = max(0, int(np.searchsorted(self.time, left)) - 1)
        last = int(np.searchsorted(self.time, right, side="right")) + 1
        return self.time[first:last], self.values[first:last]

    def toggled(self) -> "NamedCurve":
        """Return it hidden, or shown again."""
        return dataclasses.replace(self, visible=not self.visible)
