"""What is done later: in a thread, once an answer has come, or after some time."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

from PyQt6.QtCore import QObject, Qt, QTimer, pyqtSignal

from workbench.common.errors import WorkbenchError

Value = TypeVar("Value")


class Errands:
    """Runs each piece of work in a short-lived thread of its own."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def run(self, work: Callable[[], Value]) -> "Future[Value]":
        """Begin work, and return what its result will be."""
        future: Future[Value] = Future()
        self.do(partial(_work, work, future))
        return future

    def do(self, work: Callable[[], object]) -> None:
        """Begin work without a result; what it raises is a fault of ours, and shown as such."""
        self._threads = [each for each in self._threads if each.is_alive()]
        thread = threading.Thread(target=work, name="errand")
        self._threads.append(thread)
        thread.start()

    def close(self) -> None:
        """Wait until all is done; the last call."""
        for thread in self._threads:
            thread.join()


def _work(work: Callable[[], Value], future: "Future[Value]") -> None:
    try:
        result = work()
    except Exception as error:  # the Future carries it
        future.set_exception(error)
    else:
        future.set_result(result)


Done = Callable[[Any], None]
Refused = Callable[[str], None]


class Answers(QObject):
    """Calls back in its own thread once a Future is done, and never blocks.

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
        """Stop calling back."""
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


def single_shot(call: Callable[[], object], parent: QObject, after: int = 0) -> QTimer:
    """Return a timer, not yet started; each start begins the wait again.

    Args:
        call: to be called.
        parent: the Qt parent; the timer is deleted with it.
        after: the wait [ms]; with 0 it calls when the present event is over.
    """
    timer = QTimer(parent)
    timer.setSingleShot(True)
    timer.setInterval(after)
    timer.timeout.connect(call)
    return timer
