"""One chart of the board: what it shows, of which kind, and what is dropped on it."""

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import QAction, QDragEnterEvent, QDragLeaveEvent, QDropEvent, QMouseEvent
from PyQt6.QtWidgets import QFrame, QMenu, QVBoxLayout, QWidget

from workbench.common.errors import WorkbenchError
from workbench.design.step_responses import StepResponse
from workbench.gui.charts.curve import COMMAND, LIMIT, Curve, CurveStyle, Samples, source_of
from workbench.gui.charts.scale import Scale
from workbench.gui.charts.spectrum_chart import SpectrumChart
from workbench.gui.charts.step_chart import LimitLine, StepChart
from workbench.gui.charts.strip_chart import StripChart
from workbench.gui.charts.xy_chart import XYChart
from workbench.gui.style import set_class
from workbench.gui.visualization.derived_signals import SeriesSource
from workbench.gui.visualization.layouts import SPECTRUM, STEPS, TIME, XY, ChartSpec
from workbench.gui.visualization.log_messages import SpecContents
from workbench.gui.visualization.overlays import Overlay
from workbench.gui.visualization.signal_catalog import signal_label
from workbench.gui.visualization.signal_tree import MIME
from workbench.gui.visualization.spec_limits import FARTHEST, limits_of_step, lines_over_time
from workbench.gui.workspace import Workspace
from workbench.logs.spectrum import Welch

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
    """Shows signals of a source by their names, in a chart of some kind.

    Args:
        workspace: colours, units and notices.
        spec: what it shows.
        source: of the signals; those that it has not are waited for.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        chart: that is seen; another kind has another one.
    """

    spec_changed = pyqtSignal()
    """It shows other signals, or shows them otherwise."""
    chart_made = pyqtSignal()
    """It has another chart."""
    used = pyqtSignal()
    """The user has turned to it."""
    removal_wanted = pyqtSignal()
    """It is to go."""
    split_wanted = pyqtSignal()
    """Each of its signals is to have a chart of its own."""

    def __init__(
        self,
        workspace: Workspace,
        spec: ChartSpec,
        source: SeriesSource,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        set_class(self, "card")
        self._workspace = workspace
        self._source = source
        self._spec = spec
        self._told = ""
        self._overlays: tuple[Overlay, ...] = ()
        self._limits: SpecContents | None = None
        self._box = QVBoxLayout(self)
        self._box.setContentsMargins(8, 6, 8, 6)
        self.setAcceptDrops(True)
        self.chart = self._make_chart()
        self._box.addWidget(self.chart)
        self.show_signals(spec.signals, source)

    @property
    def spec(self) -> ChartSpec:
        """What it shows."""
        return self._spec

    @property
    def title(self) -> str:
        """Its name."""
        return self._spec.title

    def set_spec(self, spec: ChartSpec) -> None:
        """Show this."""
        self._spec = spec
        old, self.chart = self.chart, self._make_chart()
        self._box.replaceWidget(old, self.chart)
        old.hide()
        old.deleteLater()
        self.show_signals(spec.signals, self._source)
        self.chart_made.emit()
        self.spec_changed.emit()

    def show_signals(self, names: tuple[str, ...], source: SeriesSource) -> None:
        """Show these signals; those that the source has not are kept, and shown once it has."""
        self._source, self._spec = source, dataclasses.replace(self._spec, signals=names)
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
            else f"Not measured here: {', '.join(missing)}"
            if missing
            else _EMPTY
        )

    def show_overlays(self, overlays: tuple[Overlay, ...]) -> None:
        """Draw the same signals of these logs, too, paler."""
        self._overlays = overlays
        self.show_signals(self._spec.signals, self._source)

    def show_limits(self, limits: SpecContents | None) -> None:
        """Draw the limits of a spec, None for none."""
        self._limits = limits
        self.show_signals(self._spec.signals, self._source)

    def add_signal(self, name: str) -> None:
        """Show another signal."""
        units = self._source.units
        if name in self._spec.signals or name not in units:
            return
        try:
            self._source.series(name, self.chart.window_ends[1])
            self._draw_signal(name, units[name])
        except WorkbenchError as error:
            self._workspace.notices.warn(str(error))
            return
        self._spec = dataclasses.replace(self._spec, signals=(*self._spec.signals, name))
        self.chart.redraw()
        self.spec_changed.emit()

    def remove_signal(self, name: str) -> None:
        """Show a signal no more."""
        if name in self._spec.signals:
            kept = tuple(each for each in self._spec.signals if each != name)
            self.show_signals(kept, self._source)
            self.spec_changed.emit()

    def dragEnterEvent(self, event: QDragEnterEvent | None) -> None:
        """Take signals."""
        data = event.mimeData() if event is not None else None
        if event is not None and data is not None and data.hasFormat(MIME):
            self.chart.canvas.set_focus_shown(True)
            event.acceptProposedAction()

    def dragLeaveEvent(self, event: QDragLeaveEvent | None) -> None:
        """Show that it would take none."""
        self.chart.canvas.set_focus_shown(self.chart.hasFocus())

    def dropEvent(self, event: QDropEvent | None) -> None:
        """Show what was dropped."""
        data = event.mimeData() if event is not None else None
        if event is None or data is None:
            return
        for name in data.data(MIME).data().decode().splitlines():
            self.add_signal(name)
        self.chart.canvas.set_focus_shown(self.chart.hasFocus())
        self.used.emit()
        event.acceptProposedAction()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Be the chart in use."""
        self.used.emit()
        super().mousePressEvent(event)

    def _make_chart(self) -> AnyChart:
        """Return a chart of the kind that is wanted, still empty."""
        spec = self._spec
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
        self.set_spec(dataclasses.replace(self._spec, log_x=on))

    def _set_log_y(self, on: bool) -> None:
        self.set_spec(dataclasses.replace(self._spec, log_y=on))

    def _show_as(self, kind: str, _: bool) -> None:
        if kind != self._spec.kind:
            self.set_spec(self._spec.of_kind(kind))

    def _take_welch(self) -> None:
        assert isinstance(self.chart, SpectrumChart)
        self._spec = dataclasses.replace(self._spec, **dataclasses.asdict(self.chart.welch))
        self.spec_changed.emit()

    def _take_equal(self) -> None:
        assert isinstance(self.chart, XYChart)
        self._spec = dataclasses.replace(self._spec, equal=self.chart.is_equal)
        self.spec_changed.emit()

    def _draw_signal(self, name: str, unit: str) -> None:
        topic, _, field = name.partition(".")
        is_command = topic == "command_velocity"
        label = f"{field} command" if is_command else signal_label(name)
        colour = None
        style = CurveStyle.SOLID
        if is_command:
            # the colour of its answer, dashed, where that is here, too
            style = CurveStyle.DASHED
            answer = "w_z" if field == "yaw_rate" else field
            shown = {curve.label: curve.colour for curve in self.chart.curves}
            colour = shown.get(answer, COMMAND)

        series = partial(self._read, self._source, name)
        drawn = self.chart.add_curve(label, unit, series, colour=colour, style=style)
        for overlay in self._overlays:
            if name in overlay.units:
                self._draw_over(overlay, name, drawn)

        if self._limits is not None and self._spec.kind == TIME:
            for text, level in lines_over_time(self._limits, name):
                times = np.array([0.0, *np.arange(0.25, FARTHEST, 0.5)])
                source = source_of(times, np.full(len(times), level))
                self.chart.add_curve(text, unit, source, colour=LIMIT, style=CurveStyle.DASHED)

    def _draw_over(self, overlay: Overlay, name: str, drawn: Curve) -> None:
        """Draw a signal of a log paler than the curve of the same signal here."""
        label, source = f"{drawn.label} · {overlay.name}", partial(self._read, overlay, name)
        if isinstance(self.chart, XYChart | StepChart):
            first = self._spec.signals[0]
            if name != first and first in overlay.units:
                across = partial(self._read, overlay, first)
                self.chart.add_over(across, label, drawn.unit, source, drawn.colour)
            return
        self.chart.add_curve(label, drawn.unit, source, colour=drawn.colour, style=CurveStyle.FAINT)

    def _limits_of_step(self, step: StepResponse) -> Sequence[LimitLine]:
        if self._limits is None or len(self._spec.signals) < 2:
            return ()
        return limits_of_step(self._limits, self._spec.signals[1], step)

    def _read(self, source: SeriesSource, name: str, since: float) -> Samples:
        """Return the samples of a signal; none where they cannot be worked out, which is told."""
        try:
            return source.series(name, since)
        except WorkbenchError as error:  # a filter that these samples do not allow
            self._tell_once(str(error))
            return np.zeros(0), np.zeros(0)

    def _tell_once(self, said: str) -> None:
        """Tell what is wrong with a curve, not with each picture."""
        if said != self._told:
            self._told = said
            self._workspace.notices.warn(said)

    def _remove_last(self) -> None:
        if self._spec.signals:
            self.remove_signal(self._spec.signals[-1])


def _switch(parent: QWidget, text: str, on: bool, do: Callable[[bool], object]) -> QAction:
    action = _action(parent, text, do)
    action.setCheckable(True)
    action.setChecked(on)
    return action


def _action(parent: QWidget, text: str, do: Callable[[bool], object]) -> QAction:
    action = QAction(text, parent)
    action.triggered.connect(do)
    return action
