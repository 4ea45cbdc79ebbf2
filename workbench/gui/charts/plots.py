"""Plots of finished curves, and plots computed from signals over a time window.

The latter are spectra, step responses, and signals over each other.
"""

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QComboBox, QVBoxLayout

from workbench.common.errors import WorkbenchError
from workbench.design.response_metrics import NUMBERS
from workbench.design.step_responses import StepResponse, step_responses
from workbench.gui.charts.chart import SEPARATOR, Chart, Column, Command, Ends, round_ends
from workbench.gui.charts.content import Axis, Content, Line, Point
from workbench.gui.charts.curve import (
    COMMAND,
    LIMIT,
    MOST_CURVES,
    Curve,
    CurveSet,
    CurveStyle,
    Extent,
    Samples,
    Source,
    source_of,
)
from workbench.gui.charts.decimation import Peaks
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.statistics import value_at
from workbench.gui.charts.strip_chart import TimeView
from workbench.gui.charts.ticks import Scale, number_text
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import hbox
from workbench.gui.style import set_class
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.logs.spectrum import (
    DETRENDS,
    WINDOWS,
    Spectrum,
    Welch,
    density_unit,
    power_spectrum,
)

ROUNDING = 1e-9
"""Relative rounding error of a value that is computed back from its logarithm."""


class StaticPlot(Chart):
    """Shows named curves over a common axis; changes are drawn together, a moment later.

    Args:
        workspace: source of colours, units and preferences.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace, 1e-3, "Plot")
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
        """Set or replace the curve of a name; the arrays are kept without a copy.

        Args:
            name: name in the legend.
            time: times of the samples (n), increasing [s], or another horizontal quantity.
            values: (n), in the SI unit of the axis.
            style: line style.
            colour: number of its colour, `COMMAND` for that of commands.
        """
        source, curve = source_of(time, values), self._find(name)
        if curve is None:
            self._model.curves.add(name, self._unit, source, colour, style)
        else:
            curve.source, curve.style, curve.colour, curve.peaks = source, style, colour, Peaks()
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
        if scale is Scale.LOGARITHMIC:  # with rounded ends, which must leave no sample out
            left, right = left * (1.0 - ROUNDING), right * (1.0 + ROUNDING)
        return left, right if right > left else scale.value_of(scale.place(left) + 1.0)

    def _stand(self, note: str) -> None:
        """Do nothing: it is always paused."""

    def _entries(self) -> list[Entry]:
        """Return the legend: without a cursor it has no values, as no sample is the newest."""
        entries = super()._entries()
        if self.cursor_time is None:
            return [dataclasses.replace(each, value="") for each in entries]
        return entries


class WindowPlot(StaticPlot):
    """Recomputes its curves over time, from the visible samples of strip charts beside it.

    If cursors A and B are set, it uses the time between them.

    Args:
        workspace: source of colours, units and preferences.

    Attributes:
        signals: signals over time that it uses.
    """

    PERIOD = 0.2
    """Period between pictures [s]."""

    def __init__(self, workspace: Workspace) -> None:
        self.signals = CurveSet()
        self._firsts: dict[Curve, Curve] = {}
        span = workspace.preferences.number("chart_seconds")
        self._view = TimeView(-span, 0.0, True)
        self._made = -math.inf
        self._now = 0.0
        super().__init__(workspace)

    def add_curve(
        self,
        label: str,
        unit: str,
        source: Source,
        *,
        colour: int | None = None,
        style: CurveStyle = CurveStyle.SOLID,
    ) -> Curve:
        """Add a signal; arguments as for `StripChart.add_curve`.

        Raises:
            WorkbenchError: if there is no room for another curve or unit.
        """
        made = self.signals.add(label, unit, source, colour, style)
        if not self._view.follows:
            made.freeze()
        self._made = -math.inf
        self._soon.start()
        return made

    def add_over(self, first: Source, label: str, unit: str, source: Source, colour: int) -> Curve:
        """Add a signal of another flight, paler, with that flight's first signal instead of ours.

        Args:
            first: first signal of the other flight.
            label: name in the legend.
            unit: SI unit.
            source: source of the signal.
            colour: number of its colour.

        Raises:
            WorkbenchError: if there is no room for another curve or unit.
        """
        made = self.add_curve(label, unit, source, colour=colour, style=CurveStyle.FAINT)
        ours = self.signals[0]
        self._firsts[made] = Curve(ours.label, ours.unit, first)
        if not self._view.follows:
            self._firsts[made].freeze()
        return made

    def first_of(self, curve: Curve) -> Curve:
        """Return the first signal of a signal's flight."""
        return self._firsts.get(curve, self.signals[0])

    def clear(self) -> None:
        """Remove all signals."""
        self.signals = CurveSet()
        self._firsts = {}
        super().clear()

    @property
    def part(self) -> tuple[float, float]:
        """First and last time that it uses [s]."""
        marks = [time for _, time in self._view.marks]
        if len(marks) == 2 and marks[0] != marks[1]:
            return min(marks), max(marks)
        if self._view.follows:
            return self._now - (self._view.right - self._view.left), self._now
        return self._view.left, self._view.right

    def take_view(self, view: TimeView) -> None:
        """Use the time window of strip charts."""
        if view.follows is not self._view.follows:
            for curve in (*self.signals, *self._firsts.values()):
                curve.thaw() if view.follows else curve.freeze()
        self._view = view
        self._made = -math.inf
        self.refresh(self._now)

    def refresh(self, now: float) -> None:
        """Recompute it for a time [s], not too often, and only while visible."""
        self._now = now
        fresh = self._made <= now < self._made + self.PERIOD
        stands = not self._view.follows and self._made > -math.inf
        if fresh or stands or not self.isVisible():
            return
        self._made = now
        self.make()

    def make(self) -> None:
        """Compute the curves from the signals."""
        raise NotImplementedError

    def set_times_ago(self, ago: bool) -> None:
        """Do nothing: it shows no times."""

    def samples(self, curve: Curve) -> Samples:
        """Return a signal's samples in the time window, as views that must be used at once."""
        left, right = self.part
        time, values = curve.samples(left)
        first, last = np.searchsorted(time, left), np.searchsorted(time, right, side="right")
        return time[first:last], values[first:last]

    def _redraw_if_seen(self) -> None:
        if self._made == -math.inf:
            self.refresh(self._now)
        super()._redraw_if_seen()


