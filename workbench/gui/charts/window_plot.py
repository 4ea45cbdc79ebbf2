"""A plot that is made from what signals were in a part of time."""

import math

import numpy as np
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.curve import Curve, CurveSet, CurveStyle, Samples, Source
from workbench.gui.charts.plot import StaticPlot
from workbench.gui.charts.strip_chart import TimeView
from workbench.gui.workspace import Workspace


class WindowPlot(StaticPlot):
    """Makes its curves anew as time goes on, from the samples that strip charts beside it show.

    With cursors A and B in time, it is made of what lies between them.

    Args:
        workspace: colours, units and preferences.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        signals: over time, from which it is made.
    """

    PERIOD = 0.2
    """Between two pictures [s]."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        self.signals = CurveSet()
        self._firsts: dict[Curve, Curve] = {}
        span = workspace.preferences.number("chart_seconds")
        self._view = TimeView(-span, 0.0, True)
        self._made = -math.inf
        self._now = 0.0
        super().__init__(workspace, parent)

    def add_curve(
        self,
        label: str,
        unit: str,
        source: Source,
        *,
        colour: int | None = None,
        style: CurveStyle = CurveStyle.SOLID,
    ) -> Curve:
        """Take another signal; arguments are those of `StripChart.add_curve`.

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
        """Take a signal of another flight, paler, with its own first signal in place of ours.

        Args:
            first: of the other flight.
            label: in the legend.
            unit: SI.
            source: of the signal.
            colour: its number.

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
        """Return the first signal of the flight that a signal is of."""
        return self._firsts.get(curve, self.signals[0])

    def clear(self) -> None:
        """Draw nothing any more."""
        self.signals = CurveSet()
        self._firsts = {}
        super().clear()

    @property
    def part(self) -> tuple[float, float]:
        """First and last time of which it is made [s]."""
        marks = [time for _, time in self._view.marks]
        if len(marks) == 2 and marks[0] != marks[1]:
            return min(marks), max(marks)
        if self._view.follows:
            return self._now - (self._view.right - self._view.left), self._now
        return self._view.left, self._view.right

    def take_view(self, view: TimeView) -> None:
        """Be made of the part of time that strip charts show."""
        if view.follows is not self._view.follows:
            for curve in (*self.signals, *self._firsts.values()):
                curve.thaw() if view.follows else curve.freeze()
        self._view = view
        self._made = -math.inf
        self.refresh(self._now)

    def refresh(self, now: float) -> None:
        """Make it anew for a time [s], not too often, and only where it is seen."""
        self._now = now
        fresh = self._made <= now < self._made + self.PERIOD
        stands = not self._view.follows and self._made > -math.inf
        if fresh or stands or not self.isVisible():
            return
        self._made = now
        self.make()

    def make(self) -> None:
        """Make the curves from the signals."""
        raise NotImplementedError

    def show_clock_times(self) -> None:
        """Do nothing: it shows no times."""

    def show_times_ago(self) -> None:
        """Do nothing: it shows no times."""

    def samples(self, curve: Curve) -> Samples:
        """Return the samples of a signal in the part of time: views, to be used at once."""
        left, right = self.part
        time, values = curve.samples(left)
        first, last = np.searchsorted(time, left), np.searchsorted(time, right, side="right")
        return time[first:last], values[first:last]

    def _redraw_if_seen(self) -> None:
        if self._made == -math.inf:
            self.refresh(self._now)
        super()._redraw_if_seen()
