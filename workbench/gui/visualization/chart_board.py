"""The board of charts: a common time window, crosshair and pair of cursors."""

import dataclasses
import math
from collections.abc import Sequence

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtGui import (
    QKeyEvent,
    QResizeEvent,
    QShowEvent,
)
from PyQt6.QtWidgets import QGridLayout, QWidget

from workbench.gui.charts.strip_chart import StripChart, TimeView
from workbench.gui.charts.xy_chart import XYChart
from workbench.gui.visualization.chart_pane import ChartPane
from workbench.gui.visualization.derived_signals import SeriesSource
from workbench.gui.visualization.layouts import (
    MAX_BOARD_CHARTS,
    Board,
    ChartSpec,
)
from workbench.gui.visualization.overlays import Overlay
from workbench.gui.visualization.spec_limits import SpecContents
from workbench.gui.workspace import Workspace

MIN_NEIGHBOUR_CHART_PX = 340
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
        self._times_ago, self._clock_start = True, 0.0
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
        """Show charts of a source; those of a log keep the time window."""
        self._source = source
        kept = None if self._times_ago else self._view
        for pane in self._panes:
            pane.hide()
            pane.deleteLater()
        self._panes.clear()
        self._used = self._pointed = self._view = None
        for spec in board[:MAX_BOARD_CHARTS]:
            self._add(spec)
        self._arrange()
        if self._panes:
            self._use(self._panes[0])
        if kept is not None:
            self.show_view(kept)

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

    def set_clock_start(self, start: float) -> None:
        """Show times from another time on [s], as a log's own clock has them."""
        self._clock_start = start
        for pane in self._panes:
            if isinstance(pane.chart, StripChart):
                pane.chart.set_clock_start(start)

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
        if len(self._panes) >= MAX_BOARD_CHARTS:
            self._workspace.notices.warn(f"There are {MAX_BOARD_CHARTS} charts: remove one first.")
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
            if len(self._panes) >= MAX_BOARD_CHARTS:
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

    def add_signals(self, names: Sequence[str]) -> None:
        """Add signals to the selected chart."""
        for name in names:
            self.add_signal(name)

    def refresh(self, now: float) -> None:
        """Draw until a time [s]; the crosshair stays at the mouse."""
        self._now = now
        for pane in self._panes:
            pane.chart.refresh(now)
        if self._pointed is not None and not self._is_standing:
            self._point(self._pointed, self._pointed.chart.cursor_time)

    def point_at(self, time: float) -> None:
        """Set the crosshair of charts that stand to a time [s], unless the mouse has it."""
        if self._is_standing and self._pointed is None:
            for pane in self._panes:
                if isinstance(pane.chart, XYChart):
                    pane.chart.show_time(time)
                elif isinstance(pane.chart, StripChart):
                    pane.chart.replay_cursor(time)

    @property
    def _is_standing(self) -> bool:
        return self._view is not None and not self._view.follows

    def show_window(self, left: float, right: float) -> None:
        """Show all of a log, between two times [s]; the cursors stay."""
        self.show_view(TimeView(left, right, False, "", self._view_now().marks))

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
            chart.set_clock_start(self._clock_start)
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
        room = max(1, self.width() // MIN_NEIGHBOUR_CHART_PX) if self.isVisible() else 2
        if count <= 1:
            return 1
        return min(room, math.ceil(math.sqrt(count)) if room >= 2 else 1)

    def _arrange(self) -> None:
        for column in range(MAX_BOARD_CHARTS):
            self._grid.setColumnStretch(column, 0)
            self._grid.setRowStretch(column, 0)
        self._columns = self._columns_wanted()
        for index, pane in enumerate(self._panes):
            row, column = divmod(index, self._columns)
            self._grid.addWidget(pane, row, column)
            self._grid.setRowStretch(row, 1)
            self._grid.setColumnStretch(column, 1)
            pane.show()
