"""The model of a chart: its curves, the window that shows them, and what the canvas draws."""

import math
from collections.abc import Sequence

import numpy as np

from workbench.common.quantity import DisplayUnit
from workbench.common.series import Series, TimedValues
from workbench.gui.charts.chart_window import ChartWindow
from workbench.gui.charts.content import ChartAxis, ChartContent, ChartLine, ReferenceLine
from workbench.gui.charts.curve import (
    LIMIT_COLOUR,
    AxisExtent,
    ChartCurve,
    CurveSet,
    CurveStyle,
)
from workbench.gui.charts.decimation import ColumnReducer
from workbench.gui.charts.legend import LegendEntry
from workbench.gui.charts.statistics import value_at, window_statistics
from workbench.gui.charts.ticks import Scale, decimals_for
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import unit_for


class ChartModel:
    """Curves, and the window that shows them.

    Args:
        preferences: source of units.
        look: source of colours.
        smallest: shown range of values if the data hardly vary.

    Attributes:
        curves: the shown curves.
        window: visible part of them.
        now: newest time [s].
        marks: times of cursors A and B [s], by name.
        times_ago: whether times are shown as ages.
        clock_start: time that is shown at 0 [s].
        x_name: name of the horizontal quantity if it is not time; "" if the unit says enough.
        x_unit: its unit.
        y_label: name of the values, "" for none.
        guides: straight lines below the curves.
        caption: text above the picture.
        hint: text without any curves.
        note: word over a paused picture.
    """

    def __init__(self, preferences: Preferences, look: Look, smallest: float) -> None:
        self._preferences = preferences
        self._look = look
        self.curves = CurveSet()
        self.window = ChartWindow(preferences.number("chart_seconds"), smallest)
        self.now = 0.0
        self.marks: dict[str, float] = {}
        self.guides: tuple[ReferenceLine, ...] = ()
        self.caption = ""
        self.times_ago, self.clock_start = False, 0.0
        self.x_name, self.x_unit, self.y_label = "", "s", ""
        self.hint = self.note = ""
        self._axes: tuple[ChartAxis, ...] = ()

    @property
    def ends(self) -> tuple[float, float]:
        """First and last visible time [s]."""
        return self.window.ends(self.now)

    @property
    def over(self) -> str:
        """The horizontal quantity, with its unit, as time [s]."""
        return f"{self.x_name.lower() or 'time'} [{self.x_unit}]"

    @property
    def mark_heads(self) -> list[str]:
        """Headings of the columns with values at cursors A and B."""
        text, unit, marks = self.window.x_scale.text, self.x_unit, self.marks
        shown = {name: time + self.clock_start for name, time in marks.items()}
        heads = [f"{name} at {text(shown[name], 3)} {unit}" for name in sorted(marks)]
        if len(marks) == 2:
            heads.append(f"B − A over {text(marks['B'] - marks['A'], 3)} {unit}")
            heads.append(f"Slope per {unit}")
        return heads

    def set_scales(self, x: Scale, y: Scale) -> None:
        """Set the scales of the axes."""
        self.window.x_scale, self.window.y_scale = x, y
        self.window.release_values()
        for curve in self.curves:
            curve.peaks = ColumnReducer()

    @property
    def axis_ends(self) -> Sequence[tuple[float, float]]:
        """The axes' ends in the last content, as shown."""
        return [(axis.low, axis.high) for axis in self._axes]

    def show_axes(self, axes: tuple[ChartAxis, ...]) -> None:
        """Set the axes of the last content."""
        self._axes = axes

    def stand(self) -> None:
        """Keep the present samples, even if their source drops them."""
        if self.window.follows:
            for curve in self.curves:
                curve.freeze()
            self.window.stand(self.now)

    def follow(self) -> None:
        """Show the newest samples again."""
        for curve in self.curves:
            curve.thaw()
        self.window.follow()
        self.window.span = self._preferences.number("chart_seconds")

    def content(self, columns: int) -> ChartContent:
        """Return the content to draw in a number of pixel columns."""
        left, right = self.ends
        units = self.curves.units
        extents = [AxisExtent() for _ in units]
        x_scale, y_scale = self.window.x_scale, self.window.y_scale
        ends = x_scale.place(left), x_scale.place(right)
        lines = []
        for curve in self.curves:
            if curve.visible:
                time, values = self._drawn(curve)
                places, values = curve.peaks.reduce(
                    x_scale.places(time), y_scale.known(values), *ends, columns
                )
                time = x_scale.values_of(places)
                axis = units.index(curve.axis_unit)
                values = extents[axis].take(values)
                colour = self._look.curve(curve.colour)
                lines.append(
                    ChartLine(
                        *(time, values, axis, colour, curve.style),
                        self._number(curve),
                        self._end_name(curve),
                    )
                )
        for guide in self.guides if extents else ():
            if guide.level is not None:
                extents[0].take(np.array([guide.level]))
        self._axes = tuple(
            self._axis(index, unit, extent)
            for index, (unit, extent) in enumerate(zip(units, extents, strict=True))
        )
        ago = self.window.follows and self.times_ago
        return ChartContent(
            left=left,
            right=right,
            origin=right if ago else -self.clock_start,
            x_label="s from now" if ago else f"{self.x_name} {self.x_unit}".strip(),
            x_unit=self.x_unit,
            x_scale=x_scale,
            y_scale=y_scale,
            axes=self._axes
            or (ChartAxis(DisplayUnit(""), y_scale.value_of(0.0), y_scale.value_of(1.0)),),
            lines=tuple(lines),
            guides=self.guides,
            caption=self.caption,
            marks=tuple(sorted(self.marks.items())),
            state="" if self.window.follows else self.note,
            hint="All curves are hidden" if len(self.curves) else self.hint,
        )

    def entries(self, when: float | None) -> list[LegendEntry]:
        """Return the legend, with values at a time [s]; if None, with the differences between
        cursors A and B, or, without them, with the newest values. A group has one entry.
        """
        made = []
        for group in self.curves.groups():
            curve = group[0]
            alike = len({each.label for each in group}) == 1
            label = curve.label if alike else f"{len(group)} {curve.group}"
            value = self._value_text(curve, when) if len(group) == 1 else ""
            colour = self._look.curve(curve.colour)
            number = self._number(curve)
            made.append(LegendEntry(label, value, colour, curve.style, number, curve.visible))
        return made

    def _value_text(self, curve: ChartCurve, when: float | None) -> str:
        """Return the value beside a curve's name in the legend."""
        time, values = self._seen(curve)
        unit, decimals = self._shown_in(curve)
        between = when is None and len(self.marks) == 2
        if when is not None:
            value = value_at(time, values, when)
        elif between:
            before, after = (value_at(time, values, self.marks[name]) for name in "AB")
            value = after - before
        else:
            value = float(values[-1]) if len(values) else np.nan
        shown = self.window.y_scale.text(unit.shown(value), decimals)
        sign = "Δ\N{NO-BREAK SPACE}" if between else ""
        return f"{sign}{shown}\N{NO-BREAK SPACE}{unit.symbol}".strip()

    def statistics(self) -> list[list[str]]:
        """Return the texts of the table's row of each visible curve."""
        rows = []
        for curve in self.curves:
            if not curve.visible:
                continue
            time, values = self._seen(curve)
            marks = [value_at(time, values, at) for _, at in sorted(self.marks.items())]
            numbers = [*window_statistics(time, values, *self.ends), *marks]
            if len(marks) == 2:
                change, between = marks[1] - marks[0], self.marks["B"] - self.marks["A"]
                numbers += [change, change / between if between else math.nan]
            unit, decimals = self._shown_in(curve)
            text = self.window.y_scale.text
            shown = (text(unit.shown(value), decimals + 1) for value in numbers)
            rows.append([curve.label, unit.symbol or "–", *shown])
        return rows

    def columns(self) -> tuple[Series, ...]:
        """Return the visible samples in SI units, as views that must be used at once."""
        return tuple(
            Series(curve.label, curve.unit, *self._seen(curve))
            for curve in self.curves
            if curve.visible
        )

    def _drawn(self, curve: ChartCurve) -> TimedValues:
        """Return the samples in the window; if paused, with the next one after it."""
        left, right = self.ends
        time, values = curve.samples(left)
        last = int(np.searchsorted(time, right, side="right")) + (not self.window.follows)
        first = 0
        if self.window.x_scale is Scale.LOGARITHMIC:
            first = int(np.searchsorted(time, 0.0, side="right"))
        return time[first:last], values[first:last]

    def _seen(self, curve: ChartCurve) -> TimedValues:
        """Return the samples in the window."""
        left, right = self.ends
        time, values = curve.samples(left)
        first = int(np.searchsorted(time, left))
        last = int(np.searchsorted(time, right, side="right"))
        return time[first:last], values[first:last]

    def _number(self, curve: ChartCurve) -> int:
        return curve.number if len(self.curves) > 1 else 0

    def _end_name(self, curve: ChartCurve) -> str:
        """Return the name at a curve's end; limits, earlier and other flights' curves have none."""
        pale = curve.style is CurveStyle.FAINT or curve.group or curve.colour == LIMIT_COLOUR
        return "" if pale or len(self.curves) == 1 else curve.label

    def _axis(self, index: int, si: str, extent: AxisExtent) -> ChartAxis:
        unit = unit_for(si, self._preferences)
        low, high = unit.shown(extent.low), unit.shown(extent.high)
        return ChartAxis(unit, *self.window.values(index, low, high, self.now), self.y_label)

    def _shown_in(self, curve: ChartCurve) -> tuple[DisplayUnit, int]:
        """Return unit and decimals for a curve's values."""
        index = self.curves.units.index(curve.axis_unit)
        unit = unit_for(curve.unit, self._preferences)
        span = self._axes[index].high - self._axes[index].low if index < len(self._axes) else 1.0
        return unit, decimals_for(span)
