"""The caller's end of a live flight: orders go out, answers come in, and a death is noticed."""

import pickle
import threading
from collections import deque
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.link.backplane import Published
from workbench.live.messages import (
    Answer,
    Begin,
    Close,
    Excite,
    Failed,
    FlyOn,
    Hold,
    Order,
    Phase,
    Question,
    Refusal,
    Report,
    SetSpeed,
    StopExciting,
    Streamed,
)
from workbench.live.network_orders import NetworkOrder
from workbench.live.outbox import Outbox
from workbench.live.process import DYING, ChildProcess
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action

MOST_WAITING = 1000
"""Orders without an answer; further ones are refused."""

MOST_STREAMED = 4000
"""Samples that are kept for who draws them, some 20 s; then the oldest go."""

Wanted = Action | Excite | StopExciting | Hold | SetSpeed | FlyOn | Question | NetworkOrder


class Exchange:
    """Starts a flight's process and exchanges messages with it; only `close` ever waits.

    Args:
        begin: what to fly.

    Attributes:
        view: the newest.
        begun: set once the flight has begun, or has ended before.
        streamed: what was published and is not taken yet.
        missed: so much of that was left out.

    Raises:
        WorkbenchError: if no process can be started, or that cannot be told to one.
    """

    def __init__(self, begin: Begin) -> None:
        try:
            pickle.dumps(begin)
        except Exception as error:  # a stranger's object may fail in any way
            raise WorkbenchError(f"the scenario cannot be sent to a process: {error}") from error
        self.view = LiveView()
        self.begun = threading.Event()
        self.streamed: deque[Published] = deque(maxlen=MOST_STREAMED)
        self.missed = 0
        self._lock = threading.Lock()
        self._waiting: dict[int, Future[Any]] = {}
        self._orders = 0
        self._closed = False
        self._process = ChildProcess("workbench.live.worker", "flight")
        self._outbox = Outbox(self._process.connection)
        self._outbox.post(begin)
        self._listener = threading.Thread(target=self._listen, name="live flight", daemon=True)
        self._listener.start()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def send(self, wanted: Wanted) -> Future[Any]:
        """Send an order, and return what its answer will be."""
        with self._lock:
            if self._closed or self.view.phase is Phase.ENDED:
                return failed(self.view.said or "the flight is closed")
            if len(self._waiting) >= MOST_WAITING:
                return failed(f"the flight has {MOST_WAITING} orders to answer still: wait a bit")
            self._orders += 1
            answer: Future[Any] = Future()
            answer.set_running_or_notify_cancel()  # from now on it cannot be cancelled
            self._waiting[self._orders] = answer
            self._outbox.post(Order(self._orders, wanted))
        return answer

    def close(self, limit: float) -> None:
        """End the process, and kill it after a time [s], or at once if nothing was flown yet."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._outbox.post(Close.CLOSE)
        self._process.end(limit if self.begun.is_set() else 0.0)
        # both end by themselves once nobody is at the other end
        if threading.current_thread() is not self._listener:  # an answer's callback may close
            self._listener.join(DYING)
        self._outbox.close(DYING)
        self._process.release()

    def _listen(self) -> None:
        """Hear the process until it is gone, and show that it is."""
        try:
            failed = self._hear_all()
        except Exception as error:  # what cannot be read: nothing can be trusted now
            failed = Failed(f"the flight's process said what cannot be read: {error!r:.100}")
            self._process.end(0.0)
        self._end(failed)

    def _hear_all(self) -> Failed:
        """Hear the process until it is gone; return what it said of a failure, if anything."""
        heard = Failed("")
        with suppress(EOFError, OSError):  # it is gone; `_end` finds out why
            while True:
                message = self._process.connection.recv()
                if isinstance(message, Failed):
                    heard = message
                else:
                    self._hear(message)
        return heard

    def _hear(self, message: object) -> None:
        if isinstance(message, Streamed):
            full = len(self.streamed) + len(message.published) - MOST_STREAMED
            self.missed += message.lost + max(0, full)
            self.streamed.extend(message.published)
            return
        self.view = self.view.after(message)
        match message:
            case Report():
                self.begun.set()
            case Answer(number, value):
                self._waiting.pop(number).set_result(value)
            case Refusal(number, said):
                self._waiting.pop(number).set_exception(WorkbenchError(said))

    def _end(self, failed: Failed) -> None:
        """Show that the flight has ended, and fail what still waits."""
        reason = failed.said or ("the flight is closed" if self._closed else self._process.cause())
        with self._lock:
            self.view = self.view.ended(reason, failed.needed)
            waiting, self._waiting = self._waiting, {}
        for answer in waiting.values():
            answer.set_exception(WorkbenchError(reason))
        self.begun.set()


def failed(said: str) -> Future[Any]:
    """Return the answer to an order that is refused at once."""
    answer: Future[Any] = Future()
    answer.set_exception(WorkbenchError(said))
    return answer
