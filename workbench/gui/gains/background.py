"""Work on files that no slot may wait for."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any


class Background:
    """Runs work in short-lived threads."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def run(self, work: Callable[[], Any]) -> "Future[Any]":
        """Begin work, and return what its result will be."""
        future: Future[Any] = Future()
        self._threads = [each for each in self._threads if each.is_alive()]
        thread = threading.Thread(target=_work, args=(work, future), name="gain file")
        self._threads.append(thread)
        thread.start()
        return future

    def close(self) -> None:
        """Wait until all is done; the last call."""
        for thread in self._threads:
            thread.join()


def _work(work: Callable[[], Any], future: "Future[Any]") -> None:
    try:
        result = work()
    except Exception as error:  # whoever asked is told
        future.set_exception(error)
    else:
        future.set_result(result)
