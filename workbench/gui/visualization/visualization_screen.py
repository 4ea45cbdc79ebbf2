"""The screen of charts, clouds, pictures, frames and events, of a flight or of its log."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from PyQt6.QtCore import QObject, QSignalBlocker, Qt, QTimer, pyqtSignal
from PyQt6.QtGui import QShowEvent
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QFrame,
    QHeaderView,
    QLineEdit,
    QMenu,
    QProgressBar,
    QSlider,
    QTableWidget,
    QTableWidgetItem,
    QTabWidget,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.gui.charts.ticks import number_text
from workbench.gui.file_dialogs import LOG_FILES, open_file
from workbench.gui.help import explain
from workbench.gui.labels import Label, set_tip, tip_text
from workbench.gui.layout import NO_MARGINS, buddy, button, choice, hbox, label, named, vbox
from workbench.gui.poses import (
    frame_pairs,
    poses_in_parent,
    poses_in_world,
)
from workbench.gui.preferences import log_folder
from workbench.gui.screens import Screen
from workbench.gui.signals import Event, events_in
from workbench.gui.style import set_class
from workbench.gui.units import unit_for
from workbench.gui.visualization.charts_page import ChartsPage
from workbench.gui.visualization.log_messages import LogContents, SpecContents
from workbench.gui.visualization.sensor_pages import CameraPage, CloudPage
from workbench.gui.workspace import Workspace
from workbench.ipc.worker_process import WorkerProcess
from workbench.link.backplane import Published
from workbench.link.topics import PREFIX, Topic
from workbench.live.view import LiveView

MOST = 2000
"""Limit of kept events; beyond it the oldest are dropped."""
EVERY = 0.1
"""Digits that change faster are illegible [s]."""
HEADS = ("Frame", "x", "y", "z", "Roll", "Pitch", "Yaw", "x in W", "y in W", "z in W")


class FramesPage(QWidget):
    """The tree of frames.

    Args:
        workspace: signals and units.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace = workspace
        self._pairs: tuple[tuple[str, str], ...] = ()
        self._items: dict[str, QTreeWidgetItem] = {}
        self._shown = -1.0
        self.search = named(QLineEdit(), "Find frame")
        self.search.setClearButtonEnabled(True)
        self.search.setPlaceholderText("part of a name")
        self.tree = named(QTreeWidget(), "Frames: pose in the parent, and place in W")
        self.tree.setColumnCount(len(HEADS))
        self.tree.setUniformRowHeights(True)
        head = self.tree.header()
        if head is not None:
            head.setStretchLastSection(False)
            head.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
            head.setSectionResizeMode(0, QHeaderView.ResizeMode.ResizeToContents)
            head.setDefaultAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.hint = Label("No flight has sent its frames yet.")
        name = buddy("Find fra&me", self.search, kind="")
        parts = (name, self.search, self.hint, (self.tree, 1))
        vbox(*parts, of=self, margins=(0, 8, 0, 0), spacing=6)
        self.search.textChanged.connect(self._filter)
        self._name_columns()
        workspace.preferences.changed.connect(self._on_preference)

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the frames of a new flight."""
        topic = next((each for each in topics if each.name == f"{PREFIX}frames"), None)
        self._pairs = frame_pairs(topic.about) if topic is not None else ()
        self._items.clear()
        self.tree.clear()
        self._shown = -1.0
        root = self.tree.invisibleRootItem()
        for parent, child in self._pairs:
            if parent not in self._items and root is not None:
                self._items[parent] = QTreeWidgetItem(root, [plain_name(parent)])
            self._items[child] = QTreeWidgetItem(self._items[parent], [plain_name(child)])
        for item in self._items.values():
            for column in range(1, len(HEADS)):
                side = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                item.setTextAlignment(column, side)
        self.tree.expandAll()
        self.hint.setVisible(not self._pairs)
        self._name_columns()
        self._filter(self.search.text())

    def refresh(self, now: float) -> None:
        """Show the newest poses."""
        if self._shown <= now < self._shown + EVERY:
            return
        numbers = self._workspace.signals.newest("frames").get("poses")
        if not isinstance(numbers, tuple):
            return
        self._shown = now
        poses = poses_in_parent(numbers)
        world = poses_in_world(self._pairs, poses)
        angle = unit_for("rad", self._workspace.preferences)
        for (_, child), pose in zip(self._pairs, poses, strict=False):
            angles = (angle.shown(each) for each in pose.roll_pitch_yaw())
            texts = [
                *(number_text(each, 3) for each in pose.p),
                *(number_text(each, 2) for each in angles),
                *(number_text(each, 3) for each in world[child].p),
            ]
            self._write(self._items[child], texts)

    def _write(self, item: QTreeWidgetItem, texts: list[str]) -> None:
        for column, text in enumerate(texts, 1):
            if item.text(column) != text:
                item.setText(column, text)

    def _on_preference(self, name: str) -> None:
        if name == "angle_unit":
            self._shown = -1.0
            self._name_columns()

    def _name_columns(self) -> None:
        angle = unit_for("rad", self._workspace.preferences).symbol
        self.tree.setHeaderLabels(
            [
                HEADS[0],
                *(f"{name} m" for name in HEADS[1:4]),
                *(f"{name} {angle}" for name in HEADS[4:7]),
                *(f"{name} m" for name in HEADS[7:]),
            ]
        )
        head = self.tree.headerItem()
        if head is not None:
            head.setTextAlignment(0, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
            for column, name in enumerate(HEADS[1:7], 1):
                head.setToolTip(column, tip_text(f"{name} in the parent frame"))

    def _filter(self, text: str) -> None:
        """Hide frames without the text in their own name or in one below them."""
        wanted = text.lower()
        for item in self._items.values():
            item.setHidden(not _has(item, wanted))


def _has(item: QTreeWidgetItem, wanted: str) -> bool:
    below = (item.child(index) for index in range(item.childCount()))
    return wanted in item.text(0).lower() or any(
        _has(each, wanted) for each in below if each is not None
    )


SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0)
STEP = 0.1
"""Time of a single step [s]."""
PERIOD = 16
"""Period between pictures while it plays [ms]."""
LONGEST_EVENT = 300
"""Largest number of characters of an event in the table; its tool tip has the rest."""
ENDING = 1.0
"""Time for a log reader to end what it has started, before it is killed [s]."""
SPEC_FILES = "Specs (*.yaml *.yml)"
PARTS = 100
"""Number of the slider's steps per second."""


