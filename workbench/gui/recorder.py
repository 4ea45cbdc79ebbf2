"""Writes what happens to files: logs of flights, and pictures of the window."""

import re
import time
from datetime import datetime
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QObject, QTimer, pyqtSignal
from PyQt6.QtGui import QImage
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import Answers
from workbench.gui.flight_model import FlightModel
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences, log_folder
from workbench.gui.workspace import Workspace
from workbench.live.flight import LiveFlight
from workbench.live.messages import NetworkView
from workbench.live.view import LiveView

LOOK = 500
"""Between two looks at the file's size [ms]."""


class Camera:
    """Writes pictures of a window into the folder for logs.

    Args:
        window: to be seen.
        workspace: where the folder is chosen, and the path is told.
    """

    def __init__(self, window: QWidget, workspace: Workspace) -> None:
        self._window, self._workspace = window, workspace
        self._answers = Answers(self._refuse, window)

    def take(self) -> None:
        """Take a picture now, and write it in the background: packing it takes a while."""
        image = self._window.grab().toImage()
        name = f"workbench-{datetime.now():%Y%m%d-%H%M%S-%f}"[:-3] + ".png"
        path = log_folder(self._workspace.preferences) / name
        self._answers.expect(
            self._workspace.errands.run(partial(_write, image, path)),
            lambda path: self._workspace.notices.inform(f"wrote {path}"),
        )

    def close(self) -> None:
        """Tell of no further picture."""
        self._answers.close()

    def _refuse(self, said: str) -> None:
        self._workspace.notices.warn(said, "Choose another folder for logs in Settings.")


def _write(image: QImage, path: Path) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not image.save(str(path), "PNG"):
            raise OSError("the disk is full, or the folder is not to be written to")
    except OSError as error:
        raise WorkbenchError(f"the picture {path} could not be written: {error}") from error
    return path


class Recorder(QObject):
    """Begins and ends the log of what flies; a log that ends by itself is told.

    Args:
        flight: which is recorded.
        preferences: where the folder for logs is chosen.
        notices: where its end is told.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """It records now, or does not, or the file has grown."""
    recorded = pyqtSignal(str)
    """Path of a log that has been ended."""

    def __init__(
        self,
        flight: FlightModel,
        preferences: Preferences,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flight, self._preferences, self._notices = flight, preferences, notices
        self._path = ""
        self._since = 0.0
        self._timer = QTimer(self)
        self._timer.setInterval(LOOK)
        self._timer.timeout.connect(self.changed)
        flight.viewed.connect(self._follow)

    @property
    def path(self) -> str:
        """Of the log that is written, "" if none is."""
        return self._path

    @property
    def is_recording(self) -> bool:
        """Whether a log is written."""
        return bool(self._path)

    def said(self) -> str:
        """Return for how long and how much has been written, "" without a log."""
        if not self._path:
            return ""
        seconds = int(time.monotonic() - self._since)
        try:
            size = Path(self._path).stat().st_size
        except OSError:  # not there yet, or somebody took it away
            size = 0
        return f"{seconds // 60}:{seconds % 60:02d}  {size_text(size)}"

    def toggle(self) -> None:
        """Begin, or end."""
        if self._path:
            # the flight says how it ended, as for a log that ends by itself
            self._flight.order(LiveFlight.stop_log, refused=lambda said: None)
            return
        try:
            folder = log_folder(self._preferences)
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self._refuse(f"the folder for logs cannot be made: {error}")
            return
        vehicle = self._flight.view.vehicle
        path = folder / log_name(vehicle.name if vehicle else "flight", datetime.now())
        self._flight.order(lambda live: live.keep_log(path), refused=self._refuse)

    def _follow(self, view: LiveView) -> None:
        """Follow what the flight says of its log."""
        path = view.network.log
        if path == self._path:
            return
        before, self._path = self._path, path
        if path:
            self._since = time.monotonic()
            self._timer.start()
        else:
            self._timer.stop()
        if before:
            self._tell_end(before, view.network)
        self.changed.emit()

    def _tell_end(self, ended: str, network: NetworkView) -> None:
        """Tell how a log has ended, once: it is whole, or it is not there any more."""
        if not network.log_said and Path(ended).is_file():
            self._notices.inform(f"recorded {ended}")
            self.recorded.emit(ended)
            return
        said = network.log_said or f"{ended}: the file was moved or deleted"
        remedy = "The flight goes on. Choose another folder in Settings, then record again."
        self._notices.fail(f"recording has ended: {said}", remedy)

    def _refuse(self, said: str) -> None:
        self._notices.warn(said, "Choose another folder for logs in Settings.")
        self.changed.emit()


def log_name(vehicle: str, now: datetime) -> str:
    """Return a name by vehicle and date, without what file systems dislike."""
    return f"{re.sub(r'[^A-Za-z0-9_-]+', '_', vehicle) or 'flight'}-{now:%Y%m%d-%H%M%S}.mcap"


def size_text(size: int) -> str:
    """Return a size [bytes] in words."""
    if size < 1_000_000:
        return f"{size / 1000:.0f} kB"
    return f"{size / 1e6:.1f} MB" if size < 1e9 else f"{size / 1e9:.2f} GB"
