"""The page of charts: a list of signals beside a board of charts, and a line of choices above."""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from PyQt6.QtCore import (
    QMimeData,
    QModelIndex,
    QPoint,
    QSettings,
    QSortFilterProxyModel,
    Qt,
    pyqtSignal,
)
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
    QStandardItem,
    QStandardItemModel,
)
from PyQt6.QtWidgets import (
    QComboBox,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QSplitter,
    QTreeView,
    QVBoxLayout,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.curve import COMMAND, CurveStyle, Samples
from workbench.gui.charts.strip_chart import StripChart
from workbench.gui.page import scrolled
from workbench.gui.style import dressed
from workbench.gui.visualization.derived_signals import SeriesSource, WithDerived
from workbench.gui.visualization.signal_catalog import SignalGroup, make_catalog, signal_label
from workbench.gui.workspace import Workspace
from workbench.link.topics import Topic

MIME = "application/x-workbench-signal"
"""Kind of what is dragged: names of signals, a line each."""
NAME = Qt.ItemDataRole.UserRole.value + 1
MOST_CHARTS = 8
COMMANDS = {"v_x": 0, "v_y": 1, "v_z": 2}
NARROWEST = 340
"""A chart that has a neighbour [pixels]."""
KEPT = "visualization/charts"
"""Where the charts are kept between starts."""
OWN = "Own"
WIDE_PAGE = 980
"""From here on there is room for the list of signals beside the charts [pixels]."""


class SignalModel(QStandardItemModel):
    """Topics, and below each its signals with their units."""

    def mimeTypes(self) -> list[str]:
        """Return what is dragged."""
        return [MIME]

    def mimeData(self, indexes: Iterable[QModelIndex]) -> QMimeData:
        """Return the names of signals."""
        names = [str(index.data(NAME)) for index in indexes if index.data(NAME)]
        data = QMimeData()
        data.setData(MIME, "\n".join(dict.fromkeys(names)).encode())
        return data

    def show_groups(self, groups: Sequence[SignalGroup]) -> None:
        """Show these."""
        self.clear()
        self.setHorizontalHeaderLabels(["Signal", "Unit"])
        for group in groups:
            top = QStandardItem(group.title)
            top.setToolTip(group.topic)
            top.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            empty = QStandardItem("")
            empty.setFlags(Qt.ItemFlag.ItemIsEnabled)
            for signal in group.signals:
                own = signal.name.partition(".")[2]
                shown = signal.label if signal.label == own else f"{signal.label} ({own})"
                name, unit = QStandardItem(shown), QStandardItem(signal.unit)
                tip = f"{signal.name} [{signal.unit or '1'}], {signal.label}"
                for item in (name, unit):
                    item.setData(signal.name, NAME)
                    item.setToolTip(f"{tip}: {signal.help}" if signal.help else tip)
                    item.setEditable(False)
                    item.setDropEnabled(False)
                name.setAccessibleText(f"{signal.name}, unit {signal.unit or 'none'}")
                top.appendRow([name, unit])
            self.appendRow([top, empty])


class SignalView(QTreeView):
    """The tree; Enter and double click choose a signal."""

    chosen = pyqtSignal(str)
    """Name of a signal that is to be shown."""

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Choose by Enter."""
        if event is not None and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.choose(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def choose(self, index: QModelIndex) -> None:
        """Choose what is at an index; a topic opens or closes."""
        name = index.data(NAME)
        if name:
            self.chosen.emit(str(name))
        elif index.isValid():
            self.setExpanded(index, not self.isExpanded(index))


class SignalTree(QWidget):
    """Search field and tree.

    Args:
        parent: the Qt parent; this object is deleted with it.
    """

    chosen = pyqtSignal(str)
    """Name of a signal that is to be added to the chart in use."""
    chosen_apart = pyqtSignal(str)
    """Name of a signal that is to have a chart of its own."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._groups: tuple[SignalGroup, ...] = ()
        self._model = SignalModel(self)
        self._proxy = QSortFilterProxyModel(self)
        self._proxy.setSourceModel(self._model)
        self._proxy.setRecursiveFilteringEnabled(True)
        self._proxy.setAutoAcceptChildRows(True)
        self._proxy.setFilterCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        label = QLabel("Find s&ignal")
        self.search = QLineEdit()
        self.search.setPlaceholderText("velocity, thrust, m/s …")
        self.search.setClearButtonEnabled(True)
        self.search.setAccessibleName("Find signal")
        label.setBuddy(self.search)
        self.view = SignalView()
        self.view.setModel(self._proxy)
        self.view.setAccessibleName("Signals: Enter adds one to the chart in use")
        self.view.setDragEnabled(True)
        self.view.setUniformRowHeights(True)
        self.view.setSelectionMode(QTreeView.SelectionMode.ExtendedSelection)
        self.view.setExpandsOnDoubleClick(False)
        self.view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.target = QLabel()
        self.target.setWordWrap(True)
        self.target.setProperty("class", "muted")
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(6)
        for widget in (label, self.search, self.view, self.target):
            box.addWidget(widget, 1 if widget is self.view else 0)
        self.search.textChanged.connect(self._filter)
        self.search.returnPressed.connect(self._choose_first)
        self.view.chosen.connect(self.chosen)
        self.view.doubleClicked.connect(self.view.choose)
        self.view.customContextMenuRequested.connect(self._open_menu)

    def show_groups(self, groups: tuple[SignalGroup, ...]) -> None:
        """Show signals; nothing is done where they are the same."""
        if groups == self._groups:
            return
        self._groups = groups
        self._model.show_groups(groups)
        head = self.view.header()
        if head is not None:
            head.setStretchLastSection(False)
            head.setMinimumSectionSize(40)
            head.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
            head.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self._filter(self.search.text())

    def set_target(self, title: str) -> None:
        """Say to which chart a signal is added."""
        self.target.setText(f"Enter, or a double click, adds to “{title}”. Or drag onto a chart.")

    def names(self) -> list[str]:
        """Return the names that are found."""
        found = []
        for row in range(self._proxy.rowCount()):
            top = self._proxy.index(row, 0)
            for below in range(self._proxy.rowCount(top)):
                found.append(str(self._proxy.index(below, 0, top).data(NAME)))
        return found

    def _filter(self, text: str) -> None:
        """Show what has all words, in whatever order, in its name, its topic or its unit."""
        self._proxy.setFilterRole(Qt.ItemDataRole.ToolTipRole)
        words = "".join(f"(?=.*{_escaped(word)})" for word in text.split())
        self._proxy.setFilterRegularExpression(f"(?i)^{words}" if words else "")
        if text:
            self.view.expandAll()
        else:
            self.view.collapseAll()

    def _choose_first(self) -> None:
        found = self.names()
        if found:
            self.chosen.emit(found[0])

    def _open_menu(self, place: QPoint) -> None:
        index = self.view.currentIndex()
        if not index.data(NAME):
            return
        name = str(index.data(NAME))
        menu = QMenu(self)
        menu.aboutToHide.connect(menu.deleteLater)
        add, apart = (
            menu.addAction("Add to the chart in use"),
            menu.addAction("Show in a new chart"),
        )
        if add is not None and apart is not None:
            add.triggered.connect(lambda: self.chosen.emit(name))
            apart.triggered.connect(lambda: self.chosen_apart.emit(name))
        port = self.view.viewport()
        if port is not None:
            menu.popup(port.mapToGlobal(place))


def _escaped(word: str) -> str:
    return "".join(each if each.isalnum() or each == "_" else f"\\{each}" for each in word)


@dataclass(frozen=True)
class ChartSpec:
    """A chart.

    Attributes:
        title: over it.
        signals: names of what it shows.
    """

    title: str
    signals: tuple[str, ...] = ()


Board = tuple[ChartSpec, ...]


def _names(topic: str, fields: str) -> tuple[str, ...]:
    return tuple(f"{topic}.{field}" for field in fields.split())


_VELOCITY = ChartSpec(
    "Velocity and command",
    _names("velocity_data", "v_x v_y v_z") + _names("command_velocity", "v_x v_y v_z"),
)
_ATTITUDE = ChartSpec("Attitude", _names("position_data", "roll pitch yaw"))
_THRUSTS = ChartSpec("Rotor thrusts", _names("rotors", "thrust.0 thrust.1 thrust.2 thrust.3"))
_VELOCITY_ERROR = ChartSpec("Velocity error", _names("error", "v_x v_y v_z"))


def _estimated(title: str, field: str) -> ChartSpec:
    bounds = _names("bound", f"{field}_low {field}_high")
    truth = "velocity_data" if field.startswith("v_") else "position_data"
    return ChartSpec(title, (f"{truth}.{field}", f"estimate.{field}", *bounds))


PRESETS: dict[str, Board] = {
    "Flight": (_VELOCITY, _ATTITUDE, _THRUSTS, _VELOCITY_ERROR),
    "Rotors": (
        _THRUSTS,
        ChartSpec("Rotor speeds", _names("rotors", "speed.0 speed.1 speed.2 speed.3")),
        ChartSpec("Torque", _names("force_torque_data", "torque_x torque_y torque_z")),
        ChartSpec("Turning rates", _names("velocity_data", "w_x w_y w_z")),
    ),
    "Errors": (
        _VELOCITY_ERROR,
        ChartSpec("Yaw rate error", _names("error", "yaw_rate")),
        _VELOCITY,
        ChartSpec(
            "Yaw rate and command",
            ("velocity_data.w_z", "command_velocity.yaw_rate"),
        ),
    ),
    "Sensors": (
        ChartSpec(
            "Specific force",
            _names("imu", "specific_force.0 specific_force.1 specific_force.2"),
        ),
        ChartSpec(
            "Gyroscope",
            _names("imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2"),
        ),
        ChartSpec("GPS velocity", _names("gps", "velocity.0 velocity.1 velocity.2")),
        ChartSpec("Nearest lidar return", _names("lidar", "nearest")),
    ),
    "Estimate": (
        _estimated("East: truth, estimate, 2 sigma", "x"),
        _estimated("North", "y"),
        _estimated("Height", "z"),
        _estimated("Roll", "roll"),
        _estimated("Pitch", "pitch"),
        _estimated("Yaw", "yaw"),
        _estimated("Velocity east", "v_x"),
        _estimated("Velocity north", "v_y"),
    ),
}
DEFAULT = "Flight"


def board_text(board: Board) -> str:
    """Return a board as text."""
    return json.dumps([{"title": each.title, "signals": list(each.signals)} for each in board])


def read_board(text: str) -> Board | None:
    """Return the board that a text says; None if it says none."""
    try:
        said = json.loads(text)
        board = tuple(
            ChartSpec(str(each["title"]), tuple(map(str, each["signals"]))) for each in said
        )
    except (ValueError, TypeError, KeyError):  # another version wrote it, or an editor
        return None
    return board[:MOST_CHARTS] if board else None


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


class ChartsPage(QWidget):
    """Charts of the flight, or of a log.

    Args:
        workspace: signals, preferences and colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._store: QSettings = workspace.preferences.store
        self._source: SeriesSource = WithDerived(workspace.signals)
        self._live = self._source
        self._topics: tuple[Topic, ...] = ()
        self._tree_chosen: bool | None = None
        self.board = ChartBoard(workspace, self._source)
        self.tree = SignalTree()
        self.presets = QComboBox()
        self.presets.addItems([*PRESETS, OWN])
        self.presets.setAccessibleName("Layout of the charts")
        self.signals_shown = QPushButton("&Signals")
        self.signals_shown.setCheckable(True)
        self.signals_shown.setToolTip("Show the list of all signals")
        self.add = QPushButton("Add &chart")
        self.pause = QPushButton("Pause &all")
        self.pause.setCheckable(True)
        self.pause.setToolTip("Let all pictures stand still; the flight goes on")
        self.line = QHBoxLayout()
        self._lay_out()
        self.tree.chosen.connect(self.board.add_signal)
        self.tree.chosen_apart.connect(lambda name: self.board.add_chart(ChartSpec(name, (name,))))
        self.board.changed.connect(self._keep)
        self.board.used.connect(self.tree.set_target)
        self.presets.activated.connect(lambda _: self._show_preset(self.presets.currentText()))
        self.signals_shown.clicked.connect(self._choose_tree)
        self.add.clicked.connect(lambda: self.board.add_chart())
        self.pause.clicked.connect(self.board.set_paused)
        kept = read_board(str(self._store.value(KEPT, "")))
        self.board.show_board(kept or PRESETS[DEFAULT], self._source)
        self._name_preset()

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the signals of a flight that begins."""
        self._topics = topics
        if self._source is self._live:
            self._show_catalog()
            self.board.show_source(self._source)
            self.pause.setChecked(False)

    def show_source(self, source: SeriesSource | None) -> None:
        """Show the series of a log, None for those of the flight."""
        if source is None:
            self._source = self._live
            self.board.write_times_ago()
        else:
            self._source = WithDerived(source)
            self.board.write_clock_times()
        self.pause.setChecked(False)
        self._show_catalog()
        self.board.show_source(self._source)

    def refresh(self, now: float) -> None:
        """Draw until a time [s]."""
        self.board.refresh(now)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show the list of signals where there is room for it."""
        self._show_tree()

    def _show_catalog(self) -> None:
        self.tree.show_groups(make_catalog(self._source.units, self._topics))

    def _choose_tree(self, shown: bool) -> None:
        self._tree_chosen = shown
        self._show_tree()
        if shown:
            self.tree.search.setFocus()

    def _show_tree(self) -> None:
        shown = self.width() >= WIDE_PAGE if self._tree_chosen is None else self._tree_chosen
        self.tree.setVisible(shown)
        self.signals_shown.setChecked(shown)

    def _show_preset(self, name: str) -> None:
        if name in PRESETS:
            self.board.show_board(PRESETS[name], self._source)
            self.pause.setChecked(False)
            self._store.setValue(KEPT, board_text(self.board.board))

    def _keep(self) -> None:
        self._store.setValue(KEPT, board_text(self.board.board))
        self._name_preset()

    def _name_preset(self) -> None:
        """Show which preset the charts are, if any."""
        board = self.board.board
        name = next((each for each, preset in PRESETS.items() if preset == board), OWN)
        self.presets.setCurrentText(name)

    def _lay_out(self) -> None:
        label = QLabel("La&yout")
        label.setBuddy(self.presets)
        self.line.setSpacing(8)
        for widget in (self.signals_shown, label, self.presets, self.add, self.pause):
            self.line.addWidget(widget)
        self.line.addStretch(1)
        split = QSplitter(Qt.Orientation.Horizontal)
        split.setChildrenCollapsible(False)
        split.addWidget(self.tree)
        split.addWidget(scrolled(self.board))
        split.setStretchFactor(1, 1)
        split.setSizes([250, 900])
        self.tree.setMinimumWidth(200)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 8, 0, 0)
        box.setSpacing(8)
        box.addLayout(self.line)
        box.addWidget(split, 1)