class LogClock:
    """A time within a log that plays, is paused, or is moved.

    Args:
        begin: time of the log's first sample [s].
        end: time of its last sample [s].

    Attributes:
        begin: time of the log's first sample [s].
        end: time of its last sample [s].
        time: shown time [s].
        speed: seconds of the log per second.
        plays: whether it plays.
        loops: whether it restarts at the end.
    """

    def __init__(self, begin: float, end: float) -> None:
        self.begin, self.end = begin, max(begin, end)
        self.time = self.end
        self.speed = 1.0
        self.plays = False
        self.loops = False

    def play(self) -> None:
        """Play; from the start if it is at the end."""
        if self.time >= self.end:
            self.time = self.begin
        self.plays = True

    def pause(self) -> None:
        """Pause."""
        self.plays = False

    def go_to(self, time: float) -> None:
        """Go to a time [s]."""
        self.time = min(max(time, self.begin), self.end)

    def step(self, steps: int) -> None:
        """Pause, and move by some steps."""
        self.pause()
        self.go_to(self.time + STEP * steps)

    def advance(self, passed: float) -> None:
        """Advance by a wall time [s]."""
        if not self.plays:
            return
        self.time += self.speed * passed
        if self.time >= self.end:
            duration = self.end - self.begin
            if self.loops and duration > 0.0:
                self.time = self.begin + (self.time - self.begin) % duration
            else:
                self.time = self.end
                self.plays = False


