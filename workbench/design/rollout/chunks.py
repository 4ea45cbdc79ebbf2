"""Share out many small pieces of work over threads."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

LARGEST = 2
SHARE = 4
"""Pieces in a chunk at most, and chunks for each thread at least if there are pieces enough: a
few milliseconds each, so that progress is told and a stop is heard."""

Work = Callable[[int, int], None]


def run_chunks(
    work: Work,
    count: int,
    threads: int,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> int:
    """Do `work(first, last)` for pieces 0 .. count; return how many of them, from 0 on, are done.

    Threads help only with work that lets go of Python's lock, as compiled code may.

    Args:
        work: does the pieces from `first` up to before `last`.
        count: of pieces.
        threads: that work at a time, besides the caller's own, which waits; with 1 that works.
        progress: called with the share done, 0 .. 1, by the caller's thread.
        stop: asked after each chunk; chunks that have not begun are left when it says so.
    """
    size = max(1, min(LARGEST, -(-count // (SHARE * threads))))
    chunks = [(first, min(first + size, count)) for first in range(0, count, size)]

    def told(done: int) -> bool:
        if progress:
            progress(done / count)
        return bool(stop and stop())

    if threads == 1 or len(chunks) == 1:
        for first, last in chunks:
            work(first, last)
            if told(last):
                return last
        return count
    todo = deque(chunks)
    begun: deque[tuple[int, Future[None]]] = deque()
    done = 0
    with ThreadPoolExecutor(threads, thread_name_prefix="rollouts") as pool:
        while todo or begun:
            while todo and len(begun) <= threads:  # one waits, so that no thread does
                first, last = todo.popleft()
                begun.append((last, pool.submit(work, first, last)))
            done, chunk = begun.popleft()
            chunk.result()
            if told(done):
                todo.clear()
    return done
