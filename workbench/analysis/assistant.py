"""One of an analyst's processes, begun when it is first needed and again when it has died."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from typing import Any

from workbench.analysis.line import CLOSED, Line
from workbench.analysis.messages import Begin, Preparing
from workbench.analysis.questions import Question
from workbench.analysis.replies import Searched
from workbench.common.errors import WorkbenchError
from workbench.live.flight import failed

MOST_DEATHS = 3
"""So many processes in a row may end without an answer; then no further one is begun."""


class Assistant:
    """Answers questions in a process of its own; only its begin and `close` take time.

    Args:
        begin: what every process is told first.
        progressed: called with a `Searched` or a `Preparing`, in another thread.
    """

    def __init__(self, begin: Begin, progressed: Callable[[Searched | Preparing], None]) -> None:
        self._begin = begin
        self._progressed = progressed
        self._lock = threading.Lock()
        self._line: Line | None = None
        self._deaths = 0
        self._last = ""
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Number of the process, None before the first."""
        return self._line.pid if self._line else None

    @property
    def has_given_up(self) -> bool:
        """Whether no further process is begun, as too many have ended."""
        return self._deaths >= MOST_DEATHS

    def ask(self, question: Question) -> "Future[Any]":
        """Ask, and return what the reply will be; a process is begun if there is none."""
        try:
            return self._lived().ask(question) or self._lived().ask(question) or failed(CLOSED)
        except WorkbenchError as error:
            return failed(str(error))

    def warm_up(self) -> None:
        """Begin the process, so that the first question need not wait for that."""
        with suppress(WorkbenchError):  # which the first question will be told
            self._lived()

    def stop(self) -> None:
        """End what was asked so far; a search keeps its best."""
        line = self._line
        if line is not None and not line.ended:
            line.stop()

    def close(self) -> None:
        """Kill the process, and begin no further one."""
        with self._lock:
            self._closed = True
            line = self._line
        if line is not None:
            line.close()

    def _lived(self) -> Line:
        """Return a line to a process that lives, as far as is known.

        Raises:
            WorkbenchError: if there is none.
        """
        with self._lock:
            if self._closed:
                raise WorkbenchError(CLOSED)
            line = self._line
            if line is not None and line.ended:
                self._deaths = 1 if line.answered else self._deaths + 1
                self._line = None
                if self.has_given_up:
                    self._last = line.ended
            if self.has_given_up:
                raise WorkbenchError(
                    f"the analyst has failed {MOST_DEATHS} times: {self._last}: open the "
                    "scenario again"
                )
            if self._line is None:
                self._line = Line(self._begin, self._progressed)
            return self._line