AVERAGES = (1, 2, 4, 8, 16, 32, 64)
_WINDOW_NAMES = {"hann": "Hann", "hamming": "Hamming", "flattop": "Flat top", "boxcar": "Boxcar"}
_DETREND_NAMES = {"constant": "Mean off", "linear": "Line off", "none": "As it is"}
BOTH = Scale.LOGARITHMIC, Scale.LOGARITHMIC


class SpectrumChart(WindowPlot):
    """Shows the spectra of signals; see `WindowPlot`.

    Spectra are computed outside the screens' thread, at most five times a second.

    Args:
        workspace: source of colours, units, preferences and errands.
    """

    welch_changed = pyqtSignal()
    """The user has chosen another window, averaging or detrending."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._waits = self._again = False
        self._model.x_name, self._model.x_unit = "Frequency", "Hz"
        self._window, self._averages, self._detrend = QComboBox(), QComboBox(), QComboBox()
        self.said = Label()
        self._lay_out()
        self.set_scales(*BOTH)
        for box in (self._window, self._averages, self._detrend):
            box.activated.connect(self._choose)

    @property
    def welch(self) -> Welch:
        """Settings of the spectra."""
        return Welch(
            str(self._window.currentData()),
            int(self._averages.currentData()),
            str(self._detrend.currentData()),
        )

    def set_welch(self, welch: Welch) -> None:
        """Set how spectra are computed."""
        self._window.setCurrentIndex(self._window.findData(welch.window))
        if self._averages.findData(welch.averages) < 0:
            self._averages.addItem(f"{welch.averages} averages", welch.averages)
        self._averages.setCurrentIndex(self._averages.findData(welch.averages))
        self._detrend.setCurrentIndex(self._detrend.findData(welch.detrend))
        self._make_anew()

    def redraw(self) -> None:
        """Redraw; the axes stay while the spectra vary within them."""
        if self.window_ends == self._shown_ends:  # the user has not zoomed
            self._model.window.show(*self._wanted_ends())
            self._shown_ends = self.window_ends
        self._model.now = self._now
        Chart.redraw(self)

    def make(self) -> None:
        """Start to compute the spectra; if a computation is in progress, again after it."""
        if self._waits:
            self._again = True
            return
        self._waits = True
        sampled = [
            Column(each.label, each.unit, *(part.copy() for part in self.samples(each)))
            for each in self.signals
        ]
        signals, part = self.signals, self.part
        self._answers.expect(
            self._workspace.errands.run(partial(_spectra, sampled, self.welch)),
            lambda found: self._show(signals, part, found),
        )

    def _show(
        self, signals: CurveSet, part: tuple[float, float], found: list[Spectrum | str]
    ) -> None:
        """Show spectra, or why there are none."""
        self._waits = False
        if signals is self.signals:
            self._draw_spectra(part, found)
        if self._again or signals is not self.signals:
            self._again = False
            self.make()

    def _draw_spectra(self, part: tuple[float, float], found: list[Spectrum | str]) -> None:
        hidden = {curve.label for curve in self.curves if not curve.visible}
        self._model.curves = CurveSet()
        said = []
        for signal, each in zip(self.signals, found, strict=False):
            if isinstance(each, str):
                said.append(each)
                continue
            source = source_of(each.frequency[1:], each.density[1:])
            unit = density_unit(signal.unit or "1")
            made = self._model.curves.add(signal.label, unit, source, signal.colour, signal.style)
            made.visible = signal.label not in hidden
            length = each.segment / each.rate
            of = f"segments of {length:.3g} s, {1.0 / length:.3g} Hz apart"
            said.append(of + (", missing samples interpolated" if each.resampled else ""))
        whole = f"{part[1] - part[0]:.4g} s: " if found else ""
        self.said.setText(whole + "; ".join(dict.fromkeys(said)))
        self.said.setVisible(bool(self.said.text()))
        self._describe()
        super()._redraw_if_seen()

    def _choose(self) -> None:
        self._make_anew()
        self.welch_changed.emit()

    def _make_anew(self) -> None:
        self._made = -np.inf
        self.refresh(self._now)

    def _lay_out(self) -> None:
        row = hbox(spacing=4)
        for box, names, name in (
            (self._window, _WINDOW_NAMES, "Window of the spectrum"),
            (self._averages, {each: f"{each} averages" for each in AVERAGES}, "Segments averaged"),
            (self._detrend, _DETREND_NAMES, "What is subtracted from each segment"),
        ):
            for value, shown in names.items():
                box.addItem(shown, value)
            box.setAccessibleName(name)
            set_tip(box, name)
            row.addWidget(box)
        row.addStretch(1)
        assert set(_WINDOW_NAMES) == set(WINDOWS) and set(_DETREND_NAMES) == set(DETRENDS)
        self._averages.setCurrentIndex(AVERAGES.index(Welch().averages))
        self.said.setWordWrap(True)
        set_class(self.said, "muted")
        self.said.hide()
        column = self.layout()
        assert isinstance(column, QVBoxLayout)
        column.insertLayout(1, row)
        column.insertWidget(3, self.said)


def _spectra(sampled: list[Column], welch: Welch) -> list[Spectrum | str]:
    """Return the spectrum of each signal, or a sentence why it has none."""
    found: list[Spectrum | str] = []
    for each in sampled:
        try:
            found.append(power_spectrum(each.time, each.values, welch, each.label))
        except WorkbenchError as error:
            found.append(str(error))
    return found


MOST_STEPS = 12
"""Number of drawn steps: the newest ones of all flights."""
_OF_VALUES = ("peak", "steady_state_value")
_OF_TIME = ("rise_time", "settling_time", "peak_time")


@dataclass(frozen=True, eq=False)
class LimitLine:
    """A limit on a step response.

    Attributes:
        label: name in the legend.
        time: time from the edge on (n) [s].
        values: (n), relative to the command before the edge.
    """

    label: str
    time: np.ndarray
    values: np.ndarray


Limits = Callable[[StepResponse], Sequence[LimitLine]]
"""Returns the limits of a response."""


class StepChart(WindowPlot):
    """Shows the responses of the second signal to steps of the first; see `WindowPlot`.

    The table lists the newest step first; meaningless numbers are left out.

    Args:
        workspace: source of colours, units and preferences.

    Attributes:
        steps: the shown steps, the newest last.
    """

    def __init__(self, workspace: Workspace) -> None:
        self.steps: list[StepResponse] = []
        self._names: list[str] = []
        self._limits: Limits = lambda _: ()
        self._hidden: set[str] = set()
        super().__init__(workspace)
        self._model.x_name = "Time after the step"
        self._model.hint = "Drag a command here, then its response"
        self.statistics.setAccessibleName("Metrics of the steps that the chart shows")
        self.set_statistics_shown(True)

    def set_limits(self, limits: Limits) -> None:
        """Draw the limits of the newest step."""
        self._limits = limits
        self._made = -np.inf
        self._soon.start()

    def make(self) -> None:
        """Find the steps, and draw the newest ones."""
        if len(self.signals) < 2:
            return
        command, flown = self.signals[0], self.signals[1]
        curves = CurveSet()
        self.steps, self._names = [], []
        share = max(1, MOST_STEPS // (1 + len(self._firsts)))
        for each in (flown, *self._firsts):
            found = step_responses(self.samples(self.first_of(each)), self.samples(each))
            of = each.label.removeprefix(flown.label)
            for number, step in list(enumerate(found, 1))[-share:]:
                newest = step is found[-1]
                style = CurveStyle.SOLID if newest and each is flown else CurveStyle.FAINT
                source = source_of(step.time, step.response)
                self._names.append(f"step {number}{of}")
                colour = 0 if newest else number
                curves.add(self._names[-1], flown.unit, source, colour, style)
                self.steps.append(step)
            if each is flown:
                ours = len(self.steps)
        for step in self.steps[:ours][-1:]:
            asked = np.full(len(step.time), step.amplitude)
            source = source_of(step.time, asked)
            curves.add("command", flown.unit, source, COMMAND, CurveStyle.DASHED)
            for line in self._limits(step)[: MOST_CURVES - len(curves)]:
                source = source_of(line.time, line.values)
                curves.add(line.label, flown.unit, source, LIMIT, CurveStyle.DASHED)
        for curve in curves:
            curve.visible = curve.label not in self._hidden
        self._model.curves = curves
        if not self.steps:
            self._model.hint = (
                f"No step of {command.label} in this part of time: a step is a command that is "
                "constant, changes, and is constant again"
            )
        self._describe()
        Chart._redraw_if_seen(self)

    def toggle_curve(self, index: int) -> None:
        """Hide a step or a limit, or show it again."""
        self._hidden ^= {self._entries()[index].label}
        for curve in self.curves:
            curve.visible = curve.label not in self._hidden
        self.redraw()

    def _entries(self) -> list[Entry]:
        """Return the legend; a limit of two lines has one entry."""
        found = {each.label: each for each in super()._entries()}
        return [*found.values()]

    def _commands(self) -> list[Command]:
        """Return the commands; the table has the metrics."""
        return [
            Command("Metrics", each.key, each.do, each.checked)
            if each.text == "Statistics"
            else each
            for each in super()._commands()
        ]

    def _show_numbers(self) -> None:
        self.legend.show_entries(self._entries())
        if not self.are_statistics_shown or len(self.signals) < 2:
            return
        unit = unit_for(self.signals[1].unit, self._workspace.preferences)
        heads = {"Step": "In the order they were flown", "At s": "When the command changed"}
        heads["By" + f" {unit.symbol}".rstrip()] = "By how much the command changed"
        for name in NUMBERS:
            of = unit.symbol if name in _OF_VALUES else "s" if name in _OF_TIME else "%"
            heads[f"{name} {of}".strip()] = "As python-control defines it"
        heads["Left out, as"] = "Why some numbers have no meaning"
        rows: list[list[str]] = []
        for name, step in zip(self._names, self.steps, strict=True):
            numbers = step.metrics.numbers
            texts = [
                number_text(unit.shown(value) if name in _OF_VALUES else value, 3)
                for name, value in numbers.items()
            ]
            by = number_text(unit.shown(step.amplitude), 2)
            row = [name, number_text(step.begin, 2), by, *texts, step.metrics.withheld]
            rows.insert(0, row)
        self.statistics.show_table(heads, rows)


MOST_POINTS = 3000
"""Largest number of drawn points of a curve; others between them are left out."""


class XYChart(WindowPlot):
    """Plots every signal except the first over the first; see `WindowPlot`.

    Args:
        workspace: source of colours, units and preferences.

    Attributes:
        is_equal: whether both axes have the same scale.
    """

    PERIOD = 0.1

    equal_changed = pyqtSignal()
    """The user has switched equal scales on or off."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self.is_equal = False
        self._when: float | None = None
        self._zoomed = False
        self._model.hint = "Drag a signal here for x, then one or more for y"

    @property
    def curves(self) -> tuple[Curve, ...]:
        """The curves over the first signal."""
        return tuple(self.signals)[1:]

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

    def toggle_curve(self, index: int) -> None:
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

    def columns(self) -> tuple[Column, ...]:
        """Return the visible samples in SI units, over time."""
        return tuple(Column(each.label, each.unit, *self.samples(each)) for each in self.signals)

    def _commands(self) -> list[Command]:
        """Return the commands; charts over time also have cursors and statistics."""
        over_time = (
            "Statistics",
            "Always show zero",
            "Set cursor A",
            "Set cursor B",
            "Clear cursors",
        )
        equal = Command("Equal scales", "E", self._choose_equal, self.is_equal)
        kept = [each for each in super()._commands() if each.text not in over_time]
        return [equal, *kept]

    def _choose_equal(self, equal: bool) -> None:
        self.set_equal(equal)
        self.equal_changed.emit()

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

    def _entries(self) -> list[Entry]:
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
                Entry(label, value, colour, curve.style, self._number(curve), curve.visible)
            )
        return made

    def _at(self, curve: Curve, when: float) -> tuple[float, float]:
        """Return x and y of a curve at a time [s]; NaN outside the samples."""
        time, x, y = self._pairs(curve)
        return value_at(time, x, when), value_at(time, y, when)

    def _pairs(self, curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times [s], x and y of a curve."""
        time, x = self.samples(self.first_of(curve))
        own, y = self.samples(curve)
        if len(own) == 0:
            return time[:0], x[:0], y[:0]
        if len(own) != len(time) or (own != time).any():
            y = np.interp(time, own, y, left=np.nan, right=np.nan)
        return time, x, y

    def _number(self, curve: Curve) -> int:
        return curve.number - 1 if len(self.curves) > 1 else 0

    def _content(self) -> Content:
        """Return the content to draw."""
        shown = [each for each in self.curves if each.visible]
        if not shown:
            one = f"{self.signals[0].label} is x: add a signal for y" if len(self.signals) else ""
            return Content(left=0.0, right=1.0, hint=one or self._model.hint)
        across = unit_for(self.signals[0].unit, self._workspace.preferences)
        units = [*dict.fromkeys(each.axis_unit for each in shown)]
        wide, extents = Extent(), [Extent() for _ in units]
        lines, points = [], []
        for curve in shown:
            time, x, y = self._pairs(curve)
            every, axis = max(1, math.ceil(len(time) / MOST_POINTS)), units.index(curve.axis_unit)
            x, y = wide.take(x) * across.factor, extents[axis].take(y)
            colour = self._workspace.look.curve(curve.colour)
            number = self._number(curve)
            lines.append(Line(x[::every], y[::every], axis, colour, curve.style, number))
            if self._when is not None:
                points.append(Point(*self._at(curve, self._when), axis, colour))
        if not self._zoomed:
            self._model.window.show(*_ends(wide, across))
        window = self._model.window
        window.forget_ranges()
        shown_in = [unit_for(unit, self._workspace.preferences) for unit in units]
        ends = [
            window.values(index, *_ends(extent, unit), self._now)
            for index, (unit, extent) in enumerate(zip(shown_in, extents, strict=True))
        ]
        left, right = self.window_ends
        if self.is_equal:
            left, right, ends[0] = self._equalled(left, right, ends[0])
        axes = tuple(Axis(unit, *each) for unit, each in zip(shown_in, ends, strict=True))
        self._model.show_axes(axes)
        points = [each._replace(x=each.x * across.factor) for each in points]
        return Content(
            left=left,
            right=right,
            x_label=f"{self.signals[0].label} {across.symbol}".strip(),
            x_unit=across.symbol,
            axes=axes,
            lines=tuple(lines),
            points=tuple(points),
        )

    def _equalled(self, left: float, right: float, ends: Ends) -> tuple[float, float, Ends]:
        """Return ends of both axes, one of them widened for equal scales."""
        low, high = ends
        size = self.canvas.view
        scale = max((right - left) / max(size.width(), 1.0), (high - low) / max(size.height(), 1.0))
        wide, tall = 0.5 * scale * size.width(), 0.5 * scale * size.height()
        x, y = 0.5 * (left + right), 0.5 * (low + high)
        return x - wide, x + wide, (y - tall, y + tall)


def _ends(extent: Extent, unit: Unit) -> Ends:
    """Return round ends of an axis, as shown."""
    if extent.low > extent.high:
        return 0.0, 1.0
    return round_ends(unit.shown(extent.low), unit.shown(extent.high), 1e-3)
