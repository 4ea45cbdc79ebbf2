"""The charts and their board: a common time window, crosshair and pair of cursors."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtGui import (
    QAction,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDropEvent,
    QKeyEvent,
    QMouseEvent,
    QResizeEvent,
    QShowEvent,
)
from PyQt6.QtWidgets import QFrame, QGridLayout, QMenu, QWidget

from workbench.common.errors import WorkbenchError
from workbench.design.response_metrics import LAST_PART, SETTLED, crossing_time
from workbench.design.step_responses import StepResponse
from workbench.gui.charts.curve import COMMAND, LIMIT, Curve, CurveStyle, Samples, source_of
from workbench.gui.charts.plots import LimitLine, SpectrumChart, StepChart, XYChart
from workbench.gui.charts.strip_chart import StripChart, TimeView
from workbench.gui.charts.ticks import Scale
from workbench.gui.layout import vbox
from workbench.gui.style import set_class
from workbench.gui.visualization.derived_signals import SeriesSource
from workbench.gui.visualization.layouts import (
    MOST_CHARTS,
    SPECTRUM,
    STEPS,
    TIME,
    XY,
    Board,
    ChartSpec,
)
from workbench.gui.visualization.log_messages import CaseLimits, SpecContents
from workbench.gui.visualization.overlays import Overlay
from workbench.gui.visualization.signal_catalog import signal_label
from workbench.gui.visualization.signal_tree import MIME
from workbench.gui.workspace import Workspace
from workbench.logs.spectrum import Welch

_LINEAR = {
    "v": "velocity_data.v",
    "p": "position_data",
    "w": "velocity_data.w",
    "a": "acceleration_data.vdot",
    "force": "force_torque_data.force",
}
_SENSORS = {"f": "specific_force", "w": "angular_velocity"}
_OTHERS = {
    "yaw_rate": "velocity_data.w_z",
    "roll": "position_data.roll",
    "pitch": "position_data.pitch",
    "yaw": "position_data.yaw",
    "charge": "drone_state.charge",
}
_BOUNDS = ("maximum", "minimum", "final", "mean")
"""Statistics of a signal that are levels of the signal itself."""
_UNITS = dict.fromkeys(("overshoot", "undershoot", "steady_state_error"), "%") | dict.fromkeys(
    ("rise_time", "settling_time", "t90"), "s"
)
NEAR = 0.02
"""Tolerance of a step's command, as a share of the case's, for a comparison with its baseline."""
FARTHEST = 4.0 * 3600.0
"""Length of lines over time [s]."""


def chart_signal(name: str) -> str:
    """Return the charts' name for a signal of a spec; "" without one."""
    if name in _OTHERS:
        return _OTHERS[name]
    sensor, _, channel = name.rpartition(".")
    quantity, _, part = channel.rpartition("_")
    if sensor:
        known = sensor == "imu" and quantity in _SENSORS and part in "xyz"
        return f"imu.{_SENSORS[quantity]}.{'xyz'.index(part)}" if known else ""
    if quantity in ("speed", "thrust") and part.isdecimal():
        return f"rotors.{quantity}.{int(part) - 1}"
    if quantity in _LINEAR and part in ("x", "y", "z"):
        return f"{_LINEAR[quantity]}{'.' if quantity == 'p' else '_'}{part}"
    return ""


def lines_over_time(spec: SpecContents, signal: str) -> list[tuple[str, float]]:
    """Return label and value of each level that a spec sets for a signal of the charts."""
    found = []
    for case in spec.cases:
        for metric, ends in case.limits.items():
            statistic, _, of = metric.partition(" of ")
            judged = chart_signal(of or case.signal)
            if metric == "peak_speed":
                statistic, judged = "maximum", "derived.speed"
            if statistic in _BOUNDS and judged == signal:
                found += _levels(f"{case.name}: {statistic}", *ends)
    return found


