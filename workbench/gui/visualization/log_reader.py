"""Reads a log in a process of its own and tells when it is there."""

from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.gui.visualization.log_messages import Progress
from workbench.ipc.worker_process import WorkerProcess


class LogReader(QObject):
    """One log at a time; a newer one ends the reading of an older one."""

    progressed = pyqtSignal(float)
    """Share that is read, 0 .. 1."""
    ready = pyqtSignal(object)
    """The `LogContents`."""
    refused = pyqtSignal(str)
    """Why it cannot be read, a sentence."""
    _heard = pyqtSignal(int, object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._number = 0
        self._process: WorkerProcess | None = None
        queued = Qt.ConnectionType.QueuedConnection  # from a thread of the process's
        self._heard.connect(self._deliver, queued)  # type: ignore[call-arg]

    @property
    def is_reading(self) -> bool:
        """Whether a log is being read."""
        return self._process is not None

    def read(self, path: Path) -> None:
        """Begin to read a log; nothing waits."""
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
        """Read no further; nothing is left of it."""
        process, self._process = self._process, None
        self._number += 1
        if process is not None:
            process.close()

    def _deliver(self, number: int, message: "Progress | Future[Any]") -> None:
        if number != self._number:
            return  # of a log that nobody waits for
        if isinstance(message, Progress):
            self.progressed.emit(message.share)
            return
        self.close()
        if error := message.exception():
            self.refused.emit(str(error))
        else:
            self.ready.emit(message.result())
