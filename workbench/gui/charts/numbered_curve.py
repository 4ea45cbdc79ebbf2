"""A curve with its name at its end, and the heights of the names of several curves."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pyqtgraph as pg
from PyQt6.QtGui import QColor
from PyQt6.QtWidgets import QGraphicsSimpleTextItem

from workbench.common.plain_text import plain_name
from workbench.gui.charts.content import ChartLine
from workbench.gui.charts.curve import CurveStyle, make_pen
from workbench.gui.charts.ticks import Scale

CURVE_NUMBER_SPACE_PX = 22
"""Space to the right of the curves for their numbers [pixels]."""
MAX_CURVE_NAME_SHARE = 0.2
"""Largest share of the width for the curves' names; if they are wider, only numbers are shown."""
MEASURED_POINT_PX = 5.0
"""Diameter of a measured point [layout pixels]."""


class NumberedCurve(pg.PlotCurveItem):
    """A curve with its number or name at its end, so that curves differ in more than colour.

    Attributes:
        end: the text at its end, in pixels of the graphics scene.
    """

    def __init__(self) -> None:
        # separate lines are the only ones wider than a pixel that Qt paints fast
        super().__init__(skipFiniteCheck=True, antialias=True, segmentedLineMode="on")
        self.end = QGraphicsSimpleTextItem()
        self._points: pg.ScatterPlotItem | None = None
        self._drawn_as: tuple[object, ...] = ()

    def show_line(
        self, line: ChartLine, ground: QColor, ratio: float, x_scale: Scale, y_scale: Scale
    ) -> None:
        """Draw a line.

        Args:
            line: the line.
            ground: colour of the background.
            ratio: screen pixels per layout pixel.
            x_scale: scale of the horizontal axis.
            y_scale: scale of the value axis.
        """
        drawn_as = line.colour.rgb(), line.style, ground.rgb(), ratio
        is_measured = line.style is CurveStyle.POINTS
        if drawn_as != self._drawn_as:
            self._drawn_as = drawn_as
            pen = make_pen(line.colour, line.style, ground, ratio)
            self.setPen(None if is_measured else pen)
            self.setSegmentedLineMode("off" if line.style is CurveStyle.DASHED else "on")
            self.end.setBrush(pen.color())
        time, values = x_scale.places(line.time), y_scale.places(line.values)
        if is_measured:
            self._show_points(time, values, line.colour)
            return
        if self._points is not None:
            self._points.clear()
        time, values = with_dots(time, values)
        self.setData(time, values, connect="finite" if math.isnan(values.sum()) else "all")

    def _show_points(self, time: np.ndarray, values: np.ndarray, colour: QColor) -> None:
        if self._points is None:
            self._points = pg.ScatterPlotItem(size=MEASURED_POINT_PX, pen=None)
            self._points.setParentItem(self)
        known = np.isfinite(values)
        self.setData([], [])
        self._points.setData(time[known], values[known], brush=colour)


def with_dots(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return samples with single ones between two gaps doubled, so that they are drawn."""
    if not math.isnan(values.sum()):
        return time, values
    finite = np.concatenate([[False], np.isfinite(values), [False]])
    alone = np.flatnonzero(finite[1:-1] & ~finite[:-2] & ~finite[2:])
    if len(alone) == 0:
        return time, values
    step = 0.002 * (time[-1] - time[0])
    return (
        np.insert(time, alone + 1, time[alone] + step),
        np.insert(values, alone + 1, values[alone]),
    )


def end_texts(
    lines: Sequence[ChartLine], advance: Callable[[str], float], width: float
) -> tuple[list[str], int]:
    """Return the texts at the ends of curves, and the width that they need [pixels].

    Args:
        lines: the curves.
        advance: returns the width of a text [pixels].
        width: width of the chart [pixels]; if names are too wide for it, only numbers are shown.
    """
    texts = [f"{each.number or ''} {plain_name(each.name)}".strip() for each in lines]
    wide = math.ceil(max(map(advance, texts), default=0.0)) + 8
    if wide > max(CURVE_NUMBER_SPACE_PX, MAX_CURVE_NAME_SHARE * width):
        return [str(each.number or "") for each in lines], CURVE_NUMBER_SPACE_PX
    return texts, max(CURVE_NUMBER_SPACE_PX, wide)


def spread_positions(places: Sequence[float], low: float, high: float, gap: float) -> list[float]:
    """Return increasing positions moved apart, as far as there is room between two ends."""
    gap = min(gap, (high - low) / max(1, len(places) - 1))
    found: list[float] = []
    for place in places:
        least = found[-1] + gap if found else low
        found.append(min(max(place, least), high))
    for index in range(len(found) - 2, -1, -1):
        found[index] = min(found[index], found[index + 1] - gap)
    return found
