"""A chart of finished curves, as responses laid over each other."""

import dataclasses

import numpy as np
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.chart import SEPARATOR, Chart, Command
from workbench.gui.charts.curve import Curve, CurveStyle, source_of
from workbench.gui.charts.decimation import Peaks
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.scale import Scale
from workbench.gui.workspace import Workspace

ROUNDING = 1e-9
"""Share of a value that comes back from its logarithm, or more."""


class StaticPlot(Chart):
    """Shows named curves over a common axis; what is set is drawn once, a little later.

    Args:
        workspace: colours, units and preferences.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, 1e-3, "Plot", parent)
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
    ) -> None:
        """Set a curve, or replace the one of that name; the arrays are kept, not copied.

        Args:
            name: in the legend.
            time: of the samples (n), rising [s].
            values: (n), in the SI unit of the axis.
            style: of its stroke.
            colour: its number, `COMMAND` for that of commands.
        """
        source, curve = source_of(time, values), self._find(name)
        if curve is None:
            self._model.curves.add(name, self._unit, source, colour, style)
        else:
            curve.source, curve.style, curve.colour, curve.peaks = source, style, colour, Peaks()
        self._curves_changed()

    def remove_curve(self, name: str) -> None:
        """Remove a curve; nothing happens where there is none of that name."""
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
        """Name the axes.

        Args:
            x_name: of what is below.
            y_label: of the values, without their unit.
            unit: SI, of the values; it is shown as the user prefers.
            x_unit: of what is below, as it is shown.
        """
        self._model.x_name, self._model.x_unit = x_name, x_unit
        self._model.y_label, self._unit = y_label, unit
        for curve in self.curves:
            curve.unit = unit
        self._curves_changed()

    def set_window(self, left: float, right: float) -> None:
        """Show a part of time [s]."""
        self._ends = (left, right) if right > left else None
        self._shown_ends = self.window_ends
        self._curves_changed()

    def set_scales(self, x: Scale = Scale.LINEAR, y: Scale = Scale.LINEAR) -> None:
        """Lay out the axes by a scale each, and show all of all curves."""
        self._model.set_scales(x, y)
        self._ends = None
        self._model.window.show(*self._wanted_ends())
        self._shown_ends = self.window_ends
        self._curves_changed()

    def reset(self) -> None:
        """Show all of all curves."""
        self._ends = None
        self._shown_ends = self.window_ends
        self._model.window.release_values()
        self._settle()

    def redraw(self) -> None:
        """Draw anew, and write all numbers."""
        if self.window_ends == self._shown_ends:  # nobody has zoomed
            self._model.window.show(*self._wanted_ends())
            self._shown_ends = self.window_ends
        self._model.window.forget_ranges()
        super().redraw()

    def _commands(self) -> list[Command]:
        show_all = Command("Show all", "Esc Home", lambda _: self.reset())
        return [show_all, SEPARATOR, *super()._commands()]

    def _find(self, name: str) -> Curve | None:
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
        if scale is Scale.LOGARITHMIC:  # whose ends are rounded, which is to leave no sample out
            left, right = left * (1.0 - ROUNDING), right * (1.0 + ROUNDING)
        return left, right if right > left else scale.value_of(scale.place(left) + 1.0)

    def _stand(self, note: str) -> None:
        """Do nothing: it always stands still."""

    def _entries(self) -> list[Entry]:
        """Return the legend: without a cursor, no value is newer than the others."""
        entries = super()._entries()
        if self.cursor_time is None:
            return [dataclasses.replace(each, value="") for each in entries]
        return entries
