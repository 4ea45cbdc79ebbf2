"""What a chart's canvas shows at one time."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from PyQt6.QtGui import QColor

from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.ticks import Scale
from workbench.gui.units import Unit


@dataclass(frozen=True)
class Axis:
    """An axis of values.

    Attributes:
        unit: how its values are shown.
        low: its lower end, as shown.
        high: its upper end, as shown.
        label: beside its unit, "" for none.
    """

    unit: Unit
    low: float
    high: float
    label: str = ""


@dataclass(frozen=True, eq=False)
class Line:
    """A curve that is ready to be drawn.

    Attributes:
        time: of its points (n) [s].
        values: (n), in SI; NaN makes a gap.
        axis: number of its axis.
        colour: of its stroke.
        style: of its stroke.
        number: at its end, 0 for none.
    """

    time: np.ndarray
    values: np.ndarray
    axis: int
    colour: QColor
    style: CurveStyle = CurveStyle.SOLID
    number: int = 0


class Point(NamedTuple):
    """A dot on a curve: x as shown, y in SI, number of its axis, colour."""

    x: float
    y: float
    axis: int
    colour: QColor


@dataclass(frozen=True)
class Guide:
    """A straight line that says what curves are measured by, as a margin or a limit.

    Attributes:
        x: where it begins and ends below; infinite for the edge of the picture.
        y: the same along the first axis of values, in SI.
        colour: name of its colour in the look.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    colour: str = "muted"


@dataclass(frozen=True, eq=False)
class Content:
    """All of a chart.

    Attributes:
        left: first time that is seen [s]; of a chart over something else, its first value.
        right: last one [s].
        origin: time that is written as 0 below [s]; 0 where that axis is logarithmic.
        x_label: below.
        x_unit: behind the cursors' numbers.
        x_scale: of the axis below.
        y_scale: of all axes of values.
        axes: of values, the first one has the grid.
        lines: from the back to the front.
        points: dots that stay.
        guides: straight lines below the curves.
        caption: words above the picture, at its right; they are left out where there is no room.
        marks: name and time [s] of the cursors that stay.
        state: a word where the picture stands still, "" where it follows.
        hint: said where there is nothing to draw.
    """

    left: float = -1.0
    right: float = 0.0
    origin: float = 0.0
    x_label: str = ""
    x_unit: str = "s"
    x_scale: Scale = Scale.LINEAR
    y_scale: Scale = Scale.LINEAR
    axes: tuple[Axis, ...] = (Axis(Unit(""), 0.0, 1.0),)
    lines: tuple[Line, ...] = ()
    points: tuple[Point, ...] = ()
    guides: tuple[Guide, ...] = ()
    caption: str = ""
    marks: tuple[tuple[str, float], ...] = ()
    state: str = ""
    hint: str = ""
