"""What a chart shows of its curves: the part that is seen, as drawing, legend and numbers."""

from collections.abc import Sequence

import numpy as np

from workbench.gui.charts.chart_window import ChartWindow
from workbench.gui.charts.content import Axis, Content, Line
from workbench.gui.charts.curve import Curve, CurveSet, Extent, Samples
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.saving import Column
from workbench.gui.charts.statistics import StatisticsRow, value_at, window_statistics
from workbench.gui.charts.ticks import decimals_for, number_text
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for


class ChartModel:
    """Curves, and the window through which they are seen.

    Args:
        preferences: units.
        look: colours.
        smallest: range of values that is shown where the data hardly move.

    Attributes:
        curves: that are shown.
        window: what of them is seen.
        now: newest time [s].
        marks: times of cursors A and B [s], by name.
        times_ago: whether times are written as how long ago they are.
        x_label: below, where they are not.
        y_label: of the values, "" for none.
        hint: what is said where there are no curves.
        note: word over a picture that stands still.
    """

    def __init__(self, preferences: Preferences, look: Look, smallest: float) -> None:
        self._preferences = preferences
        self._look = look
        self.curves = CurveSet()
        self.window = ChartWindow(preferences.number("chart_seconds"), smallest)
        self.now = 0.0
        self.marks: dict[str, float] = {}
        self.times_ago = False
        self.x_label, self.y_label = "s", ""
        self.hint = self.note = ""
        self._axes: tuple[Axis, ...] = ()

    @property
    def ends(self) -> tuple[float, float]:
        """First and last time that are seen [s]."""
        return self.window.ends(self.now)

    @property
    def axis_ends(self) -> Sequence[tuple[float, float]]:
        """Ends of the axes in the last content, as shown."""
        return [(axis.low, axis.high) for axis in self._axes]

    def stand(self) -> None:
        """Keep what there is, so that it stays even when its source forgets it."""
        if self.window.follows:
            for curve in self.curves:
                curve.freeze()
            self.window.stand(self.now)

    def follow(self) -> None:
        """Show the newest again."""
        for curve in self.curves:
            curve.thaw()
        self.window.follow()
        self.window.span = self._preferences.number("chart_seconds")

    def content(self, columns: int) -> Content:
        """Return what is to be drawn on so many columns of pixels."""
        left, right = self.ends
        units = self.curves.units
        extents = [Extent() for _ in units]
        lines = []
        for curve in self.curves:
            if curve.visible:
                time, values = curve.peaks.reduce(*self._drawn(curve), left, right, columns)
                axis = units.index(curve.axis_unit)
                values = extents[axis].take(values)
                colour = self._look.curve(curve.colour)
                lines.append(Line(time, values, axis, colour, curve.style, self._number(curve)))
        self._axes = tuple(
            self._axis(index, unit, extent)
            for index, (unit, extent) in enumerate(zip(units, extents, strict=True))
        )
        ago = self.window.follows and self.times_ago
        return Content(
            left=left,
            right=right,
            origin=right if ago else 0.0,
            x_label="s from now" if ago else self.x_label,
            axes=self._axes or Content.axes,
            lines=tuple(lines),
            marks=tuple(sorted(self.marks.items())),
            state="" if self.window.follows else self.note,
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
            colour = self._look.curve(curve.colour)
            number = self._number(curve)
            entry = Entry(curve.label, text.strip(), colour, curve.style, number, curve.visible)
            made.append(entry)
        return made

    def statistics(self) -> list[StatisticsRow]:
        """Return the curves that are drawn in numbers."""
        rows = []
        for curve in self.curves:
            if curve.visible:
                time, values = self._seen(curve)
                marks = tuple(value_at(time, values, at) for _, at in sorted(self.marks.items()))
                found = window_statistics(time, values, *self.ends)
                rows.append(StatisticsRow(curve.label, *self._shown_in(curve), found, marks))
        return rows

    def columns(self) -> tuple[Column, ...]:
        """Return the samples that are seen, in SI; views, to be used at once."""
        return tuple(
            Column(curve.label, curve.unit, *self._seen(curve))
            for curve in self.curves
            if curve.visible
        )

    def _drawn(self, curve: Curve) -> Samples:
        """Return the samples in the window; while it stands, with the next one after it."""
        left, right = self.ends
        time, values = curve.samples(left)
        last = int(np.searchsorted(time, right, side="right")) + (not self.window.follows)
        return time[:last], values[:last]

    def _seen(self, curve: Curve) -> Samples:
        """Return the samples in the window."""
        left, right = self.ends
        time, values = curve.samples(left)
        first = int(np.searchsorted(time, left))
        last = int(np.searchsorted(time, right, side="right"))
        return time[first:last], values[first:last]

    def _number(self, curve: Curve) -> int:
        return curve.number if len(self.curves) > 1 and curve.colour >= 0 else 0

    def _axis(self, index: int, si: str, extent: Extent) -> Axis:
        unit = unit_for(si, self._preferences)
        low, high = unit.shown(extent.low), unit.shown(extent.high)
        return Axis(unit, *self.window.values(index, low, high, self.now), self.y_label)

    def _shown_in(self, curve: Curve) -> tuple[Unit, int]:
        """Return how the values of a curve are written: their unit and decimals."""
        index = self.curves.units.index(curve.axis_unit)
        unit = unit_for(curve.unit, self._preferences)
        span = self._axes[index].high - self._axes[index].low if index < len(self._axes) else 1.0
        return unit, decimals_for(span)
