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

    def toggled(self) -> "NamedCurve":
        """Return it hidden, or shown again."""
        return dataclasses.replace(self, visible=not self.visible)
