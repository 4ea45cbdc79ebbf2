"""A plot of finished curves over a common axis."""

import dataclasses

import numpy as np

from workbench.gui.charts.chart import Chart
from workbench.gui.charts.chart_command import COMMAND_SEPARATOR, ChartCommand
from workbench.gui.charts.curve import ChartCurve, CurveStyle, fixed_source
from workbench.gui.charts.decimation import ColumnReducer
from workbench.gui.charts.legend import LegendEntry
from workbench.gui.charts.ticks import Scale
from workbench.gui.workspace import Workspace

LOG_ROUNDING_ERROR = 1e-9
"""Relative rounding error of a value that is computed back from its logarithm."""


class StaticPlot(Chart):
    """Shows named curves over a common axis; changes are drawn together, a moment later.

    Args:
        workspace: source of colours, units and preferences.
        shows_end: whether the legend has the last values while there is no cursor.
    """

    def __init__(self, workspace: Workspace, shows_end: bool = False) -> None:
        super().__init__(workspace, 1e-3, "Plot")
        self._shows_end = shows_end
        self._unit = ""
        self._ends: tuple[float, float] | None = None
        self._model.hint = "Nothing to show yet"
        self._model.window.show(*self._wanted_ends())
        self._shown_ends = self.window_ends

    def set_curve(
        self,
        name: str,
        time: np.ndarray,
        values: np.ndarray,
        style: CurveStyle = CurveStyle.SOLID,
        colour: int = 0,
        group: str = "",
    ) -> None:
        """Set or replace the curve of a name; the arrays are kept without a copy.

        Args:
            name: name in the legend.
            time: times of the samples (n), increasing [s], or another horizontal quantity.
            values: (n), in the SI unit of the axis.
            style: line style.
            colour: number of its colour, `COMMAND_COLOUR` for that of commands.
            group: name of the curves that share one entry of the legend, "" for none.
        """
        source, curve = fixed_source(time, values), self._find(name)
        if curve is None:
            seen = all(each.visible for each in self.curves if group and each.group == group)
            curve = self._model.curves.add(name, self._unit, source, colour, style)
            curve.visible = seen
        curve.source, curve.style, curve.colour, curve.group = source, style, colour, group
        curve.peaks = ColumnReducer()
        self._curves_changed()

    def remove_curve(self, name: str) -> None:
        """Remove a curve, if there is one of that name."""
        curve = self._find(name)
        if curve is not None:
            self._model.curves.remove(curve)
            self._curves_changed()

    def clear(self) -> None:
        """Remove all curves."""
        for curve in self.curves:
            self._model.curves.remove(curve)
        self._curves_changed()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the curves."""
        return tuple(curve.label for curve in self.curves)

    def set_axes(self, x_name: str, y_label: str, unit: str = "", x_unit: str = "s") -> None:
        """Set the names of the axes.

        Args:
            x_name: name of the horizontal quantity.
            y_label: name of the values, without their unit.
            unit: SI unit of the values; shown in the user's preferred unit.
            x_unit: unit of the horizontal quantity, as shown.
        """
        self._model.x_name, self._model.x_unit = x_name, x_unit
        self._model.y_label, self._unit = y_label, unit
        for curve in self.curves:
            curve.unit = unit
        self._curves_changed()

    def set_window(self, left: float, right: float) -> None:
        """Show a time window [s]."""
        self._ends = (left, right) if right > left else None
        self._shown_ends = self.window_ends
        self._curves_changed()

    def set_scales(self, x: Scale = Scale.LINEAR, y: Scale = Scale.LINEAR) -> None:
        """Set the axes' scales, and show all curves completely."""
        self._model.set_scales(x, y)
        self._ends = None
        self._model.window.show(*self._wanted_ends())
        self._shown_ends = self.window_ends
        self._curves_changed()

    def reset(self) -> None:
        """Show all curves completely."""
        self._ends = None
        self._shown_ends = self.window_ends
        self._model.window.release_values()
        self._settle()

    def redraw(self) -> None:
        """Redraw, with all numbers."""
        if self.window_ends == self._shown_ends:  # the user has not zoomed
            self._model.window.show(*self._wanted_ends())
            self._shown_ends = self.window_ends
        self._model.window.forget_ranges()
        super().redraw()

    def _commands(self) -> list[ChartCommand]:
        show_all = ChartCommand("Show all", "Esc Home", lambda _: self.reset())
        return [show_all, COMMAND_SEPARATOR, *super()._commands()]

    def _find(self, name: str) -> ChartCurve | None:
        return next((each for each in self.curves if each.label == name), None)

    def _wanted_ends(self) -> tuple[float, float]:
        if self._ends is not None:
            return self._ends
        scale = self._model.window.x_scale
        seen = [each.samples(-np.inf)[0] for each in self.curves if each.visible]
        if scale is Scale.LOGARITHMIC:
            seen = [time[time > 0.0] for time in seen]
        times = [time for time in seen if len(time)]
        left = min((float(time[0]) for time in times), default=scale.value_of(0.0))
        right = max((float(time[-1]) for time in times), default=scale.value_of(1.0))
        if scale is Scale.LOGARITHMIC:  # with rounded ends, which must leave no sample out
            left, right = left * (1.0 - LOG_ROUNDING_ERROR), right * (1.0 + LOG_ROUNDING_ERROR)
        return left, right if right > left else scale.value_of(scale.place(left) + 1.0)

    def _stand(self, note: str) -> None:
        """Do nothing: it is always paused."""

    def _entries(self) -> list[LegendEntry]:
        """Return the legend: no sample is the newest, so a value needs a cursor or `shows_end`."""
        entries = super()._entries()
        if self.cursor_time is None and not self._shows_end:
            return [dataclasses.replace(each, value="") for each in entries]
        return entries
