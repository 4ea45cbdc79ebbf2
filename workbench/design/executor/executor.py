"""What flies many flights: the interface, what a flight must be to go anywhere, and processes.

Other executors than those of this machine stand in `cluster`.
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
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.queues import SimpleQueue
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.scenario.scenario import Scenario

Result = TypeVar("Result")
Result_co = TypeVar("Result_co", covariant=True)

Stop = Callable[[], bool]
"""Asked from time to time; True ends the work with what is done."""
MOST_LOST = 3
"""So often processes may be ended from outside before the work is given up."""
ASK = 0.2
"""Time between two questions whether to stop, while nothing gets done [s]."""


class Task(Protocol[Result_co]):
    """Work that may be done in any process: it can be pickled, and depends on nothing but itself.

    Chance in it comes from a seed that it carries, so that it gives the same wherever it is done,
    and however often.
    """

    @property
    def scenario(self) -> "Scenario":
        """What names the files that are read for it."""
        ...

    def with_scenario(self, scenario: "Scenario") -> Self:
        """Return the same task with the files of that scenario: copies that lie elsewhere."""
        ...

    def run(self) -> Result_co:
        """Do it.

        Raises:
            WorkbenchError: where it cannot be done; it arrives where the work was asked for.
        """
        ...


class Executor(Protocol):
    """Does tasks somewhere."""

    def run(
        self, tasks: Sequence[Task[Result]], stop: Stop | None = None
    ) -> Iterator[tuple[int, Result]]:
        """Yield the place of each task and its result, as they get done.

        What is not begun when the iterator is closed, or fails, is given up.

        Args:
            tasks: what is to be done.
            stop: True ends it: what is done by then is still yielded.

        Raises:
            WorkbenchError: as a task raised it, or if what does the tasks is lost for good.
        """
        ...


class InThisProcess:
    """Does tasks in their order."""

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
    """Does so many tasks at a time, in processes that are started anew and not forked.

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
            WorkbenchError: as a task raised it, or if processes are killed again and again.
        """
        left = dict(enumerate(tasks))
        for _ in range(1 + MOST_LOST):
            try:
                for index, result in _in_pool(self.count, left, stop):
                    del left[index]
                    yield index, result
                return
            except BrokenProcessPool as error:
                broken = error
        raise WorkbenchError(
            f"processes that flew were ended from outside, {1 + MOST_LOST} times: let fewer fly at "
            "a time if it was for want of memory; a script needs `if __name__ == '__main__':`"
        ) from broken


def all_cores() -> LocalProcesses:
    """Return a process for each core that this one may use."""
    return LocalProcesses(len(os.sched_getaffinity(0)))


def _in_pool(
    count: int, tasks: Mapping[int, Task[Result]], stop: Stop | None
) -> Iterator[tuple[int, Result]]:
    """Yield tasks' places and results, until all are done or it is stopped."""
    if not tasks:
        return
    done: queue.SimpleQueue[Future[Result]] = queue.SimpleQueue()
    spawned = multiprocessing.get_context("spawn")
    said = spawned.SimpleQueue()
    reader, writer = spawned.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        min(count, len(tasks)), spawned, initializer=_begin, initargs=(said, reader)
    )
    ended = True
    try:
        with without_interrupts():
            places = {pool.submit(task.run): index for index, task in list(tasks.items())}
        for future in places:
            future.add_done_callback(done.put)
        waiting = len(places)
        while waiting and not (stop and stop()):
            _pass_on(said)
            try:
                future = done.get(timeout=ASK)
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
        _pass_on(said)
    while not done.empty():  # what was in the air when it was stopped
        future = done.get()
        if not future.cancelled():
            yield places[future], future.result()


def _begin(said: Any, caller: Connection) -> None:
    """Set a process up to log to its caller, and to end when that lets go of it or is gone."""
    logger = logging.getLogger("workbench")
    logger.setLevel(logging.INFO)
    logger.addHandler(_Sender(said))
    logger.propagate = False
    threading.Thread(target=_end_with, args=(caller,), daemon=True).start()


def _end_with(caller: Connection) -> None:
    """End this process at once when the other end of a pipe is closed."""
    caller.poll(None)
    os._exit(1)


class _Sender(logging.handlers.QueueHandler):
    """Sends what is logged at once: in a thread of its own it would be lost with the process."""

    def enqueue(self, record: logging.LogRecord) -> None:
        self.queue.put(record)  # type: ignore[attr-defined]


def _pass_on(said: "SimpleQueue[logging.LogRecord]") -> None:
    """Log what processes have logged."""
    while not said.empty():
        record = said.get()
        logging.getLogger(record.name).handle(record)


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Start processes that leave Ctrl-C to this one: they inherit what is blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