def _levels(label: str, least: float, most: float) -> list[tuple[str, float]]:
    ends = ((f"{label} ≥", least), (f"{label} ≤", most))
    return [(text, value) for text, value in ends if math.isfinite(value)]


def limits_of_step(spec: SpecContents, signal: str, step: StepResponse) -> Sequence[LimitLine]:
    """Return the limits of the case for a step of a signal of the charts.

    It is the case whose command is nearest to the flown one, with the same sign; its limits are
    scaled to the flown amplitude. The band around a baseline is drawn as recorded, and only if its
    amplitude is the flown one.
    """
    cases = [
        each
        for each in spec.cases
        if chart_signal(each.signal) == signal and each.command * step.amplitude > 0.0
    ]
    if not cases:
        return ()
    case = min(cases, key=lambda each: abs(each.command - step.amplitude))
    near = abs(case.command - step.amplitude) <= NEAR * abs(case.command)
    return [*_lines(case, step), *(_bands(case) if near else ())]


def _lines(case: CaseLimits, step: StepResponse) -> Iterator[LimitLine]:
    by, end = step.amplitude, float(step.time[-1])
    tenth = crossing_time(step.time, step.response, 0.1 * by)

    def level(label: str, value: float, since: float = 0.0, until: float = end) -> LimitLine:
        time = np.array([since, 0.5 * (since + until), until])
        return LimitLine(label, time, np.full(3, value))

    for metric, ends in case.limits.items():
        unit = _UNITS.get(metric, "")
        for sign, value in zip("≥≤", ends, strict=True):
            least, label = sign == "≥", f"{metric} {sign} {value:g} {unit}".strip()
            if not math.isfinite(value) or (least and value <= 0.0):
                continue
            match metric:
                case "overshoot":
                    yield level(label, by * (1.0 + 0.01 * value))
                case "undershoot":
                    yield level(label, -0.01 * value * by)
                case "peak":
                    yield level(label, math.copysign(value, by))
                case "steady_state_value" | "final" | "maximum" | "minimum" | "mean":
                    yield level(label, value)
                case "steady_state_error" if not least:
                    for side in (-1.0, 1.0):
                        wrong = by * (1.0 + 0.01 * side * value)
                        yield level(label, wrong, (1.0 - LAST_PART) * end)
                case "settling_time" if not least and value < end:
                    for side in (-1.0, 1.0):
                        yield level(label, by * (1.0 + side * SETTLED), value)
                case "rise_time" if math.isfinite(tenth) and tenth + value < end:
                    edge = tenth + value
                    begin, until = (0.0, edge) if least else (edge, end)
                    yield level(label, 0.9 * by, begin, until)
                case "t90" if value < end:
                    begin, until = (0.0, value) if least else (value, end)
                    yield level(label, 0.9 * by, begin, until)


def _bands(case: CaseLimits) -> Iterator[LimitLine]:
    for signal, (time, low, high) in case.bands.items():
        if chart_signal(signal) == chart_signal(case.signal):
            yield LimitLine("baseline", time, low)
            yield LimitLine("baseline", time, high)


KIND_NAMES = {
    TIME: "Over time",
    SPECTRUM: "Spectrum",
    XY: "x-y, over the first signal",
    STEPS: "Responses to steps of the first signal",
}
AnyChart = StripChart | SpectrumChart | XYChart | StepChart
_SCALES = {False: Scale.LINEAR, True: Scale.LOGARITHMIC}
_EMPTY = "Drag a signal here, or choose one in the list"


