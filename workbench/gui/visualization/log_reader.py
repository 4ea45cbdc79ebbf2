"""Reads logs in a process of its own, and gives their series to charts."""

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.gui.errands import Errands
from workbench.gui.visualization.log_messages import LogContents, Progress, ReadLog, Refused
from workbench.live.process import ChildProcess


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
        self._process: ChildProcess | None = None
        self._errands = Errands()
        queued = Qt.ConnectionType.QueuedConnection
        self._heard.connect(self._deliver, queued)  # type: ignore[call-arg]

    @property
    def is_reading(self) -> bool:
        """Whether a log is being read."""
        return self._process is not None

    def read(self, path: Path) -> None:
        """Begin to read a log; nothing waits."""
        self.stop()
        try:
            process = ChildProcess("workbench.gui.visualization.log_worker", "log reader")
        except WorkbenchError as error:
            self.refused.emit(str(error))
            return
        self._process = process
        self._errands.do(partial(self._listen, self._number, process, path))

    def stop(self) -> None:
        """Read no further."""
        process, self._process = self._process, None
        self._number += 1
        if process is not None:
            process.end(0.0)

    def close(self) -> None:
        """Stop, and wait until nothing is left of it; the last call."""
        self.stop()
        self._errands.close()

    def _listen(self, number: int, process: ChildProcess, path: Path) -> None:
        """Hear the process, in a thread, until it has said all."""
        said = False
        with suppress(EOFError, OSError):
            process.connection.send(ReadLog(path))
            while not said:
                message = process.connection.recv()
                said = not isinstance(message, Progress)
                self._heard.emit(number, message)
        cause = process.cause()
        process.release()
        if not said:
            self._heard.emit(number, Refused(f"{path}: {cause}"))

    def _deliver(self, number: int, message: object) -> None:
        if number != self._number:
            return  # of a log that nobody waits for
        match message:
            case Progress(share):
                self.progressed.emit(share)
            case Refused(said):
                self._process = None
                self.refused.emit(said)
            case LogContents():
                self._process = None
                self.ready.emit(message)
