"""Reads logs in a process of its own, and gives their series to charts."""

from collections.abc import Mapping
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.gui.visualization.log_messages import LogContents, Progress
from workbench.ipc.worker_process import WorkerProcess


class LogSource:
    """Series of a log by the names that a flight has.

    Args:
        contents: of the log.
    """

    def __init__(self, contents: LogContents) -> None:
        self._contents = contents

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""
        return self._contents.units

    def series(self, name: str, since: float = -np.inf) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values from a time on (N): views.

        Raises:
            WorkbenchError: if there is no such series.
        """
        if name not in self._contents.values:
            raise unknown_name("signal", name, self._contents.values)
        time = self._contents.times[self._contents.topic_of[name]]
        first = int(np.searchsorted(time, since))
        return time[first:], self._contents.values[name][first:]


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
