"""Deferred work: in a thread, when an answer arrives, or after some time."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any, TypeVar

from PyQt6.QtCore import QObject, Qt, QTimer, pyqtSignal

from workbench.common.errors import WorkbenchError

Value = TypeVar("Value")


class BackgroundTasks:
    """Runs each piece of work in its own short-lived thread."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def run(self, work: Callable[[], Value]) -> "Future[Value]":
        """Start work, and return a Future of its result."""
        future: Future[Value] = Future()
        self.do(partial(_run_into_future, work, future))
        return future

    def do(self, work: Callable[[], object]) -> None:
        """Start work without a result; an exception is a programming error, and shown as one."""
        self._threads = [each for each in self._threads if each.is_alive()]
        thread = threading.Thread(target=work, name="errand")
        self._threads.append(thread)
        thread.start()

    def close(self) -> None:
        """Wait until all work is done; must be the last call."""
        for thread in self._threads:
            thread.join()


def _run_into_future(work: Callable[[], Value], future: "Future[Value]") -> None:
    try:
        result = work()
    except Exception as error:  # the Future carries it
        future.set_exception(error)
    else:
        future.set_result(result)


ResultCallback = Callable[[Any], None]
RefusalCallback = Callable[[str], None]


class FutureCallbacks(QObject):
    """Calls back in its own thread when a Future is done, and never blocks.

    Args:
        refused: called with a refusal if the asker passes no other function.
        parent: the Qt parent; this object is deleted with it.
    """

    _arrived = pyqtSignal(object, object, object)

    def __init__(self, refused: RefusalCallback, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._refused = refused
        self._closed = False
        queued = Qt.ConnectionType.QueuedConnection  # in whatever thread a Future is done
        self._arrived.connect(self._deliver, queued)  # pyrefly: ignore[bad-argument-count]

    def expect(
        self,
        future: "Future[Any]",
        done: ResultCallback | None = None,
        refused: RefusalCallback | None = None,
    ) -> None:
        """Call `done` with the value, or `refused` with the message of a WorkbenchError."""
        future.add_done_callback(lambda each: self._hear(each, done, refused))

    def close(self) -> None:
        """Stop calling back."""
        self._closed = True

    def _hear(
        self, future: "Future[Any]", done: ResultCallback | None, refused: RefusalCallback | None
    ) -> None:
        """Pass a Future on, from any thread."""
        if not self._closed:
            self._arrived.emit(future, done, refused)

    def _deliver(
        self, future: "Future[Any]", done: ResultCallback | None, refused: RefusalCallback | None
    ) -> None:
        if self._closed or future.cancelled():
            return
        error = future.exception()
        if isinstance(error, WorkbenchError):
            (refused or self._refused)(str(error))
        elif error is not None:
            raise error  # a programming error: the hook of unhandled exceptions shows it
        elif done is not None:
            done(future.result())


def single_shot(call: Callable[[], object], parent: QObject, after: int = 0) -> QTimer:
    """Return a timer, not yet started; each start restarts the delay.

    Args:
        call: function to call.
        parent: the Qt parent; the timer is deleted with it.
        after: delay [ms]; with 0 it calls after the present event.
    """
    timer = QTimer(parent)
    timer.setSingleShot(True)
    timer.setInterval(after)
    timer.timeout.connect(call)
    return timer
