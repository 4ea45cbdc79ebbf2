"""Executors of many flights: their interface, tasks, and local processes.

Executors on other machines are in `cluster`.
"""

import logging
import logging.handlers
import multiprocessing
import os
import queue
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from multiprocessing.queues import SimpleQueue
from typing import TYPE_CHECKING, Any, Generic, Protocol, Self, TypeVar

from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.scenario.scenario import Scenario

Result = TypeVar("Result")

Stop = Callable[[], bool]
"""Function called regularly; True ends the work with the results so far."""
MAX_KILLED_PROCESSES = 3
"""Number of killed processes after which the work is abandoned."""
POOL_POLL_PERIOD_S = 0.2
"""Period between checks for a stop without results [s]."""


_SAFE_PATH = "PYTHONSAFEPATH"
"""Variable that keeps the current folder off the path of a Python process."""


@dataclass(frozen=True)
class Task(Generic[Result]):
    """Work that may run in any process: it can be pickled, and depends only on itself.

    Random numbers come from its own seed, so that the result is always the same.

    Attributes:
        scenario: with the files to read for it; elsewhere these are copies.
        work: a function of a module, called with the scenario and the arguments.
        arguments: of the function, after the scenario.
    """

    scenario: "Scenario"
    work: Callable[..., Result]
    arguments: tuple[Any, ...] = ()

    def with_scenario(self, scenario: "Scenario") -> Self:
        """Return the same task with the files of a scenario."""
        return replace(self, scenario=scenario)

    def run(self) -> Result:
        """Do it.

        Raises:
            WorkbenchError: if it fails; the error is passed to the caller.
        """
        return self.work(self.scenario, *self.arguments)


class Executor(Protocol):
    """Runs tasks."""

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """Yield the index of each task and its result, in order of completion.

        Tasks not begun when the iterator is closed or fails are abandoned.

        Args:
            tasks: to run.
            stop: True ends the work; finished results are still yielded.

        Raises:
            WorkbenchError: as raised by a task, or if the executor is lost.
        """
        ...


class InThisProcess:
    """Runs tasks in order in this process."""

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """See `Executor.run`."""
        for index, task in enumerate(tasks):
            yield index, task.run()
            if stop and stop():
                return


@dataclass(frozen=True)
class LocalProcesses:
    """Runs a number of tasks at a time, in spawned processes.

    Threads of Drake and numba do not survive a fork. As with all spawned processes, a script that
    uses them needs `if __name__ == "__main__":`. What they log is logged here.

    Attributes:
        count: of processes, 1 or more.
    """

    count: int

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """See `Executor.run`; what a process was at when it was killed is done again.

        Raises:
            WorkbenchError: as raised by a task, or if processes are killed repeatedly.
        """
        left = dict(enumerate(tasks))
        for _ in range(1 + MAX_KILLED_PROCESSES):
            try:
                for index, result in _in_pool(self.count, left, stop):
                    del left[index]
                    yield index, result
                return
            except BrokenProcessPool as error:
                broken = error
        raise WorkbenchError(
            f"processes that flew were ended from outside, {1 + MAX_KILLED_PROCESSES} times: let "
            "fewer fly at "
            "a time if memory ran out; a script needs `if __name__ == '__main__':`"
        ) from broken


def all_cores() -> LocalProcesses:
    """Return an executor with a process for each available core."""
    return LocalProcesses(available_cores())


def available_cores() -> int:
    """Return the number of cores that this process may use; macOS has no such bounds."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _in_pool(
    count: int, tasks: Mapping[int, Task[Result]], stop: Stop | None
) -> Iterator[tuple[int, Result]]:
    """Yield tasks' places and results, until all are done or it is stopped."""
    if not tasks:
        return
    done: queue.SimpleQueue[Future[Result]] = queue.SimpleQueue()
    spawned = multiprocessing.get_context("spawn")
    with _start_without_signals():
        said = spawned.SimpleQueue()
    reader, writer = spawned.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        min(count, len(tasks)), spawned, initializer=_set_up_process, initargs=(said, reader)
    )
    ended = True
    try:
        with _start_without_signals():
            places = {pool.submit(task.run): index for index, task in list(tasks.items())}
        for future in places:
            future.add_done_callback(done.put)
        waiting = len(places)
        while waiting and not (stop and stop()):
            _forward_log_messages(said)
            try:
                future = done.get(timeout=POOL_POLL_PERIOD_S)
            except queue.Empty:
                continue
            waiting -= 1
            yield places[future], future.result()
        ended = False
    finally:
        if ended:  # by an interrupt, or a task that failed: nobody waits for the others
            writer.close()
        pool.shutdown(cancel_futures=True)
        writer.close()
        _forward_log_messages(said)
    while not done.empty():  # what was in the air when it was stopped
        future = done.get()
        if not future.cancelled():
            yield places[future], future.result()


@contextmanager
def without_remarks() -> Iterator[None]:
    """Log errors only, of this thread, as the caller of its task has logged the remarks."""
    # the filter of a logger does not see what its children log
    loggers = [logging.getLogger(name) for name in ("workbench", PROGRESS_LOGGER)]
    thread = threading.get_ident()

    def passes(record: logging.LogRecord) -> bool:
        return record.thread != thread or record.levelno >= logging.ERROR

    for logger in loggers:
        logger.addFilter(passes)
    try:
        yield
    finally:
        for logger in loggers:
            logger.removeFilter(passes)


def _set_up_process(said: Any, caller: Connection) -> None:
    """Set a process up to log to its caller, and to end when that lets go of it or is gone."""
    logger = logging.getLogger("workbench")
    logger.setLevel(logging.INFO)
    logger.addHandler(_Sender(said))
    logger.propagate = False
    threading.Thread(target=_exit_with_caller, args=(caller,), daemon=True).start()


def _exit_with_caller(caller: Connection) -> None:
    """End this process at once when the other end of a pipe is closed."""
    caller.poll(None)
    os._exit(1)


class _Sender(logging.handlers.QueueHandler):
    """Sends what is logged at once: in a thread of its own it would be lost with the process."""

    def enqueue(self, record: logging.LogRecord) -> None:
        self.queue.put(record)  # pyrefly: ignore[missing-attribute]


def _forward_log_messages(said: "SimpleQueue[logging.LogRecord]") -> None:
    """Log the messages of processes."""
    while not said.empty():
        record = said.get()
        logging.getLogger(record.name).handle(record)


@contextmanager
def _start_without_signals() -> Iterator[None]:
    """Start processes that leave signals to end to this one: they inherit what is blocked.

    A terminal, a batch system and `timeout` send them to all processes of a group.

    They import nothing from the current folder, where a file may have a module's name, such as
    signal.py.
    """
    ending = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ending)
    path = os.environ.get(_SAFE_PATH)
    os.environ[_SAFE_PATH] = "1"
    try:
        yield
    finally:
        os.environ.pop(_SAFE_PATH)
        if path is not None:
            os.environ[_SAFE_PATH] = path
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
