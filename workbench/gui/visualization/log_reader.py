"""Reads a log in a process of its own and tells when it is there."""

from contextlib import suppress
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import Errands
from workbench.gui.visualization.log_messages import LogContents, Progress, ReadLog, Refused
from workbench.ipc.child_process import ChildProcess


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
