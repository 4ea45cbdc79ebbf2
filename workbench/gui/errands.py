"""Work that no slot may wait for, such as on files and on what takes a while to end."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import TypeVar

Value = TypeVar("Value")


class Errands:
    """Runs each piece of work in a short-lived thread of its own."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def run(self, work: Callable[[], Value]) -> "Future[Value]":
        """Begin work, and return what its result will be."""
        future: Future[Value] = Future()
        self.do(partial(_work, work, future))
        return future

    def do(self, work: Callable[[], object]) -> None:
        """Begin work without a result; what it raises is a fault of ours, and shown as such."""
        self._threads = [each for each in self._threads if each.is_alive()]
        thread = threading.Thread(target=work, name="errand")
        self._threads.append(thread)
        thread.start()

    def close(self) -> None:
        """Wait until all is done; the last call."""
        for thread in self._threads:
            thread.join()


def _work(work: Callable[[], Value], future: "Future[Value]") -> None:
    try:
        result = work()
    except Exception as error:  # whoever asked is told
        future.set_exception(error)
    else:
        future.set_result(result)
