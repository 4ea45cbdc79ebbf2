"""Tasks done in processes of this machine."""

import multiprocessing
import os
import queue
import signal
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass

from workbench.design.executor.executor import Result, Stop, Task
from workbench.errors import WorkbenchError

MOST_LOST = 3
"""So often processes may be ended from outside before the work is given up."""
ASK = 0.2
"""Time between two questions whether to stop, while nothing gets done [s]."""


@dataclass(frozen=True)
class LocalProcesses:
    """Does so many tasks at a time, in processes that are started anew and not forked.

    Threads of Drake and numba do not survive a fork. As with all spawned processes, a script that
    uses them needs `if __name__ == "__main__":`.

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
    pool = ProcessPoolExecutor(
        min(count, len(tasks)), mp_context=multiprocessing.get_context("spawn")
    )
    try:
        with without_interrupts():
            places = {pool.submit(task.run): index for index, task in list(tasks.items())}
        for future in places:
            future.add_done_callback(done.put)
        waiting = len(places)
        while waiting and not (stop and stop()):
            try:
                future = done.get(timeout=ASK)
            except queue.Empty:
                continue
            waiting -= 1
            yield places[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)
    while not done.empty():  # what was in the air when it was stopped
        future = done.get()
        if not future.cancelled():
            yield places[future], future.result()


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Start processes that leave Ctrl-C to this one: they inherit what is blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
