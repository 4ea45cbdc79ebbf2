"""Questions that wait while another one is answered, and the work on one question."""

import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from workbench.analysis.queries import StopQueries
from workbench.analysis.replies import Searched
from workbench.common.errors import WorkbenchError
from workbench.ipc.send_queue import SendQueue
from workbench.ipc.worker_process import Superseded, WorkerRequest

WORK_STOPPED_TEXT = "it was stopped before it was done"
Working = Iterator[Any]
"""Work on an answer: yields None where it can pause, and finally the reply."""


class RequestQueue:
    """Holds questions that are not begun yet; a thread receives them.

    The process exits at once when the caller's end of the connection closes, even in the middle of
    a search, which may take minutes.

    Args:
        connection: connection to the caller.
        send_queue: queue to the caller; reports dropped questions.
        end: called when the caller is gone.
    """

    def __init__(
        self,
        connection: Connection,
        send_queue: SendQueue,
        end: Callable[[], None] = lambda: os._exit(0),
    ) -> None:
        self._connection = connection
        self._send_queue = send_queue
        self._end = end
        self._waiting: dict[tuple[type, int], WorkerRequest] = {}
        self._stopped = 0
        self._stopper: tuple[int, Callable[[], None]] | None = None
        self._change = threading.Condition()
        threading.Thread(target=self._listen, name="request queue", daemon=True).start()

    @property
    def stopped(self) -> int:
        """Largest number of a stopped question."""
        return self._stopped

    def take(self, kinds: set[type], wait: bool) -> list[WorkerRequest]:
        """Take the question of each kind that waits longest.

        Args:
            kinds: kinds that are not taken.
            wait: whether to wait for one.
        """
        with self._change:
            if wait:
                self._change.wait_for(lambda: {kind for kind, _ in self._waiting} - kinds)
            first: dict[type, tuple[type, int]] = {}
            for kind, asker in self._waiting:
                if kind not in kinds:
                    first.setdefault(kind, (kind, asker))
            return [self._waiting.pop(stream) for stream in first.values()]

    def on_stop(self, number: int, act: Callable[[], None]) -> None:
        """Call a function in another thread when a question is stopped; the last one counts."""
        with self._change:
            self._stopper = (number, act)
            if number <= self._stopped:
                act()

    def _listen(self) -> None:
        """Receive messages until the caller is gone."""
        try:
            while True:
                self._hear(self._connection.recv())
        except (EOFError, OSError):
            self._end()

    def _hear(self, message: object) -> None:
        with self._change:
            match message:
                case WorkerRequest(_, query):
                    older = self._waiting.pop(query.stream, None)
                    if older is not None:
                        self._send_queue.post(Superseded(older.number))
                    self._waiting[query.stream] = message
                    self._change.notify()
                case StopQueries(number):
                    self._stopped = max(self._stopped, number)
                    if self._stopper is not None and self._stopper[0] <= number:
                        self._stopper[1]()


@dataclass(frozen=True)
class Work:
    """The work on one question.

    Attributes:
        number: number of the question.
        requests: reports a stop.
        send_queue: takes progress.
    """

    number: int
    requests: RequestQueue
    send_queue: SendQueue

    @property
    def stopped(self) -> bool:
        """Whether the caller no longer wants the answer."""
        return self.number <= self.requests.stopped

    def check(self, _share: float = 0.0) -> None:
        """Raise an exception if the caller no longer wants the answer; a callback for progress.

        Raises:
            WorkbenchError: if the answer is no longer wanted.
        """
        if self.stopped:
            raise WorkbenchError(WORK_STOPPED_TEXT)

    def on_stop(self, act: Callable[[], None]) -> None:
        """Call a function when the caller stops the question: at once, in another thread."""
        self.requests.on_stop(self.number, act)

    def tell(self, searched: Searched) -> None:
        """Report progress."""
        self.send_queue.show(searched)
