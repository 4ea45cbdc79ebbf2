"""What a chart shows of its curves: the part that is seen, as drawing, legend and numbers."""

import math
from collections.abc import Sequence

import numpy as np

from workbench.gui.charts.content import Axis, Content, Line
from workbench.gui.charts.curve import Curve, CurveSet, Extent, Samples
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.saving import Column
from workbench.gui.charts.statistics import StatisticsRow, value_at, window_statistics
from workbench.gui.charts.ticks import decimals_for, number_text, round_step
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for

SHORTEST = 0.02
"""Time that can be zoomed to [s]."""
LONGEST = 180.0
"""Time that is followed, as the signals keep no more [s]."""
WHOLE = 7200.0
"""Time that can be looked at standing, of a long log [s]."""
PATIENCE = 2.0
"""Data have to be this small for so long before the axis shrinks [s]."""
SHRINK = 0.5
"""Share of the range that data have to leave free before the axis shrinks."""
PARTS = 5
"""Into which a range is divided to find round ends."""
Ends = tuple[float, float]


class SteadyRange:
    """Round ends around data: they widen at once and shrink only after a while.

    Args:
        smallest: range that is shown where data hardly move.
    """

    def __init__(self, smallest: float = 0.1) -> None:
        self._smallest = smallest
        self._ends: tuple[float, float] | None = None
        self._small_since = math.inf

    def follow(self, low: float, high: float, now: float) -> tuple[float, float]:
        """Return the ends for data between two values at a time [s]."""
        if not (math.isfinite(low) and math.isfinite(high)):
            return self._ends or (-1.0, 1.0)
        wanted = round_ends(low, high, self._smallest)
        if self._ends is None or low < self._ends[0] or high > self._ends[1]:
            kept = self._ends or wanted
            if self._ends is not None and wanted[1] - wanted[0] > SHRINK * (kept[1] - kept[0]):
                wanted = min(wanted[0], kept[0]), max(wanted[1], kept[1])
                wanted = round_ends(*wanted, self._smallest, room=0.0)
            self._ends, self._small_since = wanted, math.inf
        elif wanted[1] - wanted[0] <= SHRINK * (self._ends[1] - self._ends[0]):
            self._small_since = min(self._small_since, now)
            if now - self._small_since >= PATIENCE:
                self._ends, self._small_since = wanted, math.inf
        else:
            self._small_since = math.inf
        return self._ends

    def forget(self) -> None:
        """Begin anew with the next data."""
        self._ends, self._small_since = None, math.inf


def round_ends(
    low: float, high: float, smallest: float = 0.0, room: float = 0.04
) -> tuple[float, float]:
    """Return round numbers around two, with a share of room besides."""
    span = max(high - low, smallest, 1e-9 * max(abs(low), abs(high)), 1e-12)
    middle, half = 0.5 * (low + high), 0.5 * span
    low, high = min(low, middle - half) - room * span, max(high, middle + half) + room * span
    step = 0.5 * round_step(high - low, PARTS)
    return step * math.floor(low / step + 1e-6), step * math.ceil(high / step - 1e-6)


class ChartWindow:
    """What is seen of the curves.

    Args:
        span: time that is seen while it follows [s].
        smallest: range of values that is shown where the data hardly move.

    Attributes:
        span: time that is seen while it follows [s].
        with_zero: whether zero is always seen.
    """

    def __init__(self, span: float, smallest: float) -> None:
        self.span = span
        self._smallest = smallest
        self.with_zero = False
        self._still: Ends | None = None
        self._fixed: dict[int, Ends] = {}
        self._ranges: dict[int, SteadyRange] = {}

    @property
    def follows(self) -> bool:
        """Whether the newest samples are seen as they come."""
        return self._still is None

    def ends(self, now: float) -> Ends:
        """Return the first and last time that are seen [s]."""
        return self._still or (now - self.span, now)

    def stand(self, now: float) -> None:
        """Follow no longer."""
        self._still = self.ends(now)

    def follow(self) -> None:
        """Follow the newest samples, with axes that follow the data."""
        self._still = None
        self.release_values()

    def show(self, left: float, right: float) -> None:
        """Stand still at a part of time [s]."""
        middle, half = 0.5 * (left + right), 0.5 * abs(right - left)
        half = min(max(half, 0.5 * SHORTEST), 0.5 * WHOLE)
        self._still = middle - half, middle + half

    def move(self, share: float, now: float) -> None:
        """Move on by a share of what is seen."""
        left, right = self.ends(now)
        way = share * (right - left)
        self._still = left + way, right + way

    def zoom_time(self, about: float, factor: float, now: float) -> None:
        """Show a factor of the time; while it follows, the newest sample stays at the edge."""
        if self.follows:
            self.span = min(max(self.span * factor, 0.5), LONGEST)
            return
        left, right = self.ends(now)
        span = min(max((right - left) * factor, SHORTEST), WHOLE)
        factor = span / (right - left)
        self._still = about - (about - left) * factor, about + (right - about) * factor

    def zoom_values(self, axes: Sequence[Ends], share: float, factor: float) -> None:
        """Show a factor of the values of all axes, about a share of the height."""
        for index, (low, high) in enumerate(axes):
            about = low + share * (high - low)
            self._fixed[index] = (about - (about - low) * factor, about + (high - about) * factor)

    def cut_values(self, axes: Sequence[Ends], low: float, high: float) -> None:
        """Show the values between two shares of the height, of all axes."""
        if high - low > 0.98:
            return
        for index, (least, largest) in enumerate(axes):
            span = largest - least
            self._fixed[index] = (least + low * span, least + high * span)

    def values(self, axis: int, low: float, high: float, now: float) -> Ends:
        """Return the ends of an axis whose data lie between two values, as shown."""
        if axis in self._fixed:
            return self._fixed[axis]
        if self.with_zero and math.isfinite(low):
            low, high = min(low, 0.0), max(high, 0.0)
        return self._ranges.setdefault(axis, SteadyRange(self._smallest)).follow(low, high, now)

    def release_values(self) -> None:
        """Let the axes follow the data again."""
        self._fixed.clear()
        self.forget_ranges()

    def forget_ranges(self) -> None:
        """Let the axes that follow the data find their ends anew."""
        self._ranges.clear()


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
