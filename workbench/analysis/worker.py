"""An analyst's process: `python -m workbench.analysis.worker FD`, a socket to the caller.

It ends when its caller's end of the socket does, whatever it is doing.
"""

import importlib
import logging
import os
import sys
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from workbench.analysis.questions import ANSWERED_BY, AskOther
from workbench.analysis.replies import OtherAnswered
from workbench.analysis.subject import Subject
from workbench.analysis.work import RequestQueue, Work, Working
from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError
from workbench.ipc.send_queue import LogPoster, SendQueue
from workbench.ipc.worker_process import Answer, Refusal, Request

SLICE = 0.005
"""After this time a kind pauses, where it can, for the next one [s]."""
Answerer = Callable[[Subject, Any, Work], Working]


class Scheduler:
    """Answers what is asked, one question of each kind at a time, each kind in its turn.

    In turns, so that a map and ranges are drawn although a slider that never rests asks for
    margins all the time; in slices, so that margins do not wait for a whole map.

    Args:
        subject: about which is asked.
        requests: questions that wait.
        send_queue: where answers go.
        find: returns who answers a kind of question.
    """

    def __init__(
        self,
        subject: Subject,
        requests: RequestQueue,
        send_queue: SendQueue,
        find: Callable[[type], Answerer],
    ) -> None:
        self._subject = subject
        self._requests = requests
        self._send_queue = send_queue
        self._find = find
        self._begun: dict[type, tuple[Request, Working]] = {}

    def run(self) -> None:
        """Answer until the process ends."""
        while True:
            self._take_in(wait=not self._begun)
            self.turn()

    def turn(self) -> None:
        """Give every kind its turn."""
        for kind in ANSWERED_BY:
            self._take_in(wait=False)
            if kind in self._begun:
                self._go_on(kind)

    def _take_in(self, *, wait: bool) -> None:
        """Begin new questions, of kinds that are not in progress."""
        for request in self._requests.take(set(self._begun), wait):
            work = Work(request.number, self._requests, self._send_queue)
            self._begun[type(request.what)] = request, self._work(request, work)

    def _work(self, request: Request, work: Work) -> Working:
        """Work on a question; its function is looked up here, as that may load a library."""
        work.check()
        yield from self._find(type(request.what))(self._subject, request.what, work)

    def _go_on(self, kind: type) -> None:
        """Work on a kind for a slice of time."""
        request, working = self._begun[kind]
        end = time.perf_counter() + SLICE
        reply = None
        try:
            while reply is None and time.perf_counter() < end:
                reply = next(working)
        except WorkbenchError as error:
            self._answer(kind, Refusal(request.number, str(error)))
        except (Exception, SystemExit) as error:  # Drake's failed assertions are SystemExit
            said = f"the analyst failed: {type(error).__name__}: {' '.join(str(error).split())}"
            self._answer(kind, Refusal(request.number, said))
        else:
            if reply is not None:
                self._answer(kind, Answer(request.number, reply))

    def _answer(self, kind: type, answer: Answer | Refusal) -> None:
        del self._begun[kind]
        self._send_queue.post(answer)


def main(connection: Connection) -> int:
    """Answer what is asked, and return the exit code.

    The first message is the scenario whose vehicle is judged, the values of its live parameters
    over those of its gains, and what is added to the niceness of the process.
    """
    try:
        scenario, settings, niceness = connection.recv()
    except (EOFError, OSError):
        return 0
    os.nice(niceness)
    send_queue = SendQueue(connection)
    logging.getLogger(PROGRESS_LOGGER).addHandler(LogPoster(send_queue, str))
    requests = RequestQueue(connection, send_queue)
    subject = Subject(scenario, settings)
    Scheduler(subject, requests, send_queue, find_answerer).run()
    return 0


def find_answerer(kind: type) -> Answerer:
    """Return the function that answers a kind of question."""
    if kind is AskOther:
        return ask_other
    file, name = ANSWERED_BY[kind][1].split(":")
    found: Answerer = getattr(importlib.import_module(f"workbench.analysis.{file}"), name)
    return found


def ask_other(subject: Subject, question: AskOther, work: Work) -> Working:
    """Answer a question about another controller, on the same vehicle.

    Its models, and the machine code of its flights, are made at the first question about it.
    """
    other = subject.other(question.controller)
    for reply in find_answerer(type(question.question))(other, question.question, work):
        yield None if reply is None else OtherAnswered(question, reply)


if __name__ == "__main__":
    os._exit(main(Connection(int(sys.argv[1]))))
