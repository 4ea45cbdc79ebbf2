"""The caller's end of an analyst: `ask` returns at once, and the reply follows."""

import copy
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from typing import Any

from workbench.analysis.queries import (
    LONG_PROCESS,
    QUICK_PROCESS,
    SLOW_PROCESS,
    Query,
    StopQueries,
    place_of_answer,
)
from workbench.analysis.replies import Searched
from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerProcess, unanswered_future
from workbench.scenario.scenario import Scenario

ANALYST_CLOSED_TEXT = "the analyst is closed"
MAX_ANALYST_DEATHS = 3
"""Number of successive processes that die without an answer after which no other is started."""
NICENESS = {QUICK_PROCESS: 3, SLOW_PROCESS: 10, LONG_PROCESS: 10}
"""Niceness of each process: a flight beside them must keep its time."""


class AnalysisProcess:
    """Answers questions in its own process; only its start and `close` block.

    Args:
        begin: first message to every process, see `worker.main`.
        progressed: called in another thread with a `Searched`, or with a text about preparations,
            as compiling.
    """

    def __init__(
        self,
        begin: tuple[Scenario, Mapping[str, float], int],
        progressed: Callable[[Searched | str], None],
    ) -> None:
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
        """Whether no further process is started because too many have died."""
        return self._deaths >= MAX_ANALYST_DEATHS

    def ask(self, question: Query, answer: "Future[Any]") -> None:
        """Ask a question whose answer goes to a Future; start a process if there is none."""
        try:
            self._living().do(question, answer)
        except WorkbenchError as error:
            answer.set_exception(error)

    def warm_up(self) -> None:
        """Start the process, so that the first question does not wait for it."""
        with suppress(WorkbenchError):  # the first question reports the error
            self._living()

    def stop(self) -> None:
        """End all earlier questions; a search keeps its best result."""
        if self._worker is not None:
            self._worker.send(StopQueries(self._worker.requests))

    def close(self) -> None:
        """Kill the process, and start no further one."""
        with self._lock:
            self._closed = True
            worker = self._worker
        if worker is not None:
            worker.close()

    def _living(self) -> WorkerProcess:
        """Return a process that is presumably alive.

        Raises:
            WorkbenchError: if no process can be started.
        """
        with self._lock:
            if self._closed:
                raise WorkbenchError(ANALYST_CLOSED_TEXT)
            worker = self._worker
            if worker is not None and worker.ended:
                self._deaths = 1 if worker.answered else self._deaths + 1
                self._worker = None
                if self.has_given_up:
                    self._last = worker.ended
            if self.has_given_up:
                raise WorkbenchError(
                    f"the analyst has failed {MAX_ANALYST_DEATHS} times: {self._last}: open the "
                    "scenario again"
                )
            if self._worker is None:
                self._worker = WorkerProcess("workbench.analysis.worker", "analyst", self._hear)
                self._worker.send(self._begin)
            return self._worker

    def _hear(self, message: object) -> None:
        if isinstance(message, Searched | str):
            self._progressed(message)


def _ignore(_: Searched | str) -> None:
    """Do nothing with progress."""


class Analyst:
    """Evaluates gains of a scenario's vehicle beside its flight, in three processes.

    One is for quick questions, one for slow ones, and one for searches. Each starts at its first
    question, and after its death again at the next one. Only `close` blocks.

    Args:
        scenario: source of the vehicle with its variation and rates; flights use all of it.
        settings: values of the live parameters, over those of the scenario's gains.
        progress: called with a `Searched`, or with a text about preparations, as compiling, in a
            thread of this analyst.
    """

    def __init__(
        self,
        scenario: Scenario,
        settings: Mapping[str, float],
        progress: Callable[[Searched | str], None] = _ignore,
    ) -> None:
        self.scenario = copy.deepcopy(scenario)
        self.settings = dict(settings)
        self._processes = {
            process: AnalysisProcess((self.scenario, self.settings, niceness), progress)
            for process, niceness in NICENESS.items()
        }
        self._lock = threading.Lock()
        self._closed = False
        # Starting a process takes ten milliseconds, longer than a screen may wait.
        self._background = ThreadPoolExecutor(1, thread_name_prefix="analyst")

    @property
    def pids(self) -> tuple[int | None, ...]:
        """Process IDs of the quick, slow and searching process, None before they start."""
        return tuple(each.pid for each in self._processes.values())

    @property
    def has_given_up(self) -> bool:
        """Whether a process died so often that questions to it are now refused."""
        return any(each.has_given_up for each in self._processes.values())

    def ask(self, question: Query) -> "Future[Any]":
        """Ask a question; the Future gets the reply, or a WorkbenchError with the reason for none.

        Of an asker's questions of a kind the newest counts: an older one that still waits fails
        with a `SupersededError`; one in progress is answered, so that a screen can follow a slider
        that keeps moving.
        """
        answer = unanswered_future()
        place = place_of_answer(type(question))
        if place is None:
            said = f"{question!r:.60} is not a question: ask one of workbench.analysis.queries"
            answer.set_exception(WorkbenchError(said))
            return answer
        process, _ = place
        if not self._submit(partial(self._processes[process].ask, question, answer)):
            answer.set_exception(WorkbenchError(ANALYST_CLOSED_TEXT))
        return answer

    def warm_up(self) -> None:
        """Start the quick and the slow process, so that the first questions need not wait."""
        for process in (QUICK_PROCESS, SLOW_PROCESS):
            self._submit(self._processes[process].warm_up)

    def stop(self) -> None:
        """End a search soon, and keep its best result."""
        self._submit(self._processes[LONG_PROCESS].stop)

    def close(self) -> None:
        """Kill the processes, and wait until they are gone; must be the last call."""
        with self._lock:
            self._closed = True
        self._background.shutdown()
        for process in self._processes.values():
            process.close()

    def _submit(self, act: Callable[[], None]) -> bool:
        """Run a function in the background thread, in order; return False after `close`."""
        with self._lock:
            if not self._closed:
                self._background.submit(act)
            return not self._closed
