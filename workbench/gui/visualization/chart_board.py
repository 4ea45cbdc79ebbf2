"""Up to eight charts in a grid; signals can be dropped on each."""

import math
from collections.abc import Callable

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtGui import (
    QAction,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDropEvent,
    QFocusEvent,
    QKeyEvent,
    QMouseEvent,
    QResizeEvent,
    QShowEvent,
)
from PyQt6.QtWidgets import QFrame, QGridLayout, QVBoxLayout, QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.curve import COMMAND, CurveStyle, Samples
from workbench.gui.charts.strip_chart import StripChart
from workbench.gui.style import dressed
from workbench.gui.visualization.board_layout import MOST_CHARTS, Board, ChartSpec
from workbench.gui.visualization.derived_signals import SeriesSource
from workbench.gui.visualization.signal_catalog import signal_label
from workbench.gui.visualization.signal_tree import MIME
from workbench.gui.workspace import Workspace

COMMANDS = {"v_x": 0, "v_y": 1, "v_z": 2}

NARROWEST = 340
"""A chart that has a neighbour [pixels]."""


class ChartPane(StripChart):
    """Shows signals of a source by their names.

    Args:
        workspace: colours, units and notices.
        spec: what it shows.
        source: of the signals; those that it has not are waited for.
        parent: the Qt parent; this object is deleted with it.
    """

    spec_changed = pyqtSignal()
    """It shows other signals."""
    used = pyqtSignal()
    """The user has turned to it."""
    removal_wanted = pyqtSignal()
    """It is to go."""
    split_wanted = pyqtSignal()
    """Each of its units is to have a chart of its own."""

    def __init__(
        self,
        workspace: Workspace,
        spec: ChartSpec,
        source: SeriesSource,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(workspace, parent)
        self._notices = workspace.notices
        self._names: list[str] = []
        self._source = source
        self.setAcceptDrops(True)
        self.set_title(spec.title)
        for text, signal in (
            ("Remove last signal\tDel", self._remove_last),
            ("Split into a chart for each signal", self.split_wanted.emit),
            ("Remove this chart\tShift+Del", self.removal_wanted.emit),
        ):
            action = QAction(text, self)
            action.triggered.connect(signal)
            self.extra_actions.append(action)
        self.show_signals(spec.signals, source)

    @property
    def spec(self) -> ChartSpec:
        """What it shows."""
        return ChartSpec(self.title, tuple(self._names))

    def show_signals(self, names: tuple[str, ...], source: SeriesSource) -> None:
        """Show these signals; those that the source has not are kept, and shown once it has."""
        for curve in self.curves:
            self.remove_curve(curve)
        self._source, self._names = source, list(names)
        units = source.units
        for name in names:
            if name in units:
                self._draw_signal(name, units[name])
        missing = [name for name in names if name not in units]
        self.set_hint(
            "Nothing flies yet: open a scenario, or a log"
            if not units
            else f"Not measured here: {', '.join(missing)}"
            if missing
            else "Drag a signal here, or choose one in the list"
        )

    def add_signal(self, name: str) -> None:
        """Show another signal."""
        units = self._source.units
        if name in self._names or name not in units:
            return
        try:
            self._draw_signal(name, units[name])
        except WorkbenchError as error:
            self._notices.warn(str(error))
            return
        self._names.append(name)
        self.redraw()
        self.spec_changed.emit()

    def remove_signal(self, name: str) -> None:
        """Show a signal no more."""
        if name in self._names:
            self.show_signals(tuple(each for each in self._names if each != name), self._source)
            self.spec_changed.emit()

    def dragEnterEvent(self, event: QDragEnterEvent | None) -> None:
        """Take signals."""
        data = event.mimeData() if event is not None else None
        if event is not None and data is not None and data.hasFormat(MIME):
            self.canvas.set_focus_shown(True)
            event.acceptProposedAction()

    def dragLeaveEvent(self, event: QDragLeaveEvent | None) -> None:
        """Show that it would take none."""
        self.canvas.set_focus_shown(self.hasFocus())

    def dropEvent(self, event: QDropEvent | None) -> None:
        """Show what was dropped."""
        data = event.mimeData() if event is not None else None
        if event is None or data is None:
            return
        for name in data.data(MIME).data().decode().splitlines():
            self.add_signal(name)
        self.canvas.set_focus_shown(self.hasFocus())
        self.used.emit()
        event.acceptProposedAction()

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Be the chart in use."""
        super().focusInEvent(event)
        self.used.emit()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Be the chart in use."""
        self.used.emit()
        super().mousePressEvent(event)

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
            shown = {curve.label: curve.colour for curve in self.curves}
            colour = shown.get(answer, COMMAND)

        def series(since: float) -> Samples:
            return self._source.series(name, since)

        self.add_curve(label, unit, series, colour=colour, style=style)

    def _remove_last(self) -> None:
        if self._names:
            self.remove_signal(self._names[-1])


class ChartBoard(QWidget):
    """Charts of one source.

    Args:
        workspace: colours, units and notices.
        source: of the signals.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """Other charts, or other signals in them."""
    used = pyqtSignal(str)
    """Title of the chart that signals are added to."""

    def __init__(
        self, workspace: Workspace, source: SeriesSource, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._source = source
        self._cards: list[tuple[QFrame, ChartPane]] = []
        self._used: ChartPane | None = None
        self._columns = 0
        self._write_times: Callable[[StripChart], None] = StripChart.show_times_ago
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setSpacing(8)

    @property
    def panes(self) -> tuple[ChartPane, ...]:
        """The charts."""
        return tuple(pane for _, pane in self._cards)

    @property
    def board(self) -> Board:
        """What they show."""
        return tuple(pane.spec for pane in self.panes)

    @property
    def chart_in_use(self) -> ChartPane | None:
        """The chart that signals are added to."""
        return self._used or (self.panes[0] if self._cards else None)

    def show_board(self, board: Board, source: SeriesSource) -> None:
        """Show these charts of a source."""
        self._source = source
        for card, _ in self._cards:
            card.hide()
            card.deleteLater()
        self._cards.clear()
        self._used = None
        for spec in board[:MOST_CHARTS]:
            self._add(spec)
        self._arrange()
        if self._cards:
            self._use(self._cards[0][1])

    def show_source(self, source: SeriesSource) -> None:
        """Show the same signals of another source, following it."""
        self._source = source
        for pane in self.panes:
            self._write_times(pane)
            pane.follow()
            pane.show_signals(pane.spec.signals, source)

    def add_chart(self, spec: ChartSpec | None = None) -> None:
        """Add a chart; a sentence tells where there are enough of them."""
        if len(self._cards) >= MOST_CHARTS:
            self._workspace.notices.warn(f"There are {MOST_CHARTS} charts: remove one first.")
            return
        self._add(spec or ChartSpec(f"Chart {len(self._cards) + 1}"))
        self._arrange()
        self._use(self._cards[-1][1])
        self.changed.emit()

    def remove_chart(self, pane: ChartPane) -> None:
        """Remove a chart."""
        for card, each in self._cards:
            if each is pane:
                card.hide()
                card.deleteLater()
        self._cards = [(card, each) for card, each in self._cards if each is not pane]
        if self._used is pane:
            self._used = None
            if self._cards:
                self._use(self._cards[0][1])
        self._arrange()
        self.changed.emit()

    def split_chart(self, pane: ChartPane) -> None:
        """Give each signal of a chart its own, as far as there is room."""
        names = pane.spec.signals
        for name in names[1:]:
            if len(self._cards) >= MOST_CHARTS:
                break
            pane.remove_signal(name)
            self.add_chart(ChartSpec(name, (name,)))

    def add_signal(self, name: str) -> None:
        """Add a signal to the chart in use."""
        if not self._cards:
            self.add_chart()
        pane = self.chart_in_use
        if pane is not None:
            pane.add_signal(name)

    def refresh(self, now: float) -> None:
        """Draw until a time [s]."""
        for _, pane in self._cards:
            pane.refresh(now)

    def write_clock_times(self) -> None:
        """Write times as a log has them."""
        self._write_times = StripChart.show_clock_times

    def write_times_ago(self) -> None:
        """Write how long ago samples are."""
        self._write_times = StripChart.show_times_ago

    def show_window(self, left: float, right: float) -> None:
        """Let all charts stand at a part of time [s]."""
        for pane in self.panes:
            pane.show_window(left, right)

    def set_paused(self, paused: bool) -> None:
        """Let all pictures stand still, or follow."""
        for _, pane in self._cards:
            pane.set_paused(paused)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Take as many columns as there is room for."""
        if self._columns_wanted() != self._columns:
            self._arrange()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Take as many columns as there is room for."""
        if self._columns_wanted() != self._columns:
            self._arrange()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Remove by Del and Shift+Del."""
        pane = self._used
        if event is None or pane is None or event.key() != Qt.Key.Key_Delete:
            super().keyPressEvent(event)
        elif event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self.remove_chart(pane)
        elif pane.spec.signals:
            pane.remove_signal(pane.spec.signals[-1])

    def _add(self, spec: ChartSpec) -> None:
        card = dressed(QFrame(self), "card")
        pane = ChartPane(self._workspace, spec, self._source)
        self._write_times(pane)
        box = QVBoxLayout(card)
        box.setContentsMargins(8, 6, 8, 6)
        box.addWidget(pane)
        pane.used.connect(lambda: self._use(pane))
        pane.spec_changed.connect(self.changed)
        pane.removal_wanted.connect(lambda: self.remove_chart(pane))
        pane.split_wanted.connect(lambda: self.split_chart(pane))
        self._cards.append((card, pane))

    def _use(self, pane: ChartPane) -> None:
        self._used = pane
        self.used.emit(pane.title)

    def _columns_wanted(self) -> int:
        count = len(self._cards)
        # before it is seen its width is not known, and charts in one column would be too high
        room = max(1, self.width() // NARROWEST) if self.isVisible() else 2
        if count <= 1:
            return 1
        return min(room, math.ceil(math.sqrt(count)) if room >= 2 else 1)

    def _arrange(self) -> None:
        for column in range(MOST_CHARTS):
            self._grid.setColumnStretch(column, 0)
            self._grid.setRowStretch(column, 0)
        self._columns = self._columns_wanted()
        for index, (card, _) in enumerate(self._cards):
            row, column = divmod(index, self._columns)
            self._grid.addWidget(card, row, column)
            self._grid.setRowStretch(row, 1)
            self._grid.setColumnStretch(column, 1)
            card.show()
