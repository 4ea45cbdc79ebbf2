"""Brings the answers of other processes into the thread of the screens."""

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.common.errors import WorkbenchError

Done = Callable[[Any], None]
Refused = Callable[[str], None]


class Answers(QObject):
    """Calls back in its own thread once a Future is done; nobody waits for it.

    Args:
        refused: told of a refusal where the asker says nothing else.
        parent: the Qt parent; this object is deleted with it.
    """

    _arrived = pyqtSignal(object, object, object)

    def __init__(self, refused: Refused, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._refused = refused
        self._closed = False
        queued = Qt.ConnectionType.QueuedConnection  # whatever thread a Future is done in
        self._arrived.connect(self._deliver, queued)  # type: ignore[call-arg]

    def expect(
        self, future: "Future[Any]", done: Done | None = None, refused: Refused | None = None
    ) -> None:
        """Call `done` with the value, or `refused` with the sentence of a WorkbenchError."""
        future.add_done_callback(lambda each: self._hear(each, done, refused))

    def close(self) -> None:
        """Call nobody back any more."""
        self._closed = True

    def _hear(self, future: "Future[Any]", done: Done | None, refused: Refused | None) -> None:
        """Pass a Future on, in whatever thread it was done."""
        if not self._closed:
            self._arrived.emit(future, done, refused)

    def _deliver(self, future: "Future[Any]", done: Done | None, refused: Refused | None) -> None:
        if self._closed or future.cancelled():
            return
        error = future.exception()
        if isinstance(error, WorkbenchError):
            (refused or self._refused)(str(error))
        elif error is not None:
            raise error  # a fault of ours: the hook of unhandled exceptions shows it
        elif done is not None:
            done(future.result())
