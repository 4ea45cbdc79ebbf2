"""The screen of charts, clouds, pictures, frames and events, of a flight or of its log."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt6.QtWidgets import (
    QMenu,
    QProgressBar,
    QTabWidget,
    QWidget,
)

from workbench.common.flight import Flight
from workbench.common.plain_text import plain_name
from workbench.gui.errands import FutureCallbacks
from workbench.gui.file_dialogs import log_file_filter, open_file
from workbench.gui.help import set_card_help
from workbench.gui.labels import set_tip, tip_text
from workbench.gui.layout import NO_MARGINS, add_action, button, hbox, label, named, vbox
from workbench.gui.preferences import log_folder
from workbench.gui.screens import Screen
from workbench.gui.visualization.camera_page import CameraPage
from workbench.gui.visualization.charts_page import ChartsPage
from workbench.gui.visualization.cloud_page import CloudPage
from workbench.gui.visualization.column_dialog import ColumnDialog
from workbench.gui.visualization.events_page import EventsPage
from workbench.gui.visualization.frames_page import FramesPage
from workbench.gui.visualization.log_bar import LogBar
from workbench.gui.visualization.log_reader import LogReaderWorker
from workbench.gui.visualization.spec_limits import SpecContents
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView
from workbench.logs.readers.table_head import (
    ColumnChoice,
    TableHead,
    undescribed_table,
    write_mapping,
)

TABLE_FILE_ENDINGS = (".csv", ".csv.gz", ".txt", ".tsv")
"""Endings of the names of tables, whose columns a file or the user describes."""
SPEC_FILE_FILTER = "Specs (*.yaml *.yml)"


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
            set_card_help(page, name)
        self.open_button = button(
            "Ope&n log…",
            lambda: self._ask("Open log", self.open_log),
            help="Show a recorded flight (MCAP) in the same charts",
        )
        help = "Draw a recorded flight, or limits, over what the charts show"
        self.over_button = button("Ove&rlay", help=help)
        over = QMenu(self)
        for title, opens in (
            ("Overlay a log", self.open_overlay),
            ("Limits of a spec", self.open_spec),
        ):
            ask = partial(self._ask, title, opens)
            add_action(over, f"{title}…", lambda _, ask=ask: ask())
        self.over_button.setMenu(over)
        for each in (self.open_button, self.over_button):
            self.charts.line.addWidget(each)
        self.log_bar = LogBar()
        self.log_bar.hide()
        self._reader, self._overlay_reader = LogReaderWorker(self), LogReaderWorker(self)
        self._spec_reader = LogReaderWorker(self)
        self._answers = FutureCallbacks(workspace.notices.warn, self)
        self._described: tuple[TableHead, LogReaderWorker, dict[str, ColumnChoice]] | None = None
        self._reading = QWidget()
        self._path = label(kind="heading")
        self._progress = named(QProgressBar(), "Share of the log that is read, 0 to 100 %")
        self._progress.setTextVisible(False)  # unreadable on the bar
        self.cancel = button("Cancel", self._cancel)
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
        self.log_bar.clock_started.connect(self.charts.board.set_clock_start)
        self.log_bar.card_wanted.connect(self.workspace.log.card_wanted)
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
        self._read_described(path, self._reader)

    def open_layout(self, path: Path) -> None:
        """Show the charts of a layout file; errors become notices."""
        self.tabs.setCurrentWidget(self.charts)
        self.charts.open_layout(path)

    def open_spec(self, path: Path) -> None:
        """Draw the limits of a spec on the curves that they apply to; errors become notices."""
        self._read(path, self._spec_reader)

    def open_overlay(self, path: Path) -> None:
        """Read a log and draw it over the charts; errors become notices."""
        self._read_described(path, self._overlay_reader)

    def close_log(self) -> None:
        """Show the flight again."""
        self.log_bar.stop()
        self.log_bar.hide()
        self._enable_tabs()
        self.charts.board.set_clock_start(0.0)
        self.charts.show_source(None)
        self.workspace.scene.show_log(None)
        self.charts.refresh(self.workspace.signals.now)

    def begin(self, view: LiveView) -> None:
        """Show a new flight."""
        self.charts.begin(view.topics)
        self.cloud.begin(view)
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

    def play_or_pause(self) -> bool:
        """Play or pause the log, if one is shown."""
        if self.shows_log:
            self.log_bar.play.click()
        return self.shows_log

    def release(self) -> None:
        """Pause a log."""
        self.log_bar.stop()

    def close_screen(self) -> None:
        """End the process that reads logs."""
        self.log_bar.stop()
        self._close_readers()

    @property
    def _readers(self) -> tuple[LogReaderWorker, ...]:
        return self._reader, self._overlay_reader, self._spec_reader

    def _close_readers(self) -> None:
        for reader in self._readers:
            reader.close()

    def _ask(self, title: str, opens: Callable[[Path], None]) -> None:
        """Request a log, without blocking."""
        folder = str(log_folder(self.workspace.preferences))
        kinds = SPEC_FILE_FILTER if opens == self.open_spec else log_file_filter()
        open_file(self, title, opens, folder, f"{kinds};;All files (*)")

    def _read_described(self, path: Path, reader: LogReaderWorker) -> None:
        """Read a log; of a table that nothing describes, ask for its columns first."""
        if not path.name.lower().endswith(TABLE_FILE_ENDINGS):
            self._read(path, reader)
            return

        def show(head: TableHead | None) -> None:
            if head is None:
                self._read(path, reader)
            else:
                self.ask_columns(head, reader)

        self._answers.expect(self.workspace.errands.run(partial(undescribed_table, path)), show)

    def ask_columns(
        self,
        head: TableHead,
        reader: LogReaderWorker,
        said: str = "",
        earlier: dict[str, ColumnChoice] | None = None,
    ) -> ColumnDialog:
        """Ask for the columns of a table, and read it then.

        Args:
            head: of the table.
            reader: that reads it.
            said: why an earlier choice could not be read; "" for none.
            earlier: an earlier choice, by column.
        """
        dialog = ColumnDialog(head, said, earlier, self)

        def read(time: str, unit: str, choices: dict[str, ColumnChoice]) -> None:
            def begin(_: object) -> None:
                self._read(head.path, reader)
                self._described = head, reader, choices

            write = partial(write_mapping, head, time, unit, choices)
            self._answers.expect(self.workspace.errands.run(write), begin)

        dialog.given.connect(read)
        dialog.show()
        return dialog

    def _read(self, path: Path, reader: LogReaderWorker) -> None:
        self._described = None
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
        if self._described is not None:  # the mapping was made here: it is asked for again
            head, reader, choices = self._described
            self._described = None
            head.mapping.unlink(missing_ok=True)
            self.ask_columns(head, reader, said, choices)
            return
        self.workspace.notices.warn(said, "Choose another file; the charts are unchanged.")

    def _show_log(self, flight: Flight) -> None:
        self._reading.hide()
        self._described = None
        self.log_bar.show()
        self._enable_tabs()
        self.charts.show_source(flight)
        self.workspace.scene.show_log(flight)
        self.log_bar.show_log(flight)
        self.charts.board.show_window(flight.begin, flight.end)
        self.workspace.log.open(flight.source)

    def _show_overlay(self, flight: Flight) -> None:
        self._reading.hide()
        self._described = None
        self.charts.add_overlay(flight.source.stem, flight)

    def _show_limits(self, spec: SpecContents) -> None:
        self._reading.hide()
        self.charts.show_limits(spec)

    def _show_log_at(self, time: float) -> None:
        if self.shows_log:
            self.charts.refresh(time)
            self.charts.board.point_at(time)
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
        below = (self._reading, self.log_bar)  # what comes and goes moves no button above it
        vbox((self.tabs, 1), *below, of=self, margins=(12, 8, 12, 10), spacing=8)
