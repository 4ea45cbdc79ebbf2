"""A chart of the board: signals can be dropped on it, and it can be removed."""

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import (
    QAction,
    QDragEnterEvent,
    QDragLeaveEvent,
    QDropEvent,
    QFocusEvent,
    QMouseEvent,
)
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.curve import COMMAND, CurveStyle, Samples
from workbench.gui.charts.strip_chart import StripChart
from workbench.gui.visualization.board_layout import ChartSpec
from workbench.gui.visualization.series_source import SeriesSource
from workbench.gui.visualization.signal_catalog import signal_label
from workbench.gui.visualization.signal_tree import MIME
from workbench.gui.workspace import Workspace

COMMANDS = {"v_x": 0, "v_y": 1, "v_z": 2}


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
