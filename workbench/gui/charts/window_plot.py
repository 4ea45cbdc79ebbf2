"""A plot that is computed from signals over the time window of the charts beside it."""

import math
from typing import TYPE_CHECKING

import numpy as np
from PyQt6.QtCore import pyqtSignal

from workbench.common.series import TimedValues
from workbench.gui.charts.curve import ChartCurve, CurveSet, CurveStyle, SampleSource
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.charts.strip_chart import TimeView
from workbench.gui.workspace import Workspace

if TYPE_CHECKING:
    from workbench.gui.visualization.layouts import ChartSpec


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

    options_changed = pyqtSignal()
    """The user has changed an option that a layout keeps."""

    def __init__(self, workspace: Workspace) -> None:
        self.signals = CurveSet()
        self._firsts: dict[ChartCurve, ChartCurve] = {}
        span = workspace.preferences.number("chart_seconds")
        self._view = TimeView(-span, 0.0, True)
        self._made = -math.inf
        self._now = 0.0
        super().__init__(workspace)

    def set_options(self, spec: "ChartSpec") -> None:
        """Set the options that a layout keeps."""

    def with_options(self, spec: "ChartSpec") -> "ChartSpec":
        """Return a content with these options."""
        return spec

    def add_curve(
        self,
        label: str,
        unit: str,
        source: SampleSource,
        *,
        colour: int | None = None,
        style: CurveStyle = CurveStyle.SOLID,
    ) -> ChartCurve:
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

    def add_over(
        self, first: SampleSource, label: str, unit: str, source: SampleSource, colour: int
    ) -> ChartCurve:
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
        self._firsts[made] = ChartCurve(ours.label, ours.unit, first)
        if not self._view.follows:
            self._firsts[made].freeze()
        return made

    def first_of(self, curve: ChartCurve) -> ChartCurve:
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
        """Compute the curves from the signals, and draw them by `show_curves`."""
        raise NotImplementedError

    def show_curves(self, curves: CurveSet) -> None:
        """Draw what `make` has computed."""
        self._model.curves = curves
        self._describe()
        super()._redraw_if_seen()

    def set_times_ago(self, ago: bool) -> None:
        """Do nothing: it shows no times."""

    def samples(self, curve: ChartCurve) -> TimedValues:
        """Return a signal's samples in the time window, as views that must be used at once."""
        left, right = self.part
        time, values = curve.samples(left)
        first, last = np.searchsorted(time, left), np.searchsorted(time, right, side="right")
        return time[first:last], values[first:last]

    def _redraw_if_seen(self) -> None:
        if self._made == -math.inf:
            self.refresh(self._now)
        super()._redraw_if_seen()