class LogBar(QFrame):
    """Time bar of a log."""

    moved = pyqtSignal(float)
    """The time to show [s]."""
    whole_wanted = pyqtSignal(float, float)
    """The whole log should be visible, between two times [s]."""
    live_wanted = pyqtSignal()
    """The log should be closed."""
    what_if_wanted = pyqtSignal()
    """The log should be flown again with other gains."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = LogClock(0.0, 0.0)
        self._last = 0.0
        self._timer = QTimer(self)
        self._timer.setInterval(PERIOD)
        self._timer.timeout.connect(self._tick)
        set_class(self, "card")
        explain(self, "Log")
        self.name = label(kind="heading")
        self.remark = label(kind="warning", wraps=True)
        self.back = button("Back to &live", self.live_wanted.emit)
        self.earlier = named(
            button("− 0.1 s", lambda: self._step(-1)), "A tenth of a second earlier"
        )
        self.later = named(button("+ 0.1 s", lambda: self._step(1)), "A tenth of a second later")
        self.whole = button(
            "&Whole log", lambda: self.whole_wanted.emit(self.clock.begin, self.clock.end)
        )
        help = "Fly it again with other gains, on the Tuning screen"
        self.again = button("What &if…", self.what_if_wanted.emit, help=help)
        self.play, self.loop = button("&Play"), button("L&oop")
        for each in (self.play, self.loop):
            each.setCheckable(True)
        speeds = (f"{speed:g} ×" for speed in SPEEDS)
        self.speed = choice("Seconds of the log in a second", speeds)
        self.speed.setCurrentIndex(SPEEDS.index(1.0))
        self.slider = named(QSlider(Qt.Orientation.Horizontal), "Time of the log in s")
        self.time = Label()
        self._lay_out()
        self._connect()

    def show_log(self, contents: LogContents) -> None:
        """Show a new log, at its end."""
        self.clock = LogClock(contents.begin, contents.end)
        self.clock.speed = SPEEDS[self.speed.currentIndex()]
        self.clock.loops = self.loop.isChecked()
        self.name.setText(f"LOG  {plain_name(contents.path.name)}")
        set_tip(self.name, f"{contents.path}, vehicle {contents.vehicle}")
        self.remark.setText(contents.remark)
        self.remark.setVisible(bool(contents.remark))
        with QSignalBlocker(self.slider):  # setting a range without its value changes the value
            self.slider.setRange(round(contents.begin * PARTS), round(contents.end * PARTS))
        self.slider.setAccessibleDescription(f"{contents.begin:.2f} to {contents.end:.2f} s")
        self._show()

    def stop(self) -> None:
        """Stop playing."""
        self.clock.pause()
        self._timer.stop()
        self._show()

    def _toggle_play(self, plays: bool) -> None:
        if plays:
            self.clock.play()
            self._last = perf_counter()
            self._timer.start()
        else:
            self.stop()
        self._show()

    def _tick(self) -> None:
        now = perf_counter()
        self.clock.advance(now - self._last)
        self._last = now
        if not self.clock.plays:
            self._timer.stop()
        self._show()

    def _step(self, steps: int) -> None:
        self.clock.step(steps)
        self._timer.stop()
        self._show()

    def _scrub(self, place: int) -> None:
        self.clock.go_to(place / PARTS)
        self._show()

    def _set_speed(self, index: int) -> None:
        self.clock.speed = SPEEDS[index]

    def _set_loop(self, loops: bool) -> None:
        self.clock.loops = loops

    def _show(self) -> None:
        """Show the clock, without a signal from the slider."""
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(self.clock.time * PARTS))
        self.play.setChecked(self.clock.plays)
        self.play.setText("&Pause" if self.clock.plays else "&Play")
        now, end = number_text(self.clock.time, 2), number_text(self.clock.end, 2)
        begin = number_text(self.clock.begin, 2)
        self.time.setText(f"{now} of {begin} to {end} s")
        self.moved.emit(self.clock.time)

    def _lay_out(self) -> None:
        said = label("This is a log, not a live flight.", "muted")
        head = hbox(self.name, said, 1, self.again, self.whole, self.back)
        row = hbox(
            self.play,
            self.earlier,
            self.later,
            (self.slider, 1),
            self.time,
            buddy("Sp&eed", self.speed, kind=""),
            self.speed,
            self.loop,
            spacing=8,
        )
        vbox(head, self.remark, row, of=self, margins=(10, 6, 10, 6), spacing=4)
        self.slider.setSingleStep(PARTS // 10)
        self.slider.setPageStep(PARTS)
        self.time.setMinimumWidth(
            self.fontMetrics().horizontalAdvance("0000.00 of 0000.00 to 0000.00 s")
        )

    def _connect(self) -> None:
        self.play.clicked.connect(self._toggle_play)
        self.slider.valueChanged.connect(self._scrub)
        self.speed.currentIndexChanged.connect(self._set_speed)
        self.loop.clicked.connect(self._set_loop)


class EventsPage(QWidget):
    """Table of events, the newest at the bottom.

    Args:
        workspace: colours.

    Attributes:
        events: the shown events.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._look = workspace.look
        self.events: deque[Event] = deque(maxlen=MOST)
        self._at_end = True
        self.hint = Label(
            "Nothing has happened yet: take-off, landing, warnings and changed parameters will "
            "appear here."
        )
        self.hint.setWordWrap(True)
        self.table = QTableWidget(0, 3)
        self.table.setAccessibleName("Events with their times in s")
        self.table.setHorizontalHeaderLabels(["Time s", "Kind", "What happened"])
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setTabKeyNavigation(False)
        self.table.setShowGrid(False)
        self.table.setWordWrap(False)
        upright, head = self.table.verticalHeader(), self.table.horizontalHeader()
        if upright is not None and head is not None:
            upright.hide()
            head.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
            head.setSectionResizeMode(2, QHeaderView.ResizeMode.Stretch)
            head.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        vbox(self.hint, (self.table, 1), of=self, margins=(0, 8, 0, 0))

    def begin(self) -> None:
        """Clear all: a flight begins."""
        self.events.clear()
        self.table.setRowCount(0)
        self.hint.show()

    def add(self, published: Sequence[Published]) -> None:
        """Show the events in published data."""
        found = events_in(published)
        if not found:
            return
        self.events += found
        self.hint.hide()
        bar = self.table.verticalScrollBar()
        if self.isVisible():
            self._at_end = bar is not None and bar.value() >= bar.maximum()
        for event in found:
            self._append(event)
        self._follow()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Scroll to the newest: on a hidden page that would lay out all rows."""
        super().showEvent(event)
        self._follow()

    def _follow(self) -> None:
        if self._at_end and self.isVisible():
            self.table.scrollToBottom()

    def _append(self, event: Event) -> None:
        if self.table.rowCount() >= MOST:
            self.table.removeRow(0)
        row = self.table.rowCount()
        self.table.insertRow(row)
        time, *words = event
        for column, text in enumerate((number_text(time, 2), *words)):
            item = QTableWidgetItem(plain_name(text, LONGEST_EVENT))
            set_tip(item, text)
            if column == 0:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.table.setItem(row, column, item)


class LogReader(QObject):
    """Reads one log at a time; a newer one ends the reading of an older one."""

    progressed = pyqtSignal(float)
    """Share of the log that is read, 0 .. 1."""
    ready = pyqtSignal(object)
    """The `LogContents`."""
    refused = pyqtSignal(str)
    """Why it cannot be read, as a sentence."""
    _heard = pyqtSignal(int, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._number = 0
        self._process: WorkerProcess | None = None
        queued = Qt.ConnectionType.QueuedConnection  # called in a thread of the process object
        self._heard.connect(self._deliver, queued)  # pyrefly: ignore[bad-argument-count]

    @property
    def is_reading(self) -> bool:
        """Whether a log is being read."""
        return self._process is not None

    def read(self, path: Path) -> None:
        """Start reading a log, without blocking."""
        self.close()
        heard = partial(self._heard.emit, self._number)
        module = "workbench.gui.visualization.log_worker"
        try:
            process = WorkerProcess(module, "log reader", heard, lambda why: f"{path}: {why}")
        except WorkbenchError as error:
            self.refused.emit(str(error))
            return
        self._process = process
        process.ask(lambda: path).add_done_callback(heard)

    def close(self) -> None:
        """Stop reading and release everything."""
        process, self._process = self._process, None
        self._number += 1
        if process is not None:
            process.close(ENDING, last="no more")

    def _deliver(self, number: int, message: "float | Future[Any]") -> None:
        if number != self._number:
            return  # of a log that is no longer requested
        if isinstance(message, float):
            self.progressed.emit(message)
            return
        self.close()
        if error := message.exception():
            self.refused.emit(str(error))
        else:
            self.ready.emit(message.result())


class VisualizationScreen(Screen):
    """Charts of any signals, lidar, camera, frames and events; and logs.

    Args:
        workspace: services that all screens share.

    Attributes:
        charts: page of charts.
        cloud: page of the lidar.
        camera: page of the depth camera.
        frames: page of frames.
        events: page of events.
        log_bar: visible while a log is shown.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.setAccessibleName("Kinds of pictures")
        self.charts = ChartsPage(workspace)
        self.cloud = CloudPage(workspace)
        self.camera = CameraPage(workspace)
        self.frames = FramesPage(workspace)
        self.events = EventsPage(workspace)
        for page, name in (
            (self.charts, "Charts"),
            (self.cloud, "Lidar"),
            (self.camera, "Camera"),
            (self.frames, "Frames"),
            (self.events, "Events"),
        ):
            self.tabs.addTab(page, name)
            explain(page, name)
        self.open_button = button(
            "Open lo&g…",
            lambda: self._ask("Open log", self.open_log),
            help="Show a recorded flight (MCAP) in the same charts",
        )
        help = "Draw a recorded flight, or limits, over what the charts show"
        self.over_button = button("O&verlay", help=help)
        over = QMenu(self)
        for title, opens in (
            ("Overlay a log", self.open_overlay),
            ("Limits of a spec", self.open_spec),
        ):
            action = over.addAction(f"{title}…")
            if action is not None:
                action.triggered.connect(partial(self._ask, title, opens))
        self.over_button.setMenu(over)
        for each in (self.open_button, self.over_button):
            self.charts.line.addWidget(each)
        self.log_bar = LogBar()
        self.log_bar.hide()
        self._reader, self._overlay_reader = LogReader(self), LogReader(self)
        self._spec_reader = LogReader(self)
        self._reading = QWidget()
        self._path = label(kind="heading")
        self._progress = named(QProgressBar(), "Share of the log that is read, 0 to 100 %")
        self.cancel = button("&Cancel", self._cancel)
        self._lay_out()
        self.tabs.currentChanged.connect(lambda _: self.show_view(workspace.flight.view))
        for reader, show in (
            (self._reader, self._show_log),
            (self._overlay_reader, self._show_overlay),
            (self._spec_reader, self._show_limits),
        ):
            reader.progressed.connect(lambda share: self._progress.setValue(round(100 * share)))
            reader.ready.connect(show)
            reader.refused.connect(self._refuse)
        self.log_bar.moved.connect(self._show_log_at)
        self.log_bar.whole_wanted.connect(self.charts.board.show_window)
        self.log_bar.what_if_wanted.connect(self.workspace.log.what_if_wanted)
        self.log_bar.live_wanted.connect(self.close_log)
        workspace.flight.streamed.connect(self.events.add)
        if workspace.flight.view.snapshot is not None:
            self.begin(workspace.flight.view)

    @property
    def shows_log(self) -> bool:
        """Whether the charts show a log instead of the flight."""
        return not self.log_bar.isHidden()

    @property
    def is_reading(self) -> bool:
        """Whether a log is being read."""
        return any(reader.is_reading for reader in self._readers)

    def open_log(self, path: Path) -> None:
        """Read a log and show it; errors become notices."""
        self._read(path, self._reader)

    def open_layout(self, path: Path) -> None:
        """Show the charts of a layout file; errors become notices."""
        self.tabs.setCurrentWidget(self.charts)
        self.charts.open_layout(path)

    def open_spec(self, path: Path) -> None:
        """Draw the limits of a spec on the curves that they apply to; errors become notices."""
        self._read(path, self._spec_reader)

    def open_overlay(self, path: Path) -> None:
        """Read a log and draw it over the charts; errors become notices."""
        self._read(path, self._overlay_reader)

    def close_log(self) -> None:
        """Show the flight again."""
        self.log_bar.stop()
        self.log_bar.hide()
        self._enable_tabs()
        self.charts.show_source(None)
        self.workspace.scene.show_log(None)
        self.charts.refresh(self.workspace.signals.now)

    def begin(self, view: LiveView) -> None:
        """Show a new flight."""
        self.charts.begin(view.topics)
        self.cloud.begin(view.topics)
        self.camera.begin(view)
        self.frames.begin(view.topics)
        self.events.begin()

    def show_view(self, view: LiveView) -> None:
        """Show the view on the visible page."""
        now = self.workspace.signals.now
        page = self.tabs.currentWidget()
        if page is self.charts:
            if not self.shows_log:
                self.charts.refresh(now)
        elif page is self.cloud:
            self.cloud.refresh(now)
        elif page is self.camera:
            self.camera.refresh(view)
        elif page is self.frames:
            self.frames.refresh(now)

    def release(self) -> None:
        """Pause a log."""
        self.log_bar.stop()

    def close_screen(self) -> None:
        """End the process that reads logs."""
        self.log_bar.stop()
        self._close_readers()

    @property
    def _readers(self) -> tuple[LogReader, ...]:
        return self._reader, self._overlay_reader, self._spec_reader

    def _close_readers(self) -> None:
        for reader in self._readers:
            reader.close()

    def _ask(self, title: str, opens: Callable[[Path], None]) -> None:
        """Request a log, without blocking."""
        folder = str(log_folder(self.workspace.preferences))
        kinds = SPEC_FILES if opens == self.open_spec else LOG_FILES
        open_file(self, title, opens, folder, f"{kinds};;All files (*)")

    def _read(self, path: Path, reader: LogReader) -> None:
        self.tabs.setCurrentWidget(self.charts)
        self._path.setText(f"Reading {plain_name(path.name)}")
        set_tip(self._path, str(path))
        self._progress.setValue(0)
        self._reading.show()
        reader.read(path)

    def _cancel(self) -> None:
        self._close_readers()
        self._reading.hide()

    def _refuse(self, said: str) -> None:
        self._reading.hide()
        self.workspace.notices.warn(said, "Choose another file; the charts are unchanged.")

    def _show_log(self, contents: LogContents) -> None:
        self._reading.hide()
        self.log_bar.show()
        self._enable_tabs()
        self.charts.show_source(contents)
        self.workspace.scene.show_log(contents)
        self.log_bar.show_log(contents)
        self.workspace.log.open(contents.path)

    def _show_overlay(self, contents: LogContents) -> None:
        self._reading.hide()
        self.charts.add_overlay(contents.path.stem, contents)

    def _show_limits(self, spec: SpecContents) -> None:
        self._reading.hide()
        self.charts.show_limits(spec)

    def _show_log_at(self, time: float) -> None:
        if self.shows_log:
            self.charts.refresh(time)
            self.workspace.scene.replay(time)

    def _enable_tabs(self) -> None:
        """Disable the pages of the flight while a log is shown."""
        for index in range(1, self.tabs.count()):
            self.tabs.setTabEnabled(index, not self.shows_log)
            tip = "Only in a live flight: go back to live first" if self.shows_log else ""
            self.tabs.setTabToolTip(index, tip_text(tip))

    def _lay_out(self) -> None:
        hbox(self._path, (self._progress, 1), self.cancel, of=self._reading, margins=NO_MARGINS)
        self._reading.hide()
        vbox(
            self._reading, (self.tabs, 1), self.log_bar, of=self, margins=(12, 8, 12, 10), spacing=8
        )
