"""A child process that answers requests without blocking its caller."""

import math
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import CHILD_EXIT_TIMEOUT_S, ChildProcess
from workbench.ipc.send_queue import SendQueue

Order = TypeVar("Order")
"""What a worker is asked for."""


@dataclass(frozen=True)
class WorkerRequest:
    """Something to do; its answer has the same number. Numbers increase."""

    number: int
    what: Any


@dataclass(frozen=True)
class WorkerResult:
    """Result of a request."""

    number: int
    value: object


@dataclass(frozen=True)
class WorkerRefusal:
    """Reason why a request failed, as a sentence."""

    number: int
    said: str


@dataclass(frozen=True)
class Superseded:
    """A request that was dropped because a newer one of its kind arrived."""

    number: int


class SupersededError(WorkbenchError):
    """A newer request replaced this one; the user need not be told."""


class WorkerProcess(ChildProcess, Generic[Order]):
    """A child process that answers requests; only `end` and `close` block.

    A `SendQueue` sends requests, and a thread receives messages until the process is gone. Requests
    without an answer then fail with the reason.

    Args:
        module: see `ChildProcess`; it reads Requests and writes Answers, Refusals, Superseded.
        name: see `ChildProcess`.
        hear: called with every other message, in a thread of this object.
        on_end: called in that thread when the process is gone, with the reason; the reason that it
            returns replaces it.
        most_unanswered: limit of requests without an answer; further ones are refused.

    Attributes:
        answered: whether it has ever answered or refused a request.
        ended: why it has ended, as a sentence; "" while it runs.

    Raises:
        WorkbenchError: if the process cannot be started.
    """

    def __init__(
        self,
        module: str,
        name: str,
        hear: Callable[[object], None],
        on_end: Callable[[str], str] = str,
        most_unanswered: float = math.inf,
    ) -> None:
        super().__init__(module, name)
        self.answered = False
        self.ended = ""
        self._hear, self._on_end = hear, on_end
        self._most_unanswered = most_unanswered
        self._lock = threading.Lock()
        self._requests = 0
        self._unanswered: dict[int, Future[Any]] = {}
        self._closed = False
        self._send_queue = SendQueue(self.connection, f"to the {name}")
        self._listener = threading.Thread(target=self._listen, name=name, daemon=True)
        self._listener.start()

    @property
    def requests(self) -> int:
        """Number of the last request."""
        return self._requests

    def send(self, message: object) -> None:
        """Send a message that has no answer; raises here if it cannot be pickled."""
        self._send_queue.post(message)

    def do(self, what: Order, /, answer: "Future[Any] | None" = None) -> "Future[Any]":
        """Send a request, which is pickled now, and return a Future of its answer.

        Args:
            what: the request's content.
            answer: an `unanswered_future` to return, if the caller already has one.
        """
        answer = answer or unanswered_future()
        try:
            with self._lock:
                if self._closed or self.ended:
                    raise WorkbenchError(self.ended or f"the {self.name} is closed")
                if len(self._unanswered) >= self._most_unanswered:
                    raise WorkbenchError(
                        f"the {self.name} has {self._most_unanswered} orders still to answer: wait "
                        "a moment"
                    )
                self._send_queue.post(WorkerRequest(self._requests + 1, what))
                self._requests += 1
                self._unanswered[self._requests] = answer
        except WorkbenchError as error:
            answer.set_exception(error)
        except Exception as error:  # a user's object may fail in any way
            said = f"the request cannot be sent to a process: {error}"
            answer.set_exception(WorkbenchError(said))
        return answer

    def close(self, limit: float = 0.0, last: object = None) -> None:
        """Wait for the process's end for a time [s], then kill it, and release everything.

        Args:
            limit: time before it is killed [s].
            last: a message that asks it to end, if any.
        """
        self._closed = True
        if last is not None:
            self.send(last)
        self.end(limit)
        if threading.current_thread() is not self._listener:  # a callback may call close
            self._listener.join(CHILD_EXIT_TIMEOUT_S)

    def _listen(self) -> None:
        """Receive messages until the process is gone, then release it."""
        try:
            with suppress(EOFError, OSError):  # the process is gone
                while True:
                    self._take(self.connection.recv())
            reason = f"the {self.name} is closed" if self._closed else self.cause()
        except Exception as error:  # an unreadable message: the stream can no longer be trusted
            reason = f"the {self.name}'s process sent an unreadable answer: {error!r:.100}"
            self.end(0.0)
        reason = self._on_end(reason)
        with self._lock:
            self.ended = reason
            unanswered, self._unanswered = self._unanswered, {}
        for answer in unanswered.values():
            answer.set_exception(WorkbenchError(reason))
        self._send_queue.close(CHILD_EXIT_TIMEOUT_S)
        self.release()

    def _take(self, message: object) -> None:
        match message:
            case WorkerResult(number, value):
                self.answered = True
                self._pop(number).set_result(value)
            case WorkerRefusal(number, said):
                self.answered = True
                self._pop(number).set_exception(WorkbenchError(said))
            case Superseded(number):
                error = SupersededError("a newer request of this kind replaced it")
                self._pop(number).set_exception(error)
            case _:
                self._hear(message)

    def _pop(self, number: int) -> "Future[Any]":
        with self._lock:
            return self._unanswered.pop(number)


def unanswered_future() -> "Future[Any]":
    """Return a Future for the answer to a request; it cannot be cancelled."""
    answer: Future[Any] = Future()
    answer.set_running_or_notify_cancel()
    return answer
