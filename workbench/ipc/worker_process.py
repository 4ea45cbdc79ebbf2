"""A child process that answers requests, without letting its caller wait."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import DYING, ChildProcess
from workbench.ipc.send_queue import SendQueue


@dataclass(frozen=True)
class Request:
    """Something to do; what answers it has the same number. Numbers rise."""

    number: int
    what: Any


@dataclass(frozen=True)
class Answer:
    """A request was done: what came of it."""

    number: int
    value: object


@dataclass(frozen=True)
class Refusal:
    """A request was not done, and why, in a sentence."""

    number: int
    said: str


@dataclass(frozen=True)
class Superseded:
    """A request waited until a newer one of its kind came, and is dropped."""

    number: int


class SupersededError(WorkbenchError):
    """A newer request took the place of this one; nobody need be told."""


class WorkerProcess(ChildProcess):
    """A child process that answers requests; no method but `end` and `close` waits.

    A thread sends what is asked, another one hears the process until it is gone. What was not
    answered by then fails with the reason.

    Args:
        module: see `ChildProcess`; it reads Requests and writes Answers, Refusals, Superseded.
        name: see `ChildProcess`.
        hear: called with every other message, in a thread of this object's.
        on_end: called there when the process is gone, with the reason; what it returns is the
            reason that counts.

    Attributes:
        answered: whether it ever answered or refused a request.
        ended: why it has ended, a sentence; "" while it lives.

    Raises:
        WorkbenchError: if no process can be started.
    """

    def __init__(
        self,
        module: str,
        name: str,
        hear: Callable[[object], None],
        on_end: Callable[[str], str] = str,
    ) -> None:
        super().__init__(module, name)
        self.answered = False
        self.ended = ""
        self._hear, self._on_end = hear, on_end
        self._lock = threading.Lock()
        self._requests = 0
        self._unanswered: dict[int, Future[Any]] = {}
        self._closed = False
        self._queue = SendQueue(self.connection)
        self._listener = threading.Thread(target=self._listen, name=name, daemon=True)
        self._listener.start()

    @property
    def requests(self) -> int:
        """Number of the last request."""
        return self._requests

    @property
    def unanswered(self) -> int:
        """How many requests wait for an answer."""
        return len(self._unanswered)

    def send(self, message: object) -> None:
        """Send a message that is not answered; it is pickled now, and whatever that raises."""
        self._queue.post(message)

    def ask(self, what: object, answer: "Future[Any]") -> bool:
        """Send a request, which is pickled now; return False if the process has ended.

        Args:
            what: to do.
            answer: see `unanswered_future`; gets what comes of it, or a WorkbenchError.
        """
        with self._lock:
            if self._closed or self.ended:
                return False
            self._queue.post(Request(self._requests + 1, what))
            self._requests += 1
            self._unanswered[self._requests] = answer
        return True

    def close(self, limit: float = 0.0, last: object = None) -> None:
        """Wait for the process's end for a time [s], then kill it; nothing of it is left.

        Args:
            limit: to wait before it is killed [s].
            last: a message that asks it to end, if any.
        """
        self._closed = True
        if last is not None:
            self._queue.post(last)
        self.end(limit)
        if threading.current_thread() is not self._listener:  # an answer's callback may close
            self._listener.join(DYING)

    def _listen(self) -> None:
        """Hear the process until it is gone, and let go of it."""
        try:
            with suppress(EOFError, OSError):  # it is gone
                while True:
                    self._take(self.connection.recv())
            reason = f"the {self.name} is closed" if self._closed else self.cause()
        except Exception as error:  # what cannot be read: nothing can be trusted now
            reason = f"the {self.name}'s process said what cannot be read: {error!r:.100}"
            self.end(0.0)
        reason = self._on_end(reason)
        with self._lock:
            self.ended = reason
            unanswered, self._unanswered = self._unanswered, {}
        for answer in unanswered.values():
            answer.set_exception(WorkbenchError(reason))
        self._queue.close(DYING)
        self.release()

    def _take(self, message: object) -> None:
        match message:
            case Answer(number, value):
                self.answered = True
                self._pop(number).set_result(value)
            case Refusal(number, said):
                self.answered = True
                self._pop(number).set_exception(WorkbenchError(said))
            case Superseded(number):
                error = SupersededError("a newer request of this kind took its place")
                self._pop(number).set_exception(error)
            case _:
                self._hear(message)

    def _pop(self, number: int) -> "Future[Any]":
        with self._lock:
            return self._unanswered.pop(number)


def unanswered_future() -> "Future[Any]":
    """Return what will be the answer to a request; it cannot be cancelled."""
    answer: Future[Any] = Future()
    answer.set_running_or_notify_cancel()
    return answer


def failed(said: str) -> "Future[Any]":
    """Return the answer to a request that is refused at once."""
    answer: Future[Any] = Future()
    answer.set_exception(WorkbenchError(said))
    return answer
