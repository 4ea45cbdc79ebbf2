"""A child process that answers requests, without letting its caller wait."""

import math
import pickle
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import DYING, ChildProcess


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
        most_unanswered: requests without an answer; further ones are refused.

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
        self._to_send: SimpleQueue[bytes | None] = SimpleQueue()
        self._sender = threading.Thread(target=self._send, name=f"to the {name}", daemon=True)
        self._listener = threading.Thread(target=self._listen, name=name, daemon=True)
        self._sender.start()
        self._listener.start()

    @property
    def requests(self) -> int:
        """Number of the last request."""
        return self._requests

    def send(self, message: object) -> None:
        """Send a message that is not answered; it is pickled now, and whatever that raises."""
        self._to_send.put(pickle.dumps(message))

    def ask(self, make: Callable[[], object], answer: "Future[Any] | None" = None) -> "Future[Any]":
        """Send a request, which is pickled now, and return what will be its answer.

        Args:
            make: makes what is asked; a WorkbenchError that it raises is the answer's exception.
            answer: an `unanswered_future` to be returned, where somebody has it already.
        """
        answer = answer or unanswered_future()
        try:
            what = make()
            with self._lock:
                if self._closed or self.ended:
                    raise WorkbenchError(self.ended or f"the {self.name} is closed")
                if len(self._unanswered) >= self._most_unanswered:
                    raise WorkbenchError(
                        f"the {self.name} has {self._most_unanswered} orders to answer still: "
                        "wait a bit"
                    )
                self.send(Request(self._requests + 1, what))
                self._requests += 1
                self._unanswered[self._requests] = answer
        except WorkbenchError as error:
            answer.set_exception(error)
        return answer

    def close(self, limit: float = 0.0, last: object = None) -> None:
        """Wait for the process's end for a time [s], then kill it; nothing of it is left.

        Args:
            limit: to wait before it is killed [s].
            last: a message that asks it to end, if any.
        """
        self._closed = True
        if last is not None:
            self.send(last)
        self.end(limit)
        if threading.current_thread() is not self._listener:  # an answer's callback may close
            self._listener.join(DYING)

    def _send(self) -> None:
        """Send what is queued until the end, or until nobody reads any more."""
        # The process is gone, as `_listen` finds out; or (TypeError) the connection was closed
        # here in the middle of a message.
        with suppress(OSError, TypeError):
            while (data := self._to_send.get()) is not None:
                self.connection.send_bytes(data)

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
        self._to_send.put(None)
        self._sender.join(DYING)
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
