"""One life of an analyst's process: questions go out, answers come in, and its end is noticed."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from workbench.analysis.messages import (
    Answered,
    Ask,
    Begin,
    Preparing,
    Progressed,
    Refused,
    Stop,
    Superseded,
)
from workbench.analysis.questions import Question
from workbench.analysis.replies import Searched
from workbench.analysis.superseded import SupersededError
from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import DYING, ChildProcess
from workbench.ipc.send_queue import SendQueue

CLOSED = "the analyst is closed"
MODULE = "workbench.analysis.worker"


class Line:
    """Starts a process and exchanges messages with it; only `close` ever waits.

    Args:
        begin: what the process is told first.
        progressed: called with a `Searched` or a `Preparing`, in a thread of this line's.

    Attributes:
        answered: whether it ever answered.
        ended: why it has ended, "" while it lives.

    Raises:
        WorkbenchError: if no process can be started.
    """

    def __init__(self, begin: Begin, progressed: Callable[[Searched | Preparing], None]) -> None:
        self.answered = False
        self.ended = ""
        self._progressed = progressed
        self._lock = threading.Lock()
        self._waiting: dict[int, Future[Any]] = {}
        self._asked = 0
        self._closed = False
        self._process = ChildProcess(MODULE, "analyst")
        self._outbox = SendQueue(self._process.connection)
        self._outbox.post(begin)
        self._listener = threading.Thread(target=self._listen, name="analyst", daemon=True)
        self._listener.start()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def ask(self, question: Question) -> "Future[Any] | None":
        """Ask, and return what the reply will be; None if the process has ended.

        Raises:
            WorkbenchError: if the question cannot be sent to a process.
        """
        with self._lock:
            if self._closed or self.ended:
                return None
            try:
                self._outbox.post(Ask(self._asked + 1, question))
            except Exception as error:  # a stranger's object may fail in any way
                raise WorkbenchError(f"the question cannot be sent to a process: {error}") from None
            self._asked += 1
            reply: Future[Any] = Future()
            reply.set_running_or_notify_cancel()  # from now on it cannot be cancelled
            self._waiting[self._asked] = reply
        return reply

    def stop(self) -> None:
        """End what was asked so far; a search keeps its best."""
        with self._lock:
            self._outbox.post(Stop(self._asked))

    def close(self) -> None:
        """Kill the process, whatever it does, and wait until nothing of it is left."""
        with self._lock:
            self._closed = True
        self._process.end(0.0)
        if threading.current_thread() is not self._listener:  # an answer's callback may close
            self._listener.join(DYING)

    def _listen(self) -> None:
        """Hear the process until it is gone, and let go of it."""
        try:
            with suppress(EOFError, OSError):  # it is gone
                while True:
                    self._hear(self._process.connection.recv())
            reason = CLOSED if self._closed else self._process.cause()
        except Exception as error:  # what cannot be read: nothing can be trusted now
            reason = f"the analyst's process said what cannot be read: {error!r:.100}"
            self._process.end(0.0)
        with self._lock:
            self.ended = reason
            waiting, self._waiting = self._waiting, {}
        for reply in waiting.values():
            reply.set_exception(WorkbenchError(reason))
        self._outbox.close(DYING)
        self._process.release()

    def _hear(self, message: object) -> None:
        match message:
            case Answered(number, reply):
                self.answered = True
                self._take(number).set_result(reply)
            case Refused(number, said):
                self.answered = True
                self._take(number).set_exception(WorkbenchError(said))
            case Superseded(number):
                self._take(number).set_exception(SupersededError())
            case Progressed(_, searched):
                self._progressed(searched)
            case Preparing():
                self._progressed(message)

    def _take(self, number: int) -> "Future[Any]":
        with self._lock:
            return self._waiting.pop(number)
