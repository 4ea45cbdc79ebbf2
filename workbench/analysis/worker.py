"""An analyst's process: `python -m workbench.analysis.worker FD`, a socket to the caller.

It exits when its caller's end of the socket closes, whatever it is doing.
"""

import importlib
import logging
import os
import sys
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from workbench.analysis.queries import ANSWERED_BY, OtherControllerQuery, place_of_answer
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import RequestQueue, Work, Working
from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError
from workbench.ipc.send_queue import LogSender, SendQueue
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult

WORK_SLICE_S = 0.005
"""Time after which work pauses, if it can, for the next kind of question [s]."""
Answerer = Callable[[AnalysedVehicle, Any, Work], Working]


class Scheduler:
    """Answers questions, one of each kind at a time, in turns.

    With turns, a map and ranges are drawn although a moving slider asks for margins all the time;
    with time slices, margins do not wait for a whole map.

    Args:
        subject: subject of the questions.
        requests: queue of waiting questions.
        send_queue: takes answers.
        find: returns the function that answers a kind of question.
    """

    def __init__(
        self,
        subject: AnalysedVehicle,
        requests: RequestQueue,
        send_queue: SendQueue,
        find: Callable[[type], Answerer],
    ) -> None:
        self._subject = subject
        self._requests = requests
        self._send_queue = send_queue
        self._find = find
        self._begun: dict[type, tuple[WorkerRequest, Working]] = {}

    def run(self) -> None:
        """Answer until the process ends."""
        while True:
            self._take_in(wait=not self._begun)
            self.turn()

    def turn(self) -> None:
        """Give every kind one turn."""
        for kind in (*ANSWERED_BY, *(each for each in self._begun if each not in ANSWERED_BY)):
            self._take_in(wait=False)
            if kind in self._begun:
                self._go_on(kind)

    def _take_in(self, *, wait: bool) -> None:
        """Begin new questions, of kinds that are not in progress."""
        for request in self._requests.take(set(self._begun), wait):
            work = Work(request.number, self._requests, self._send_queue)
            self._begun[type(request.what)] = request, self._work(request, work)

    def _work(self, request: WorkerRequest, work: Work) -> Working:
        """Work on a question; its function is looked up here, because that may load a library."""
        work.check()
        yield from self._find(type(request.what))(self._subject, request.what, work)

    def _go_on(self, kind: type) -> None:
        """Work on a kind for one time slice."""
        request, working = self._begun[kind]
        end = time.perf_counter() + WORK_SLICE_S
        reply = None
        try:
            while reply is None and time.perf_counter() < end:
                reply = next(working)
        except WorkbenchError as error:
            self._answer(kind, WorkerRefusal(request.number, str(error)))
        except (Exception, SystemExit) as error:  # Drake's failed assertions are SystemExit
            said = f"the analyst failed: {type(error).__name__}: {' '.join(str(error).split())}"
            self._answer(kind, WorkerRefusal(request.number, said))
        else:
            if reply is not None:
                self._answer(kind, WorkerResult(request.number, reply))

    def _answer(self, kind: type, answer: WorkerResult | WorkerRefusal) -> None:
        del self._begun[kind]
        self._send_queue.post(answer)


def main(connection: Connection) -> int:
    """Answer questions, and return the exit code.

    The first message has the scenario of the vehicle, parameter values that override those of its
    gains, and an increase of the process's niceness.
    """
    try:
        scenario, settings, niceness = connection.recv()
    except (EOFError, OSError):
        return 0
    os.nice(niceness)
    send_queue = SendQueue(connection)
    logging.getLogger(PROGRESS_LOGGER).addHandler(LogSender(send_queue, str))
    requests = RequestQueue(connection, send_queue)
    subject = AnalysedVehicle(scenario, settings)
    Scheduler(subject, requests, send_queue, find_answerer).run()
    return 0


def find_answerer(kind: type) -> Answerer:
    """Return the function that answers a kind of question."""
    if kind is OtherControllerQuery:
        return answer_with_other_law
    place = place_of_answer(kind)
    assert place is not None  # the caller asks nothing else
    module, name = place[1].split(":")
    found: Answerer = getattr(importlib.import_module(module), name)
    return found


def answer_with_other_law(
    subject: AnalysedVehicle, question: OtherControllerQuery, work: Work
) -> Working:
    """Answer a question about another controller, on the same vehicle.

    The first question builds its models and the machine code of its flights.
    """
    other = subject.other(question.controller)
    yield from find_answerer(type(question.question))(other, question.question, work)


if __name__ == "__main__":
    os._exit(main(Connection(int(sys.argv[1]))))
