"""One chart of a board: signals of a source, in a chart of some kind."""

import dataclasses
from collections.abc import Sequence
from functools import partial

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import QDragEnterEvent, QDragLeaveEvent, QDropEvent, QMouseEvent
from PyQt6.QtWidgets import QFrame, QMenu

from workbench.common.errors import WorkbenchError
from workbench.common.series import Series, TimedValues
from workbench.design.step_responses import LoggedStep
from workbench.gui.charts.chart_kind import TIME_CHART, chart_kinds
from workbench.gui.charts.curve import (
    COMMAND_COLOUR,
    LIMIT_COLOUR,
    ChartCurve,
    CurveStyle,
    fixed_source,
)
from workbench.gui.charts.step_chart import StepChart
from workbench.gui.charts.strip_chart import StripChart
from workbench.gui.charts.ticks import Scale
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.layout import add_action, vbox
from workbench.gui.style import set_class
from workbench.gui.visualization.derived_signals import SeriesSource
from workbench.gui.visualization.layouts import ChartSpec
from workbench.gui.visualization.limit_lines import limits_of_step, lines_over_time
from workbench.gui.visualization.overlays import Overlay
from workbench.gui.visualization.signal_catalog import (
    bound_label,
    estimate_label,
    following_labels,
    setpoint_label,
    signal_label,
)
from workbench.gui.visualization.signal_tree import SIGNAL_MIME_TYPE
from workbench.gui.visualization.spec_limits import SpecContents
from workbench.gui.workspace import Workspace

LIMIT_LINE_LENGTH_S = 4.0 * 3600.0
"""Length of lines over time [s]."""
_SCALE_BY_LOG = {False: Scale.LINEAR, True: Scale.LOGARITHMIC}
_EMPTY_CHART_HINT = "Drag a signal here, or choose one in the list"


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
        workspace.absence.changed.connect(self._show_absence)

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
            self._workspace.absence.text or _EMPTY_CHART_HINT
            if not units
            else f"Not in this flight: {', '.join(missing)}"
            if missing
            else _EMPTY_CHART_HINT
        )

    def _show_absence(self, text: str) -> None:
        if text and not self._source.units:
            self.chart.set_hint(text)

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
        before, names = self.spec.signals, (*self.spec.signals, name)
        if any(estimate_label(each, names) != estimate_label(each, before) for each in before):
            self.show_signals(names, self._source)
        self.spec = dataclasses.replace(self.spec, signals=names)
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
        if event is not None and data is not None and data.hasFormat(SIGNAL_MIME_TYPE):
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
        for name in data.data(SIGNAL_MIME_TYPE).data().decode().splitlines():
            self.add_signal(name)
        self.chart.canvas.set_focus_shown(self.chart.hasFocus())
        self.used.emit()
        event.acceptProposedAction()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Become the selected chart."""
        self.used.emit()
        super().mousePressEvent(event)

    def _make_chart(self) -> StripChart | WindowPlot:
        """Return an empty chart of the required kind."""
        spec, kind = self.spec, chart_kinds()[self.spec.kind]
        made = kind.make(self._workspace)
        if kind.log_axes:
            x = spec.log_x and "x" in kind.log_axes
            made.set_scales(_SCALE_BY_LOG[x], _SCALE_BY_LOG[spec.log_y])
        if isinstance(made, WindowPlot):
            made.set_options(spec)
            made.options_changed.connect(self._take_options)
        if isinstance(made, StepChart):
            made.set_limits(self._limits_of_step)
        made.set_title(spec.title)
        made.focused.connect(self.used)
        self.setFocusProxy(made)
        kinds = QMenu("Show as", made)
        for each in chart_kinds().values():
            add_action(kinds, each.title, partial(self._show_as, each.name), each is kind)
        menu_action = kinds.menuAction()
        if menu_action is not None:
            made.extra_actions.append(menu_action)
        for axis, text, on, do in (
            ("x", "Logarithmic frequencies", spec.log_x, self._set_log_x),
            ("y", "Logarithmic values", spec.log_y, self._set_log_y),
        ):
            if axis in kind.log_axes:
                made.extra_actions.append(add_action(made, text, do, on))
        for text, act in (
            ("Remove last signal\tDel", lambda _: self._remove_last()),
            ("Split into a chart for each signal", lambda _: self.split_wanted.emit()),
            ("Remove this chart\tShift+Del", lambda _: self.removal_wanted.emit()),
        ):
            made.extra_actions.append(add_action(made, text, act))
        return made

    def _set_log_x(self, on: bool) -> None:
        self.set_spec(dataclasses.replace(self.spec, log_x=on))

    def _set_log_y(self, on: bool) -> None:
        self.set_spec(dataclasses.replace(self.spec, log_y=on))

    def _show_as(self, kind: str, _: bool) -> None:
        if kind != self.spec.kind:
            self.set_spec(self.spec.of_kind(kind))

    def _take_options(self) -> None:
        assert isinstance(self.chart, WindowPlot)
        self.spec = self.chart.with_options(self.spec)
        self.spec_changed.emit()

    def _draw_signal(self, name: str, unit: str) -> None:
        label, colour, style = setpoint_label(name), None, CurveStyle.SOLID
        shown = {curve.label: curve.colour for curve in self.chart.curves}
        if label:
            # in the dashed colour of its response, if that is here, too
            style = CurveStyle.DASHED
            answers = (shown[each] for each in following_labels(name) if each in shown)
            colour = next(answers, COMMAND_COLOUR)
        elif label := bound_label(name):
            # in the paler colour of its estimate
            style = CurveStyle.FAINT
            colour = shown.get(f"{label.partition(' ')[0]} estimate")
        label = label or estimate_label(name, (*self.spec.signals, name)) or signal_label(name)

        series = partial(self._read, self._source, name)
        drawn = self.chart.add_curve(label, unit, series, colour=colour, style=style)
        for overlay in self._overlays:
            if over := overlay.signal(name):
                label = drawn.label if over == name else signal_label(over)
                self._draw_over(overlay, over, f"{label} · {overlay.name}", drawn)

        if self._limits is not None and self.spec.kind == TIME_CHART:
            for text, level in lines_over_time(self._limits, name):
                times = np.array([0.0, *np.arange(0.25, LIMIT_LINE_LENGTH_S, 0.5)])
                source = fixed_source(times, np.full(len(times), level))
                self.chart.add_curve(
                    text, unit, source, colour=LIMIT_COLOUR, style=CurveStyle.DASHED
                )

    def _draw_over(self, overlay: Overlay, name: str, label: str, drawn: ChartCurve) -> None:
        """Draw a signal of a log, paler than the same signal here."""
        source = partial(self._read, overlay, name)
        if isinstance(self.chart, WindowPlot) and chart_kinds()[self.spec.kind].over_first:
            first = overlay.signal(self.spec.signals[0])
            if first and name != first:
                across = partial(self._read, overlay, first)
                self.chart.add_over(across, label, drawn.unit, source, drawn.colour)
            return
        self.chart.add_curve(label, drawn.unit, source, colour=drawn.colour, style=CurveStyle.FAINT)

    def _limits_of_step(self, step: LoggedStep) -> Sequence[Series]:
        if self._limits is None or len(self.spec.signals) < 2:
            return ()
        return limits_of_step(self._limits, self.spec.signals[1], step)

    def _read(self, source: SeriesSource, name: str, since: float) -> TimedValues:
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
