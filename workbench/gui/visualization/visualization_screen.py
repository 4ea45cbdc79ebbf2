"""The screen of charts, clouds, pictures, frames and events, of a flight or of its log."""

from pathlib import Path

from PyQt6.QtWidgets import (
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.file_dialogs import show_file_dialog
from workbench.gui.preferences import log_folder
from workbench.gui.screen import Screen
from workbench.gui.style import set_class
from workbench.gui.visualization.camera_page import CameraPage
from workbench.gui.visualization.charts_page import ChartsPage
from workbench.gui.visualization.cloud_page import CloudPage
from workbench.gui.visualization.events_page import EventsPage
from workbench.gui.visualization.frames_page import FramesPage
from workbench.gui.visualization.log_bar import LogBar
from workbench.gui.visualization.log_messages import LogContents
from workbench.gui.visualization.log_reader import LogReader, LogSource
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class VisualizationScreen(Screen):
    """Charts of any signals, lidar, camera, frames and events; and logs.

    Args:
        workspace: what all screens share.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        charts: page of charts.
        cloud: page of the lidar.
        camera: page of the depth camera.
        frames: page of frames.
        events: page of events.
        log_bar: seen while a log is shown.
    """

    title = "Visualization"
    icon = "visualization"

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
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
        self.open_button = QPushButton("Open lo&g…")
        self.open_button.setToolTip("Show a recorded flight (MCAP) in the same charts")
        self.charts.line.addWidget(self.open_button)
        self.log_bar = LogBar()
        self.log_bar.hide()
        self._reader = LogReader(self)
        self._reading = QWidget()
        self._path = QLabel()
        self._progress = QProgressBar()
        self.cancel = QPushButton("&Cancel")
        self._lay_out()
        self.open_button.clicked.connect(self._ask)
        self.cancel.clicked.connect(self._cancel)
        self.tabs.currentChanged.connect(lambda _: self.show_view(workspace.flight.view))
        self._reader.progressed.connect(lambda share: self._progress.setValue(round(100 * share)))
        self._reader.ready.connect(self._show_log)
        self._reader.refused.connect(self._refuse)
        self.log_bar.moved.connect(self._show_log_at)
        self.log_bar.whole_wanted.connect(self.charts.board.show_window)
        self.log_bar.live_wanted.connect(self.close_log)
        workspace.flight.streamed.connect(self.events.add)
        if workspace.flight.view.snapshot is not None:
            self.begin(workspace.flight.view)

    @property
    def shows_log(self) -> bool:
        """Whether the charts are of a log, and not of the flight."""
        return not self.log_bar.isHidden()

    @property
    def is_reading(self) -> bool:
        """Whether a log is being read."""
        return self._reader.is_reading

    def open_log(self, path: Path) -> None:
        """Read a log and show it; what is wrong with it is told."""
        self.tabs.setCurrentWidget(self.charts)
        self._path.setText(f"Reading {path.name}")
        self._path.setToolTip(str(path))
        self._progress.setValue(0)
        self._reading.show()
        self._reader.read(path)

    def close_log(self) -> None:
        """Show the flight again."""
        self.log_bar.stop()
        self.log_bar.hide()
        self._enable_tabs()
        self.charts.show_source(None)
        self.charts.refresh(self.workspace.signals.now)

    def begin(self, view: LiveView) -> None:
        """Show a flight that has begun."""
        self.charts.begin(view.topics)
        self.cloud.begin(view.topics)
        self.camera.begin(view)
        self.frames.begin(view.topics)
        self.events.begin(view.topics)

    def show_view(self, view: LiveView) -> None:
        """Show the present on the page that is seen."""
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
        """Let a log stand."""
        self.log_bar.stop()

    def close_screen(self) -> None:
        """End what reads logs."""
        self.log_bar.stop()
        self._reader.close()

    def _ask(self) -> None:
        """Ask for a log; nothing waits for the answer."""
        folder = str(log_folder(self.workspace.preferences))
        dialog = QFileDialog(self, "Open log", folder, "Logs (*.mcap);;All files (*)")
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        show_file_dialog(dialog, lambda name: self.open_log(Path(name)))

    def _cancel(self) -> None:
        self._reader.close()
        self._reading.hide()

    def _refuse(self, said: str) -> None:
        self._reading.hide()
        self.workspace.notices.warn(said, "Choose another file; the charts are as they were.")

    def _show_log(self, contents: LogContents) -> None:
        self._reading.hide()
        self.log_bar.show()
        self._enable_tabs()
        self.charts.show_source(LogSource(contents))
        self.log_bar.show_log(contents)

    def _show_log_at(self, time: float) -> None:
        if self.shows_log:
            self.charts.refresh(time)

    def _enable_tabs(self) -> None:
        """Let nobody take the flight's pictures for those of the log."""
        for index in range(1, self.tabs.count()):
            self.tabs.setTabEnabled(index, not self.shows_log)
            tip = "Of the live flight: go back to live first" if self.shows_log else ""
            self.tabs.setTabToolTip(index, tip)

    def _lay_out(self) -> None:
        row = QHBoxLayout(self._reading)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self._path)
        row.addWidget(self._progress, 1)
        row.addWidget(self.cancel)
        set_class(self._path, "heading")
        self._progress.setAccessibleName("Share of the log that is read, 0 to 100 %")
        self._reading.hide()
        box = QVBoxLayout(self)
        box.setContentsMargins(12, 8, 12, 10)
        box.setSpacing(8)
        box.addWidget(self._reading)
        box.addWidget(self.tabs, 1)
        box.addWidget(self.log_bar)
