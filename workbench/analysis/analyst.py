"""An analyst as its caller sees it: questions that never wait, and replies that come later."""

import copy
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from workbench.analysis.assistant import Assistant
from workbench.analysis.line import CLOSED
from workbench.analysis.messages import Begin, Preparing
from workbench.analysis.questions import (
    DrawMap,
    FindRanges,
    Fork,
    Judge,
    Pin,
    Predict,
    Question,
    Tune,
    Weigh,
)
from workbench.analysis.replies import Searched
from workbench.live.flight import failed
from workbench.scenario.scenario import Scenario

QUICK = (Judge, Predict, DrawMap, FindRanges)
"""What is answered while a slider moves, by a process of its own."""
SLOW = (Fork, Weigh, Pin)
"""What takes seconds."""
LONG = (Tune,)
"""What takes minutes, for which nothing else is to wait."""
QUICK_NICENESS, SLOW_NICENESS = 3, 10
"""A flight beside them must keep its time."""


def _ignore(_: Searched | Preparing) -> None:
    """Tell nobody."""


class Analyst:
    """Judges gains of a scenario's vehicle beside its flight, in three processes.

    One is quick, one is slow, and one searches. Each is started at its first question, and again at
    the next one after it has died. No method but `close` ever waits.

    Args:
        scenario: whose vehicle is judged, with its variation and rates; where a whole flight is
            flown, all of it counts.
        settings: values of the live parameters, over those of the scenario's gains.
        progress: called with a `Searched` or a `Preparing`, in a thread of this analyst's.
    """

    def __init__(
        self,
        scenario: Scenario,
        settings: Mapping[str, float],
        progress: Callable[[Searched | Preparing], None] = _ignore,
    ) -> None:
        self.scenario = copy.deepcopy(scenario)
        self.settings = dict(settings)
        self._quick, self._slow, self._searching = (
            Assistant(Begin(self.scenario, self.settings, niceness), progress)
            for niceness in (QUICK_NICENESS, SLOW_NICENESS, SLOW_NICENESS)
        )
        self._lock = threading.Lock()
        self._closed = False
        # To start a process takes ten milliseconds, more than a screen may wait.
        self._clerk = ThreadPoolExecutor(1, thread_name_prefix="analyst's clerk")

    @property
    def pids(self) -> tuple[int | None, int | None, int | None]:
        """Numbers of the quick, slow and searching process, None before they are started."""
        return self._quick.pid, self._slow.pid, self._searching.pid

    @property
    def has_given_up(self) -> bool:
        """Whether a process died so often that questions to it are refused from now on."""
        assistants = (self._quick, self._slow, self._searching)
        return any(each.has_given_up for each in assistants)

    def ask(self, question: Question) -> "Future[Any]":
        """Ask; the Future has the reply, or a WorkbenchError that says why there is none.

        Of each kind the newest question counts: one that still waits when it comes fails with a
        `SupersededError`; one that is being worked on is answered, so that a screen can follow a
        slider that never rests.
        """
        if isinstance(question, QUICK):
            return self._pass_on(self._quick, question)
        if isinstance(question, SLOW):
            return self._pass_on(self._slow, question)
        if isinstance(question, LONG):
            return self._pass_on(self._searching, question)
        return failed(f"{question!r:.60} is no question: ask one of workbench.analysis.questions")

    def warm_up(self) -> None:
        """Start the quick and the slow process, so that the first questions find them ready."""
        self._give(self._quick.warm_up)
        self._give(self._slow.warm_up)

    def stop(self) -> None:
        """End a search soon, and keep its best."""
        self._give(self._searching.stop)

    def close(self) -> None:
        """Kill the processes, and wait until they are gone; the last call."""
        with self._lock:
            self._closed = True
        self._clerk.shutdown()
        self._quick.close()
        self._slow.close()
        self._searching.close()

    def _pass_on(self, assistant: Assistant, question: Question) -> "Future[Any]":
        """Let a question be asked, and return what the reply will be."""
        reply: Future[Any] = Future()
        reply.set_running_or_notify_cancel()  # from now on it cannot be cancelled
        if not self._give(lambda: assistant.ask(question).add_done_callback(_copy_to(reply))):
            return failed(CLOSED)
        return reply

    def _give(self, act: Callable[[], None]) -> bool:
        """Let the clerk do something, in the order of what is given; return whether it will."""
        with self._lock:
            if not self._closed:
                self._clerk.submit(act)
            return not self._closed


def _copy_to(reply: "Future[Any]") -> "Callable[[Future[Any]], None]":
    """Return what gives a Future what another one came to."""

    def copy_result(done: "Future[Any]") -> None:
        error = done.exception()
        if error is not None:
            reply.set_exception(error)
        else:
            reply.set_result(done.result())

    return copy_result
