"""What a strip chart shows: its curves, cut to a window, as scene, legend, statistics and table."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.gui.charts.chart_window import ChartWindow
from workbench.gui.charts.curve import Curve, Samples
from workbench.gui.charts.curve_set import CurveSet, Extent
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.scene import Axis, Limit, Line, Mark, Scene
from workbench.gui.charts.table_text import Column
from workbench.gui.charts.ticks import decimals_for, number_text
from workbench.gui.charts.window_statistics import WindowStatistics, value_at, window_statistics
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for


@dataclass(frozen=True)
class StatisticsRow:
    """A curve in numbers.

    Attributes:
        label: of the curve.
        unit: how its values are shown.
        decimals: of what is shown.
        statistics: of the window, in SI.
        marks: values at the cursors that stay, in SI.
    """

    label: str
    unit: Unit
    decimals: int
    statistics: WindowStatistics
    marks: tuple[float, ...]


class ChartPicture:
    """Makes what is shown of curves.

    Args:
        preferences: units.
        look: colours.

    Attributes:
        curves: that are shown.
        window: what of them is seen.
        now: newest time [s].
        marks: times of cursors A and B [s], by name.
        limits: value in SI, label, and SI unit of its axis or None for the first.
        times_ago: whether times are written as how long ago they are.
        hint: what is said where there are no curves.
        note: word over a picture that stands still.
    """

    def __init__(self, preferences: Preferences, look: Look) -> None:
        self._preferences = preferences
        self._look = look
        self.curves = CurveSet()
        self.window = ChartWindow(preferences.number("chart_seconds"))
        self.now = 0.0
        self.marks: dict[str, float] = {}
        self.limits: list[tuple[float, str, str | None]] = []
        self.note = ""
        self.times_ago = True
        self.hint = "No signal is shown here"
        self._axes: tuple[Axis, ...] = ()

    @property
    def ends(self) -> tuple[float, float]:
        """First and last time that are seen [s]."""
        return self.window.ends(self.now)

    @property
    def axis_ends(self) -> Sequence[tuple[float, float]]:
        """Ends of the axes in the last scene, as shown."""
        return [(axis.low, axis.high) for axis in self._axes]

    def stand(self) -> None:
        """Keep what there is, so that it stays even when its source forgets it."""
        if self.window.follows:
            self.curves.freeze()
            self.window.stand(self.now)

    def follow(self) -> None:
        """Show the newest again."""
        self.curves.thaw()
        self.window.follow()
        self.window.span = self._preferences.number("chart_seconds")

    def scene(self, columns: int) -> Scene:
        """Return what is to be drawn on so many pixels across."""
        left, right = self.ends
        extents = [Extent() for _ in self.curves.units]
        lines = []
        for curve in self.curves:
            if curve.visible:
                time, values = curve.peaks.reduce(*self._seen(curve), left, right, columns)
                axis = self.curves.axis_of(curve.unit)
                values = extents[axis].take(values)
                colour, number = self._look.colours.command, 0
                if curve.colour >= 0:
                    curves = self._look.colours.curves
                    colour, number = curves[curve.colour % len(curves)], self._number(curve)
                lines.append(Line(time, values, axis, colour, curve.style, number))
        self._axes = tuple(self._axis(index, extent) for index, extent in enumerate(extents))
        follows = self.window.follows
        return Scene(
            left=left,
            right=right,
            origin=right if follows and self.times_ago else 0.0,
            x_label="s from now" if follows and self.times_ago else "s",
            axes=self._axes,
            lines=tuple(lines),
            limits=self._shown_limits(),
            marks=tuple(Mark(name, time) for name, time in sorted(self.marks.items())),
            state="" if follows else self.note,
            hint="All curves are hidden" if len(self.curves) else self.hint,
        )

    def entries(self, when: float | None) -> list[Entry]:
        """Return the legend, with values at a time [s], the newest ones if None."""
        made = []
        for curve in self.curves:
            time, values = self._seen(curve)
            unit, decimals = self._shown_in(curve)
            if when is not None:
                value = value_at(time, values, when)
            else:
                value = float(values[-1]) if len(values) else np.nan
            text = f"{number_text(unit.shown(value), decimals)}\N{NO-BREAK SPACE}{unit.symbol}"
            number = self._number(curve) if curve.colour >= 0 else 0
            made.append(
                Entry(curve.label, text.strip(), curve.colour, curve.style, number, curve.visible)
            )
        return made

    def statistics(self) -> list[StatisticsRow]:
        """Return the curves that are drawn in numbers."""
        left, right = self.ends
        rows = []
        for curve in self.curves:
            if curve.visible:
                time, values = self._seen(curve)
                marks = tuple(value_at(time, values, at) for _, at in sorted(self.marks.items()))
                found = window_statistics(time, values, left, right)
                rows.append(StatisticsRow(curve.label, *self._shown_in(curve), found, marks))
        return rows

    def columns(self) -> tuple[Column, ...]:
        """Return the samples that are seen, in SI; views, to be used at once."""
        return tuple(
            Column(curve.label, curve.unit, *self._seen(curve))
            for curve in self.curves
            if curve.visible
        )

    def _seen(self, curve: Curve) -> Samples:
        """Return the samples in the window."""
        left, right = self.ends
        time, values = curve.samples(left)
        if len(time) == 0 or time[-1] <= right:
            return time, values
        last = int(np.searchsorted(time, right, side="right"))
        return time[:last], values[:last]

    def _number(self, curve: Curve) -> int:
        return curve.number if len(self.curves) > 1 else 0

    def _axis(self, index: int, extent: Extent) -> Axis:
        unit = unit_for(self.curves.units[index], self._preferences)
        low, high = unit.shown(extent.low), unit.shown(extent.high)
        return Axis(unit, *self.window.values(index, low, high, self.now))

    def _shown_in(self, curve: Curve) -> tuple[Unit, int]:
        """Return how the values of a curve are written: their unit and decimals."""
        index = self.curves.axis_of(curve.unit)
        unit = unit_for(curve.unit, self._preferences)
        span = self._axes[index].high - self._axes[index].low if index < len(self._axes) else 1.0
        return unit, decimals_for(span)

    def _shown_limits(self) -> tuple[Limit, ...]:
        units = list(self.curves.units)
        return tuple(
            Limit(value, label, 0 if unit is None else units.index(unit or "1"))
            for value, label, unit in self.limits
            if unit is None or (unit or "1") in units
        )
