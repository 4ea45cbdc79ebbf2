"""Where questions are worked on: in turns, the urgent ones first, the long ones in slices."""

import time
from collections.abc import Callable
from typing import Any

from workbench.analysis.inbox import Inbox
from workbench.analysis.messages import Answered, Ask, Refused
from workbench.analysis.questions import (
    DrawMap,
    FindRanges,
    Fork,
    Judge,
    Pin,
    Predict,
    Tune,
    Weigh,
)
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.common.errors import WorkbenchError
from workbench.ipc.send_queue import SendQueue

ORDER = (Judge, Predict, Fork, DrawMap, FindRanges, Weigh, Tune, Pin)
"""The kinds of questions, the most urgent first."""
SLICE = 0.005
"""A kind gives way to the next one after this long, where it can rest [s]."""

Answerer = Callable[[Subject, Any, Work], Working]


class Desk:
    """Answers what is asked, one question of each kind at a time, each kind in its turn.

    In turns, so that a map and ranges are drawn although a slider that never rests asks for
    margins all the time; in slices, so that margins do not wait for a whole map.

    Args:
        subject: about which is asked.
        inbox: where questions come in.
        outbox: where answers go out.
        find: returns who answers a kind of question.
    """

    def __init__(
        self, subject: Subject, inbox: Inbox, outbox: SendQueue, find: Callable[[type], Answerer]
    ) -> None:
        self._subject = subject
        self._inbox = inbox
        self._outbox = outbox
        self._find = find
        self._begun: dict[type, tuple[Ask, Working]] = {}

    def run(self) -> None:
        """Answer until the process ends."""
        while True:
            self._take_in(wait=not self._begun)
            self.turn()

    def turn(self) -> None:
        """Give every kind its turn."""
        for kind in ORDER:
            self._take_in(wait=False)
            if kind in self._begun:
                self._go_on(kind)

    def _take_in(self, *, wait: bool) -> None:
        """Begin what is asked, of kinds that are not being worked on."""
        for ask in self._inbox.take(set(self._begun), wait):
            work = Work(ask.number, self._inbox, self._outbox)
            self._begun[type(ask.question)] = ask, self._work(ask, work)

    def _work(self, ask: Ask, work: Work) -> Working:
        """Work on a question; who answers it is looked up now, as that may load a library."""
        work.check()
        yield from self._find(type(ask.question))(self._subject, ask.question, work)

    def _go_on(self, kind: type) -> None:
        """Work on a kind for a slice of time."""
        ask, working = self._begun[kind]
        end = time.perf_counter() + SLICE
        reply = None
        try:
            while reply is None and time.perf_counter() < end:
                reply = next(working)
        except WorkbenchError as error:
            self._answer(kind, Refused(ask.number, str(error)))
        except (Exception, SystemExit) as error:  # Drake's failed assertions are SystemExit
            said = f"the analyst failed: {type(error).__name__}: {' '.join(str(error).split())}"
            self._answer(kind, Refused(ask.number, said))
        else:
            if reply is not None:
                self._answer(kind, Answered(ask.number, reply))

    def _answer(self, kind: type, answer: Answered | Refused) -> None:
        del self._begun[kind]
        self._outbox.post(answer)
