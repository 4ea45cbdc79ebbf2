"""The content of a chart's canvas at one time."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from PyQt6.QtGui import QColor

from workbench.common.quantity import DisplayUnit
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.ticks import Scale


@dataclass(frozen=True)
class ChartAxis:
    """A value axis.

    Attributes:
        unit: unit in which its values are shown.
        low: its lower end, as shown.
        high: its upper end, as shown.
        label: name beside its unit, "" for none.
    """

    unit: DisplayUnit
    low: float
    high: float
    label: str = ""


@dataclass(frozen=True, eq=False)
class ChartLine:
    """A curve that is ready to draw.

    Attributes:
        time: times of its points (n) [s].
        values: (n), in SI; NaN makes a gap.
        axis: index of its axis.
        colour: colour of the curve.
        style: style of the curve.
        number: number at its end, 0 for none.
        name: name at its end if there is room, "" for none.
    """

    time: np.ndarray
    values: np.ndarray
    axis: int
    colour: QColor
    style: CurveStyle = CurveStyle.SOLID
    number: int = 0
    name: str = ""


class CurveDot(NamedTuple):
    """A dot on a curve: x as shown, y in SI, index of its axis, colour."""

    x: float
    y: float
    axis: int
    colour: QColor


@dataclass(frozen=True)
class ReferenceLine:
    """A straight reference line, as a margin or a limit.

    Attributes:
        x: its ends on the horizontal axis; infinite for the edge of the picture.
        y: its ends on the first value axis, in SI; a level along the whole axis is always in view.
        colour: name of its colour in the look.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    colour: str = "muted"

    @property
    def level(self) -> float | None:
        """Its level if it is along the whole horizontal axis."""
        whole = self.x == (-math.inf, math.inf) and self.y[0] == self.y[1]
        return self.y[0] if whole else None


@dataclass(frozen=True, eq=False)
class ChartContent:
    """The complete content of a chart.

    Attributes:
        left: first visible time [s]; or first visible value of another horizontal quantity.
        right: last visible time [s].
        origin: time shown as 0 [s]; 0 if that axis is logarithmic.
        x_label: name of the horizontal axis.
        x_unit: unit of the cursors' numbers.
        x_scale: scale of the horizontal axis.
        y_scale: scale of all value axes.
        axes: value axes; the first one has the grid.
        lines: curves from back to front.
        points: fixed dots.
        guides: straight lines below the curves.
        caption: text above the picture, at its right; left out if there is no room.
        marks: name and time [s] of cursors A and B.
        state: a word if the picture is paused, "" if it follows.
        hint: text if there is nothing to draw.
    """

    left: float = -1.0
    right: float = 0.0
    origin: float = 0.0
    x_label: str = ""
    x_unit: str = "s"
    x_scale: Scale = Scale.LINEAR
    y_scale: Scale = Scale.LINEAR
    axes: tuple[ChartAxis, ...] = (ChartAxis(DisplayUnit(""), 0.0, 1.0),)
    lines: tuple[ChartLine, ...] = ()
    points: tuple[CurveDot, ...] = ()
    guides: tuple[ReferenceLine, ...] = ()
    caption: str = ""
    marks: tuple[tuple[str, float], ...] = ()
    state: str = ""
    hint: str = ""
