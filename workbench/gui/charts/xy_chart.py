"""The chart of signals over another signal instead of time."""

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.quantity import DisplayUnit
from workbench.common.series import Series
from workbench.gui.charts.chart_command import ChartCommand
from workbench.gui.charts.chart_kind import XY_CHART, ChartKind
from workbench.gui.charts.chart_window import AxisEnds, round_ends
from workbench.gui.charts.content import ChartAxis, ChartContent, ChartLine, CurveDot
from workbench.gui.charts.curve import AxisExtent, ChartCurve
from workbench.gui.charts.legend import LegendEntry
from workbench.gui.charts.statistics import value_at
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace

if TYPE_CHECKING:
    from workbench.gui.visualization.layouts import ChartSpec

MAX_XY_POINTS = 3000
"""Largest number of drawn points of a curve; others between them are left out."""


class XYChart(WindowPlot):
    """Plots every signal except the first over the first; see `WindowPlot`.

    Args:
        workspace: source of colours, units and preferences.

    Attributes:
        is_equal: whether both axes have the same scale.
    """

    PERIOD = 0.1

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self.is_equal = False
        self._when: float | None = None
        self._zoomed = False
        self._model.hint = "Drag a signal here for x, then one or more for y"

    @property
    def curves(self) -> tuple[ChartCurve, ...]:
        """The curves over the first signal."""
        return tuple(self.signals)[1:]

    def set_options(self, spec: "ChartSpec") -> None:
        self.set_equal(spec.equal)

    def with_options(self, spec: "ChartSpec") -> "ChartSpec":
        return dataclasses.replace(spec, equal=self.is_equal)

    def set_equal(self, equal: bool) -> None:
        """Use the same scale for both axes, or separate ones."""
        self.is_equal = equal
        self._settle()

    def show_time(self, time: float | None) -> None:
        """Mark the points of the curves at a time [s]; None removes the dots."""
        self._when = time
        if self.isVisible():
            self.redraw()

    def make(self) -> None:
        """Redraw from the newest samples."""
        self.redraw()

    def toggle_entry(self, index: int) -> None:
        """Hide a curve, or show it again."""
        self.curves[index].visible = not self.curves[index].visible
        self.redraw()

    def reset(self) -> None:
        """Show all curves completely."""
        self._zoomed = False
        super().reset()

    def redraw(self) -> None:
        """Redraw."""
        self.canvas.show_content(self._content())
        self._show_numbers()

    def columns(self) -> tuple[Series, ...]:
        """Return the visible samples in SI units, over time."""
        return tuple(Series(each.label, each.unit, *self.samples(each)) for each in self.signals)

    def _commands(self) -> list[ChartCommand]:
        """Return the commands; charts over time also have cursors and statistics."""
        over_time = (
            "Statistics",
            "Always show zero",
            "Set cursor A",
            "Set cursor B",
            "Clear cursors",
        )
        equal = ChartCommand("Equal scales", "E", self._choose_equal, self.is_equal)
        kept = [each for each in super()._commands() if each.text not in over_time]
        return [equal, *kept]

    def _choose_equal(self, equal: bool) -> None:
        self.set_equal(equal)
        self.options_changed.emit()

    def _point(self, time: float | None) -> None:
        """Draw no crosshair over x: it could meet a curve more than once."""

    def _turn(self, time: float, share: float, factor: float, values: bool) -> None:
        self._zoomed = True
        if self.is_equal:
            self._model.window.zoom_values(self._model.axis_ends, share, factor)
        super()._turn(time, share, factor, values and not self.is_equal)

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        self._zoomed = True
        super()._box(left, right, low, high)

    def _entries(self) -> list[LegendEntry]:
        """Return the legend: y over x, with both values at the cursor of other charts."""
        made = []
        for curve in self.curves:
            value = ""
            if self._when is not None:
                units = (
                    unit_for(each.unit, self._workspace.preferences)
                    for each in (self.signals[0], curve)
                )
                pair = zip(units, self._at(curve, self._when), strict=True)
                value = ", ".join(unit.text(number) for unit, number in pair)
            label = f"{curve.label} over {self.signals[0].label}"
            colour = self._workspace.look.curve(curve.colour)
            made.append(
                LegendEntry(label, value, colour, curve.style, self._number(curve), curve.visible)
            )
        return made

    def _at(self, curve: ChartCurve, when: float) -> tuple[float, float]:
        """Return x and y of a curve at a time [s]; NaN outside the samples."""
        time, x, y = self._pairs(curve)
        return value_at(time, x, when), value_at(time, y, when)

    def _pairs(self, curve: ChartCurve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times [s], x and y of a curve."""
        time, x = self.samples(self.first_of(curve))
        own, y = self.samples(curve)
        if len(own) == 0:
            return time[:0], x[:0], y[:0]
        if len(own) != len(time) or (own != time).any():
            y = np.interp(time, own, y, left=np.nan, right=np.nan)
        return time, x, y

    def _number(self, curve: ChartCurve) -> int:
        return curve.number - 1 if len(self.curves) > 1 else 0

    def _content(self) -> ChartContent:
        """Return the content to draw."""
        shown = [each for each in self.curves if each.visible]
        if not shown:
            one = f"{self.signals[0].label} is x: add a signal for y" if len(self.signals) else ""
            return ChartContent(left=0.0, right=1.0, hint=one or self._model.hint)
        across = unit_for(self.signals[0].unit, self._workspace.preferences)
        units = [*dict.fromkeys(each.axis_unit for each in shown)]
        wide, extents = AxisExtent(), [AxisExtent() for _ in units]
        lines, points = [], []
        for curve in shown:
            time, x, y = self._pairs(curve)
            every, axis = max(1, math.ceil(len(time) / MAX_XY_POINTS)), units.index(curve.axis_unit)
            x, y = wide.take(x) * across.factor, extents[axis].take(y)
            colour = self._workspace.look.curve(curve.colour)
            number = self._number(curve)
            lines.append(ChartLine(x[::every], y[::every], axis, colour, curve.style, number))
            if self._when is not None:
                points.append(CurveDot(*self._at(curve, self._when), axis, colour))
        if not self._zoomed:
            self._model.window.show(*_rounded_axis_ends(wide, across))
        window = self._model.window
        window.forget_ranges()
        shown_in = [unit_for(unit, self._workspace.preferences) for unit in units]
        ends = [
            window.values(index, *_rounded_axis_ends(extent, unit), self._now)
            for index, (unit, extent) in enumerate(zip(shown_in, extents, strict=True))
        ]
        left, right = self.window_ends
        if self.is_equal:
            left, right, ends[0] = self._equalled(left, right, ends[0])
        axes = tuple(ChartAxis(unit, *each) for unit, each in zip(shown_in, ends, strict=True))
        self._model.show_axes(axes)
        points = [each._replace(x=each.x * across.factor) for each in points]
        return ChartContent(
            left=left,
            right=right,
            x_label=f"{self.signals[0].label} {across.symbol}".strip(),
            x_unit=across.symbol,
            axes=axes,
            lines=tuple(lines),
            points=tuple(points),
        )

    def _equalled(self, left: float, right: float, ends: AxisEnds) -> tuple[float, float, AxisEnds]:
        """Return ends of both axes, one of them widened for equal scales."""
        low, high = ends
        size = self.canvas.view
        scale = max((right - left) / max(size.width(), 1.0), (high - low) / max(size.height(), 1.0))
        wide, tall = 0.5 * scale * size.width(), 0.5 * scale * size.height()
        x, y = 0.5 * (left + right), 0.5 * (low + high)
        return x - wide, x + wide, (y - tall, y + tall)


def _rounded_axis_ends(extent: AxisExtent, unit: DisplayUnit) -> AxisEnds:
    """Return round ends of an axis, as shown."""
    if extent.low > extent.high:
        return 0.0, 1.0
    return round_ends(unit.shown(extent.low), unit.shown(extent.high), 1e-3)


CHART_KIND = ChartKind(XY_CHART, "x-y, over the first signal", XYChart, over_first=True)