class ChartPane(QFrame):
    """Shows signals of a source by name, in a chart of some kind.

    Args:
        workspace: colours, units and notices.
        spec: content of the chart.
        source: source of the signals; missing ones are awaited.

    Attributes:
        chart: the visible chart; another kind has another one.
        spec: its content.
    """

    spec_changed = pyqtSignal()
    """It shows other signals, or shows them differently."""
    chart_made = pyqtSignal()
    """It has another chart."""
    used = pyqtSignal()
    """The user has selected it."""
    removal_wanted = pyqtSignal()
    """It should be removed."""
    split_wanted = pyqtSignal()
    """Each of its signals should get its own chart."""

    def __init__(self, workspace: Workspace, spec: ChartSpec, source: SeriesSource) -> None:
        super().__init__()
        set_class(self, "card")
        self._workspace = workspace
        self._source = source
        self.spec = spec
        self._told = ""
        self._overlays: tuple[Overlay, ...] = ()
        self._limits: SpecContents | None = None
        self._box = vbox(of=self, margins=(8, 6, 8, 6))
        self.setAcceptDrops(True)
        self.chart = self._make_chart()
        self._box.addWidget(self.chart)
        self.show_signals(spec.signals, source)

    @property
    def title(self) -> str:
        """Its name."""
        return self.spec.title

    def set_spec(self, spec: ChartSpec) -> None:
        """Set the content."""
        self.spec = spec
        old, self.chart = self.chart, self._make_chart()
        self._box.replaceWidget(old, self.chart)
        old.hide()
        old.deleteLater()
        self.show_signals(spec.signals, self._source)
        self.chart_made.emit()
        self.spec_changed.emit()

    def show_signals(self, names: tuple[str, ...], source: SeriesSource) -> None:
        """Show signals; those that the source lacks appear once it has them."""
        self._source, self.spec = source, dataclasses.replace(self.spec, signals=names)
        self.chart.clear()
        units = source.units
        try:
            for name in names:
                if name in units:
                    self._draw_signal(name, units[name])
        except WorkbenchError as error:  # no room for so many
            self._tell_once(str(error))
        missing = [name for name in names if name not in units]
        self.chart.set_hint(
            "Nothing flies yet: open a scenario, or a log"
            if not units
            else f"Not in this flight: {', '.join(missing)}"
            if missing
            else _EMPTY
        )

    def show_overlays(self, overlays: tuple[Overlay, ...]) -> None:
        """Draw the same signals of these logs, paler."""
        self._overlays = overlays
        self.show_signals(self.spec.signals, self._source)

    def show_limits(self, limits: SpecContents | None) -> None:
        """Draw the limits of a spec, None for none."""
        self._limits = limits
        self.show_signals(self.spec.signals, self._source)

    def add_signal(self, name: str) -> None:
        """Add a signal."""
        units = self._source.units
        if name in self.spec.signals or name not in units:
            return
        try:
            self._source.series(name, self.chart.window_ends[1])
            self._draw_signal(name, units[name])
        except WorkbenchError as error:
            self._workspace.notices.warn(str(error))
            return
        self.spec = dataclasses.replace(self.spec, signals=(*self.spec.signals, name))
        self.chart.redraw()
        self.spec_changed.emit()

    def remove_signal(self, name: str) -> None:
        """Remove a signal."""
        if name in self.spec.signals:
            kept = tuple(each for each in self.spec.signals if each != name)
            self.show_signals(kept, self._source)
            self.spec_changed.emit()

    def dragEnterEvent(self, event: QDragEnterEvent | None) -> None:
        """Accept signals."""
        data = event.mimeData() if event is not None else None
        if event is not None and data is not None and data.hasFormat(MIME):
            self.chart.canvas.set_focus_shown(True)
            event.acceptProposedAction()

    def dragLeaveEvent(self, event: QDragLeaveEvent | None) -> None:
        """Clear the highlight."""
        self.chart.canvas.set_focus_shown(self.chart.hasFocus())

    def dropEvent(self, event: QDropEvent | None) -> None:
        """Show the dropped signals."""
        data = event.mimeData() if event is not None else None
        if event is None or data is None:
            return
        for name in data.data(MIME).data().decode().splitlines():
            self.add_signal(name)
        self.chart.canvas.set_focus_shown(self.chart.hasFocus())
        self.used.emit()
        event.acceptProposedAction()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Become the selected chart."""
        self.used.emit()
        super().mousePressEvent(event)

    def _make_chart(self) -> AnyChart:
        """Return an empty chart of the required kind."""
        spec = self.spec
        made: AnyChart
        match spec.kind:
            case "spectrum":
                made = SpectrumChart(self._workspace)
                made.set_scales(_SCALES[spec.log_x], _SCALES[spec.log_y])
                made.set_welch(Welch(spec.window, spec.averages, spec.detrend))
                made.welch_changed.connect(self._take_welch)
            case "x-y":
                made = XYChart(self._workspace)
                made.set_equal(spec.equal)
                made.equal_changed.connect(self._take_equal)
            case "steps":
                made = StepChart(self._workspace)
                made.set_limits(self._limits_of_step)
            case _:
                made = StripChart(self._workspace)
                made.set_scales(y=_SCALES[spec.log_y])
        made.set_title(spec.title)
        made.focused.connect(self.used)
        self.setFocusProxy(made)
        kinds = QMenu("Show as", made)
        for kind, name in KIND_NAMES.items():
            action = _action(kinds, name, partial(self._show_as, kind))
            action.setCheckable(True)
            action.setChecked(kind == spec.kind)
            kinds.addAction(action)
        menu_action = kinds.menuAction()
        if menu_action is not None:
            made.extra_actions.append(menu_action)
        if spec.kind == SPECTRUM:
            made.extra_actions.append(
                _switch(made, "Logarithmic frequencies", spec.log_x, self._set_log_x)
            )
        if spec.kind in (TIME, SPECTRUM):
            made.extra_actions.append(
                _switch(made, "Logarithmic values", spec.log_y, self._set_log_y)
            )
        for text, do in (
            ("Remove last signal\tDel", lambda _: self._remove_last()),
            ("Split into a chart for each signal", lambda _: self.split_wanted.emit()),
            ("Remove this chart\tShift+Del", lambda _: self.removal_wanted.emit()),
        ):
            made.extra_actions.append(_action(made, text, do))
        return made

    def _set_log_x(self, on: bool) -> None:
        self.set_spec(dataclasses.replace(self.spec, log_x=on))

    def _set_log_y(self, on: bool) -> None:
        self.set_spec(dataclasses.replace(self.spec, log_y=on))

    def _show_as(self, kind: str, _: bool) -> None:
        if kind != self.spec.kind:
            self.set_spec(self.spec.of_kind(kind))

    def _take_welch(self) -> None:
        assert isinstance(self.chart, SpectrumChart)
        self.spec = dataclasses.replace(self.spec, **dataclasses.asdict(self.chart.welch))
        self.spec_changed.emit()

    def _take_equal(self) -> None:
        assert isinstance(self.chart, XYChart)
        self.spec = dataclasses.replace(self.spec, equal=self.chart.is_equal)
        self.spec_changed.emit()

    def _draw_signal(self, name: str, unit: str) -> None:
        topic, _, field = name.partition(".")
        is_command = topic == "command_velocity"
        label = f"{field} command" if is_command else signal_label(name)
        colour = None
        style = CurveStyle.SOLID
        if is_command:
            # in the dashed colour of its response, if that is here, too
            style = CurveStyle.DASHED
            answer = "w_z" if field == "yaw_rate" else field
            shown = {curve.label: curve.colour for curve in self.chart.curves}
            colour = shown.get(answer, COMMAND)

        series = partial(self._read, self._source, name)
        drawn = self.chart.add_curve(label, unit, series, colour=colour, style=style)
        for overlay in self._overlays:
            if name in overlay.units:
                self._draw_over(overlay, name, drawn)

        if self._limits is not None and self.spec.kind == TIME:
            for text, level in lines_over_time(self._limits, name):
                times = np.array([0.0, *np.arange(0.25, FARTHEST, 0.5)])
                source = source_of(times, np.full(len(times), level))
                self.chart.add_curve(text, unit, source, colour=LIMIT, style=CurveStyle.DASHED)

    def _draw_over(self, overlay: Overlay, name: str, drawn: Curve) -> None:
        """Draw a signal of a log, paler than the same signal here."""
        label, source = f"{drawn.label} · {overlay.name}", partial(self._read, overlay, name)
        if isinstance(self.chart, XYChart | StepChart):
            first = self.spec.signals[0]
            if name != first and first in overlay.units:
                across = partial(self._read, overlay, first)
                self.chart.add_over(across, label, drawn.unit, source, drawn.colour)
            return
        self.chart.add_curve(label, drawn.unit, source, colour=drawn.colour, style=CurveStyle.FAINT)

    def _limits_of_step(self, step: StepResponse) -> Sequence[LimitLine]:
        if self._limits is None or len(self.spec.signals) < 2:
            return ()
        return limits_of_step(self._limits, self.spec.signals[1], step)

    def _read(self, source: SeriesSource, name: str, since: float) -> Samples:
        """Return the samples of a signal; none if they cannot be computed, which is reported."""
        try:
            return source.series(name, since)
        except WorkbenchError as error:  # a filter that is invalid for these samples
            self._tell_once(str(error))
            return np.zeros(0), np.zeros(0)

    def _tell_once(self, said: str) -> None:
        """Report an error of a curve once, not with each picture."""
        if said != self._told:
            self._told = said
            self._workspace.notices.warn(said)

    def _remove_last(self) -> None:
        if self.spec.signals:
            self.remove_signal(self.spec.signals[-1])


def _switch(parent: QWidget, text: str, on: bool, do: Callable[[bool], object]) -> QAction:
    action = _action(parent, text, do)
    action.setCheckable(True)
    action.setChecked(on)
    return action


def _action(parent: QWidget, text: str, do: Callable[[bool], object]) -> QAction:
    action = QAction(text, parent)
    action.triggered.connect(do)
    return action


NARROWEST = 340
"""Least width of a chart with a neighbour [pixels]."""


class ChartBoard(QWidget):
    """The charts of one source.

    Charts over time share zoom, pause, crosshair, and cursors A and B.

    Args:
        workspace: colours, units and notices.
        source: source of the signals.
    """

    changed = pyqtSignal()
    """The charts, or their signals, have changed."""
    used = pyqtSignal(str)
    """Title of the selected chart, to which signals are added."""
    slid = pyqtSignal(float)
    """A chart was dragged sideways with Shift, by this much [s]."""
    view_changed = pyqtSignal()
    """The time window or the cursors A and B may have changed."""

    def __init__(self, workspace: Workspace, source: SeriesSource) -> None:
        super().__init__()
        self._workspace = workspace
        self._source = source
        self._panes: list[ChartPane] = []
        self._used: ChartPane | None = None
        self._pointed: ChartPane | None = None
        self._columns = 0
        self._now = 0.0
        self._view: TimeView | None = None
        self._takes_view = False
        self._times_ago = True
        self._overlays: tuple[Overlay, ...] = ()
        self._limits: SpecContents | None = None
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(8)

    @property
    def panes(self) -> tuple[ChartPane, ...]:
        """The charts."""
        return tuple(self._panes)

    @property
    def board(self) -> Board:
        """The content of all charts."""
        return tuple(pane.spec for pane in self._panes)

    @property
    def chart_in_use(self) -> ChartPane | None:
        """The selected chart, to which signals are added."""
        return self._used or (self._panes[0] if self._panes else None)

    @property
    def marks(self) -> dict[str, float]:
        """Times of cursors A and B [s], by name."""
        return dict(self._view.marks) if self._view is not None else {}

    def show_board(self, board: Board, source: SeriesSource) -> None:
        """Show charts of a source."""
        self._source = source
        for pane in self._panes:
            pane.hide()
            pane.deleteLater()
        self._panes.clear()
        self._used = self._pointed = self._view = None
        for spec in board[:MOST_CHARTS]:
            self._add(spec)
        self._arrange()
        if self._panes:
            self._use(self._panes[0])

    def show_source(self, source: SeriesSource, *, times_ago: bool) -> None:
        """Show the same signals of another source, and follow it.

        Args:
            source: source of the signals.
            times_ago: whether to show times as ages.
        """
        self._source, self._times_ago = source, times_ago
        for pane in self._panes:
            pane.chart.set_times_ago(self._times_ago)
            pane.show_signals(pane.spec.signals, source)
        if self._view is not None:
            span = self._workspace.preferences.number("chart_seconds")
            self.show_view(TimeView(-span, 0.0, follows=True))

    def change_source(self, source: SeriesSource) -> None:
        """Show the same signals from a source with additional ones, in the same time window."""
        self._source = source
        for pane in self._panes:
            pane.show_signals(pane.spec.signals, source)

    def show_overlays(self, overlays: tuple[Overlay, ...]) -> None:
        """Draw the same signals of these logs."""
        self._overlays = overlays
        for pane in self._panes:
            pane.show_overlays(overlays)

    def show_limits(self, limits: SpecContents | None) -> None:
        """Draw the limits of a spec, None for none."""
        self._limits = limits
        for pane in self._panes:
            pane.show_limits(limits)

    def rename_signal(self, old: str, new: str) -> None:
        """Show a signal under its new name."""
        for pane in self._panes:
            names = pane.spec.signals
            if old in names:
                renamed = tuple(new if name == old else name for name in names)
                pane.show_signals(renamed, self._source)
        self.changed.emit()

    def set_marks(self, marks: dict[str, float]) -> None:
        """Set cursors A and B to times [s], or remove them."""
        view = self._view_now()
        self.show_view(dataclasses.replace(view, marks=tuple(sorted(marks.items()))))

    def add_chart(self, spec: ChartSpec | None = None) -> None:
        """Add a chart; a notice says if there are too many."""
        if len(self._panes) >= MOST_CHARTS:
            self._workspace.notices.warn(f"There are {MOST_CHARTS} charts: remove one first.")
            return
        self._add(spec or ChartSpec(f"Chart {len(self._panes) + 1}"))
        self._arrange()
        self._use(self._panes[-1])
        self.changed.emit()

    def remove_chart(self, pane: ChartPane) -> None:
        """Remove a chart."""
        self._panes.remove(pane)
        pane.hide()
        pane.deleteLater()
        if self._pointed is pane:
            self._pointed = None
        if self._used is pane:
            self._used = None
            if self._panes:
                self._use(self._panes[0])
        self._arrange()
        self.changed.emit()

    def split_chart(self, pane: ChartPane) -> None:
        """Give each signal of a chart its own chart, as far as there is room."""
        names = pane.spec.signals
        for name in names[1:]:
            if len(self._panes) >= MOST_CHARTS:
                break
            pane.remove_signal(name)
            self.add_chart(dataclasses.replace(pane.spec, title=name, signals=(name,)))

    def add_signal(self, name: str) -> None:
        """Add a signal to the selected chart."""
        if not self._panes:
            self.add_chart()
        pane = self.chart_in_use
        if pane is not None:
            pane.add_signal(name)

    def refresh(self, now: float) -> None:
        """Draw until a time [s]; the crosshair stays at the mouse."""
        self._now = now
        for pane in self._panes:
            pane.chart.refresh(now)
        if self._pointed is not None and not self._is_standing:
            self._point(self._pointed, self._pointed.chart.cursor_time)

    @property
    def _is_standing(self) -> bool:
        return self._view is not None and not self._view.follows

    def show_window(self, left: float, right: float) -> None:
        """Pause all charts at a time window [s]."""
        view = self._view_now()
        self.show_view(TimeView(left, right, False, "ZOOMED", view.marks))

    def set_paused(self, paused: bool) -> None:
        """Pause all charts, or follow."""
        view = self._view_now()
        if paused:
            self.show_view(dataclasses.replace(view, follows=False, note="PAUSED"))
        else:
            left = self._now - self._workspace.preferences.number("chart_seconds")
            self.show_view(TimeView(left, self._now, True, "", view.marks))

    def _view_now(self) -> TimeView:
        """Return the time window."""
        for pane in self._panes:
            if isinstance(pane.chart, StripChart):
                return pane.chart.view
        left = self._now - self._workspace.preferences.number("chart_seconds")
        return self._view or TimeView(left, self._now, True)

    def show_view(self, view: TimeView, but: ChartPane | None = None) -> None:
        """Show a time window and cursors in all charts.

        Args:
            view: the time window and cursors.
            but: the chart that already shows it.
        """
        self._view, self._takes_view = view, True
        for pane in self._panes:
            if pane is not but:
                pane.chart.take_view(view)
        self._takes_view = False
        self.view_changed.emit()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Use as many columns as fit."""
        if self._columns_wanted() != self._columns:
            self._arrange()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Use as many columns as fit."""
        if self._columns_wanted() != self._columns:
            self._arrange()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Remove a signal or chart by Del and Shift+Del."""
        pane = self._used
        if event is None or pane is None or event.key() != Qt.Key.Key_Delete:
            super().keyPressEvent(event)
        elif event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self.remove_chart(pane)
        elif pane.spec.signals:
            pane.remove_signal(pane.spec.signals[-1])

    def _add(self, spec: ChartSpec) -> None:
        pane = ChartPane(self._workspace, spec, self._source)
        self._panes.append(pane)
        if self._overlays:
            pane.show_overlays(self._overlays)
        if self._limits is not None:
            pane.show_limits(self._limits)
        pane.used.connect(lambda: self._use(pane))
        pane.spec_changed.connect(self.changed)
        pane.removal_wanted.connect(lambda: self.remove_chart(pane))
        pane.split_wanted.connect(lambda: self.split_chart(pane))
        pane.chart_made.connect(lambda: self._link(pane))
        self._link(pane)

    def _link(self, pane: ChartPane) -> None:
        """Connect a new chart with the others."""
        chart = pane.chart
        pane.chart.set_times_ago(self._times_ago)
        if self._view is not None:
            self._takes_view = True
            chart.take_view(self._view)
            self._takes_view = False
        chart.refresh(self._now)
        if isinstance(chart, StripChart):
            chart.view_changed.connect(lambda: self._take_view(pane, chart))
            chart.cursor_moved.connect(lambda time: self._hover(pane, time))
            chart.slid.connect(self.slid)

    def _take_view(self, pane: ChartPane, chart: StripChart) -> None:
        if not self._takes_view and chart.view != self._view:
            self.show_view(chart.view, but=pane)

    def _hover(self, pane: ChartPane, time: float | None) -> None:
        self._pointed = None if time is None else pane
        self._point(pane, time)

    def _point(self, pane: ChartPane, time: float | None) -> None:
        """Set the crosshair of the other charts to a time [s]."""
        for each in self._panes:
            if isinstance(each.chart, XYChart):
                each.chart.show_time(time)
            elif isinstance(each.chart, StripChart) and each is not pane:
                each.chart.set_cursor(time)

    def _use(self, pane: ChartPane) -> None:
        self._used = pane
        self.used.emit(pane.title)

    def _columns_wanted(self) -> int:
        count = len(self._panes)
        # before it is visible its width is unknown, and charts in one column would be too high
        room = max(1, self.width() // NARROWEST) if self.isVisible() else 2
        if count <= 1:
            return 1
        return min(room, math.ceil(math.sqrt(count)) if room >= 2 else 1)

    def _arrange(self) -> None:
        for column in range(MOST_CHARTS):
            self._grid.setColumnStretch(column, 0)
            self._grid.setRowStretch(column, 0)
        self._columns = self._columns_wanted()
        for index, pane in enumerate(self._panes):
            row, column = divmod(index, self._columns)
            self._grid.addWidget(pane, row, column)
            self._grid.setRowStretch(row, 1)
            self._grid.setColumnStretch(column, 1)
            pane.show()
