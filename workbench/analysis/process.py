"""A worker process that judges, started when it is first needed and again when it has died."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from workbench.analysis.messages import Begin, Preparing, Progressed, Stop
from workbench.analysis.questions import Question
from workbench.analysis.replies import Searched
from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerProcess

CLOSED = "the analyst is closed"
MOST_DEATHS = 3
"""So many processes in a row may end without an answer; then no further one is started."""


class AnalysisProcess:
    """Answers questions in a process of its own; only its start and `close` take time.

    Args:
        begin: what every process is told first.
        progressed: called with a `Searched` or a `Preparing`, in another thread.
    """

    def __init__(self, begin: Begin, progressed: Callable[[Searched | Preparing], None]) -> None:
        self._begin = begin
        self._progressed = progressed
        self._lock = threading.Lock()
        self._worker: WorkerProcess | None = None
        self._deaths = 0
        self._last = ""
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Process ID, None before the first start."""
        return self._worker.pid if self._worker else None

    @property
    def has_given_up(self) -> bool:
        """Whether no further process is started, as too many have died."""
        return self._deaths >= MOST_DEATHS

    def ask(self, question: Question, answer: "Future[Any]") -> None:
        """Ask, and give the answer to a Future; a process is started if there is none."""
        try:
            self._living().ask(lambda: question, answer)
        except WorkbenchError as error:
            answer.set_exception(error)
        except Exception as error:  # a stranger's object may fail in any way
            said = f"the question cannot be sent to a process: {error}"
            answer.set_exception(WorkbenchError(said))

    def warm_up(self) -> None:
        """Start the process, so that the first question need not wait for that."""
        with suppress(WorkbenchError):  # which the first question will be told
            self._living()

    def stop(self) -> None:
        """End what was asked so far; a search keeps its best."""
        if self._worker is not None:
            self._worker.send(Stop(self._worker.requests))

    def close(self) -> None:
        """Kill the process, and start no further one."""
        with self._lock:
            self._closed = True
            worker = self._worker
        if worker is not None:
            worker.close()

    def _living(self) -> WorkerProcess:
        """Return a process that lives, as far as is known.

        Raises:
            WorkbenchError: if there is none.
        """
        with self._lock:
            if self._closed:
                raise WorkbenchError(CLOSED)
            worker = self._worker
            if worker is not None and worker.ended:
                self._deaths = 1 if worker.answered else self._deaths + 1
                self._worker = None
                if self.has_given_up:
                    self._last = worker.ended
            if self.has_given_up:
                raise WorkbenchError(
                    f"the analyst has failed {MOST_DEATHS} times: {self._last}: open the "
                    "scenario again"
                )
            if self._worker is None:
                self._worker = WorkerProcess("workbench.analysis.worker", "analyst", self._hear)
                self._worker.send(self._begin)
            return self._worker

    def _hear(self, message: object) -> None:
        match message:
            case Progressed(_, searched):
                self._progressed(searched)
            case Preparing():
                self._progressed(message)
