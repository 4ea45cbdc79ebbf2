"""The recorder of logs: starts and ends them, and reports how they ended."""

import re
import time
from datetime import datetime
from pathlib import Path

from PyQt6.QtCore import QObject, QTimer, pyqtSignal

from workbench.gui.flight_model import FlightModel
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences, log_folder
from workbench.live.messages import NetworkView
from workbench.live.orders import KeepLog, NetworkOrder
from workbench.live.view import LiveView

LOG_SIZE_POLL_MS = 500
"""Period between checks of the file's size [ms]."""
LOG_END_TIMEOUT_S = 2.0
"""Time limit for ending a log when the window closes [s]."""


class LogRecorder(QObject):
    """Starts and ends the log of a flight; reports a log that ends by itself.

    Args:
        flight: the recorded flight.
        preferences: source of the folder for logs.
        notices: takes the report of its end.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        path: path of the log, "" without one.
    """

    changed = pyqtSignal()
    """Recording has started or ended, or the file has grown."""
    recorded = pyqtSignal(str)
    """Path of a completed log."""

    def __init__(
        self,
        flight: FlightModel,
        preferences: Preferences,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flight, self._preferences, self._notices = flight, preferences, notices
        self.path = ""
        self._since = 0.0
        self._timer = QTimer(self)
        self._timer.setInterval(LOG_SIZE_POLL_MS)
        self._timer.timeout.connect(self.changed)
        flight.viewed.connect(self._follow)

    @property
    def is_recording(self) -> bool:
        """Whether a log is written."""
        return bool(self.path)

    def said(self) -> str:
        """Return duration and size of the log as text, "" without a log."""
        if not self.path:
            return ""
        seconds = int(time.monotonic() - self._since)
        try:
            size = Path(self.path).stat().st_size
        except OSError:  # not created yet, or deleted
            size = 0
        return f"{seconds // 60}:{seconds % 60:02d}  {size_text(size)}"

    def toggle(self) -> None:
        """Start or end the log."""
        if self.path:
            # the flight reports its end, as for a log that ends by itself
            self._flight.do(NetworkOrder.STOP_LOG, refused=lambda said: None)
            return
        try:
            folder = log_folder(self._preferences)
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self._refuse(f"the folder for logs cannot be made: {error}")
            return
        vehicle = self._flight.view.vehicle
        path = folder / log_name(vehicle.name if vehicle else "flight", datetime.now())
        self._flight.do(KeepLog(str(path.absolute())), refused=self._refuse)

    def end_with_app(self) -> None:
        """End a log properly, quickly enough that the user does not notice."""
        live = self._flight.live
        if self.is_recording and live is not None:
            until = time.monotonic() + LOG_END_TIMEOUT_S
            ended = live.stop_log()
            while not ended.done() and time.monotonic() < until:
                time.sleep(0.01)

    def _follow(self, view: LiveView) -> None:
        """Follow the flight's reports about its log."""
        path = view.network.log
        if path == self.path:
            return
        before, self.path = self.path, path
        if path:
            self._since = time.monotonic()
            self._timer.start()
        else:
            self._timer.stop()
        if before:
            self._tell_end(before, view.network)
        self.changed.emit()

    def _tell_end(self, ended: str, network: NetworkView) -> None:
        """Report once how a log has ended: complete, or gone."""
        if not network.log_said and Path(ended).is_file():
            self._notices.inform(f"recorded {ended}")
            self.recorded.emit(ended)
            return
        said = network.log_said or f"{ended}: the file was moved or deleted"
        remedy = "Choose another folder in Settings, then record again."
        self._notices.fail(f"recording has ended: {said}", remedy)

    def _refuse(self, said: str) -> None:
        self._notices.warn(said, "Choose another folder for logs in Settings.")
        self.changed.emit()


def log_name(vehicle: str, now: datetime) -> str:
    """Return a name from vehicle and date that is valid in file systems."""
    return f"{re.sub(r'[^A-Za-z0-9_-]+', '_', vehicle) or 'flight'}-{now:%Y%m%d-%H%M%S}.mcap"


def size_text(size: int) -> str:
    """Return a size [bytes] as text."""
    if size < 1_000_000:
        return f"{size / 1000:.0f} kB"
    return f"{size / 1e6:.1f} MB" if size < 1e9 else f"{size / 1e9:.2f} GB"
