"""A chart that follows a flight: the last seconds of some signals."""

from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import pyqtSignal

from workbench.gui.charts.chart import Chart
from workbench.gui.charts.chart_command import COMMAND_SEPARATOR, ChartCommand
from workbench.gui.charts.chart_kind import TIME_CHART, ChartKind
from workbench.gui.charts.curve import ChartCurve, CurveStyle, SampleSource
from workbench.gui.errands import single_shot
from workbench.gui.workspace import Workspace

READING_PERIOD_S = 0.2
"""Shortest period of legible changes of digits [s of shown time]."""


@dataclass(frozen=True)
class TimeView:
    """The time window that charts share.

    Attributes:
        left: first visible time [s].
        right: last visible time [s].
        follows: whether the newest samples are shown as they arrive.
        note: a word over a paused picture.
        marks: times of cursors A and B [s], by name.
    """

    left: float
    right: float
    follows: bool
    note: str = ""
    marks: tuple[tuple[str, float], ...] = ()


class StripChart(Chart):
    """Draws the last seconds of its curves whenever `refresh` is called.

    Double click, Escape or Home: follow the flight again.

    Args:
        workspace: source of colours, units and preferences.

    Attributes:
        pause: pauses the picture.
    """

    view_changed = pyqtSignal()
    """The time window or the cursors A and B may have changed."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace, 0.1, "Chart")
        self._read = self._built = -np.inf
        self._column = 0.0
        self._phase = id(self) // 64 % 8 / 8  # charts do not all build in the same frame
        reading_period = round(1000.0 * READING_PERIOD_S)
        self._numbers_soon = single_shot(self._show_numbers, self, reading_period)
        self._model.hint = "No signal is shown here"
        self._model.times_ago = True
        help = "Pause the chart; the flight continues"
        self.pause = self._add_button("pause", "Pause", help)
        self.pause.setCheckable(True)
        self.pause.clicked.connect(self.set_paused)

    def replay_cursor(self, time: float) -> None:
        """Set the crosshair as a replay does: numbers follow as often as they are legible."""
        self.canvas.set_cursor(time)
        if not self._numbers_soon.isActive():
            self._numbers_soon.start()

    def add_curve(
        self,
        label: str,
        unit: str,
        source: SampleSource,
        *,
        colour: int | None = None,
        style: CurveStyle = CurveStyle.SOLID,
    ) -> ChartCurve:
        """Add a signal; curves with the same unit share an axis.

        Args:
            label: name in the legend.
            unit: SI unit, as in topics.
            source: returns times [s] and values from a time on [s].
            colour: number of its colour, `COMMAND` for that of commands, None for the first free
                one.
            style: line style.

        Raises:
            WorkbenchError: if there is no room for another curve or unit.
        """
        curve = self._model.curves.add(label, unit, source, colour, style)
        if self.is_paused:
            curve.freeze()
        self._curves_changed()
        return curve

    def clear(self) -> None:
        """Remove all curves."""
        for curve in self.curves:
            self.remove_curve(curve)

    def remove_curve(self, curve: ChartCurve) -> None:
        """Remove a curve."""
        self._model.curves.remove(curve)
        self._curves_changed()

    @property
    def view(self) -> TimeView:
        """The time window."""
        marks = tuple(sorted(self._model.marks.items()))
        return TimeView(*self.window_ends, not self.is_paused, self._model.note, marks)

    def take_view(self, view: TimeView) -> None:
        """Show the time window of another chart."""
        if view.follows:
            if self.is_paused:
                self._model.follow()
            self._model.window.span = view.right - view.left
        else:
            self._model.note = view.note
            self._model.stand()
            self._model.window.show(view.left, view.right)
        self._model.marks = dict(view.marks)
        self._settle()

    def refresh(self, now: float) -> None:
        """Draw the seconds until a time [s], unless paused or hidden."""
        self._model.now = now
        if self.is_paused or not self.isVisible() or self.visibleRegion().isEmpty():
            return
        if self._built <= now < self._built + self._column:
            self.canvas.move_on(*self._model.ends)  # no column of pixels is full yet
        else:
            self._draw()
        if not self._read <= now < self._read + READING_PERIOD_S:
            self._read = now
            self._show_numbers()

    def redraw(self) -> None:
        """Redraw, with all numbers."""
        self._draw()
        self._read = self._model.now
        self._show_numbers()

    def set_paused(self, paused: bool) -> None:
        """Pause the picture, or follow; the flight continues."""
        if paused:
            self._stand("PAUSED")
            self._settle()
        else:
            self.follow()

    @property
    def is_paused(self) -> bool:
        """Whether the picture is paused."""
        return not self._model.window.follows

    def follow(self) -> None:
        """Follow the newest samples again."""
        self._model.follow()
        self._settle()

    def reset(self) -> None:
        """Follow the newest samples again."""
        self.follow()

    def show_window(self, left: float, right: float) -> None:
        """Pause at a time window [s]."""
        self._stand("ZOOMED")
        self._model.window.show(left, right)
        self._settle()

    def set_times_ago(self, ago: bool) -> None:
        """Show times as ages; or, for data that are not of a live flight, as they are."""
        self._model.times_ago = ago

    def set_clock_start(self, start: float) -> None:
        """Show times from another time on [s], as a log's own clock has them."""
        self._model.clock_start = start
        self._settle()

    def _commands(self) -> list[ChartCommand]:
        return [
            ChartCommand("Pause the picture", "", self.set_paused, self.is_paused),
            ChartCommand("Follow the flight", "Esc Home", lambda _: self.follow()),
            COMMAND_SEPARATOR,
            *super()._commands(),
        ]

    def _stand(self, note: str) -> None:
        super()._stand(note if note == "ZOOMED" or not self.is_paused else self._model.note)

    def _settle(self) -> None:
        self.pause.setChecked(self.is_paused)
        super()._settle()
        self.view_changed.emit()

    def _draw(self) -> None:
        columns = self.canvas.columns
        left, right = self._model.ends
        first = self._built == -np.inf
        self._column = (right - left) / columns * (self._phase if first else 1.0)
        self._built = self._model.now
        self.canvas.show_content(self._model.content(columns))

    def _on_preference(self, name: str) -> None:
        super()._on_preference(name)
        if name == "chart_seconds" and not self.is_paused:
            self._model.window.span = self._workspace.preferences.number(name)
            self._settle()


CHART_KIND = ChartKind(TIME_CHART, "Over time", StripChart, log_axes="y")
