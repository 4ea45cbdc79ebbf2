"""The reader of logs in the background, one log at a time."""

from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerProcess

LOG_READER_TIMEOUT_S = 1.0
"""Time for a log reader to end what it has started, before it is killed [s]."""


class LogReaderWorker(QObject):
    """Reads one log at a time; a newer one ends the reading of an older one."""

    progressed = pyqtSignal(float)
    """Share of the log that is read, 0 .. 1."""
    ready = pyqtSignal(object)
    """The `Flight` of a log, or the `SpecContents` of a spec."""
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
        process.do(path).add_done_callback(heard)

    def close(self) -> None:
        """Stop reading and release everything."""
        process, self._process = self._process, None
        self._number += 1
        if process is not None:
            process.close(LOG_READER_TIMEOUT_S, last="no more")

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
