"""The order in which questions are worked on, with answerers of the test's own."""

import time
from collections import deque

import pytest

from workbench.analysis.queries import DrawMap, FindRanges, Judge, Predict, RequestedStep
from workbench.analysis.worker import Scheduler
from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult

STEP = RequestedStep("x", 1.0, 1.0)


class Queues:
    """A request queue and a send queue in one."""

    stopped = 0

    def __init__(self):
        self.asked = deque()
        self.posted = []

    def take(self, kinds, wait):
        taken = [request for request in self.asked if type(request.what) not in kinds]
        self.asked = deque(request for request in self.asked if request not in taken)
        return taken

    def post(self, message):
        self.posted.append(message)


@pytest.fixture
def queues():
    return Queues()


def scheduler(queues, answerers):
    return Scheduler(None, queues, queues, answerers.__getitem__)


def at_once(_subject, question, _work):
    yield ("done", question)


def slowly(_subject, question, _work):
    for _ in range(40):
        time.sleep(0.001)
        yield None
    yield ("done", question)


def test_margins_come_between_the_slices_of_a_map(queues):
    judge = [WorkerRequest(number, Judge({})) for number in range(2, 6)]
    queues.asked.extend([WorkerRequest(1, DrawMap({}, "a", "b", "c", STEP)), judge[0]])
    worked = scheduler(queues, {DrawMap: slowly, Judge: at_once})
    for request in judge[1:]:
        worked.turn()
        queues.asked.append(request)
    assert [answer.number for answer in queues.posted] == [2, 3, 4]
    for _ in range(20):
        worked.turn()
    assert [answer.number for answer in queues.posted] == [2, 3, 4, 5, 1]


def test_a_map_is_drawn_although_margins_are_asked_for_all_the_time(queues):
    queues.asked.append(WorkerRequest(0, DrawMap({}, "a", "b", "c", STEP)))
    worked = scheduler(queues, {DrawMap: slowly, Judge: at_once})
    for number in range(1, 30):
        queues.asked.append(WorkerRequest(number, Judge({})))
        worked.turn()
    assert 0 in [answer.number for answer in queues.posted]


def test_the_urgent_ones_come_first(queues):
    asked = [FindRanges({}), DrawMap({}, "a", "b", "c", STEP), Predict({}, STEP), Judge({})]
    queues.asked.extend(WorkerRequest(number, question) for number, question in enumerate(asked))
    scheduler(queues, dict.fromkeys(map(type, asked), at_once)).turn()
    assert [answer.number for answer in queues.posted] == [3, 2, 1, 0]


def test_whatever_fails_is_a_sentence_and_the_next_is_answered(queues):
    def refuse(*_):
        raise WorkbenchError("no such gain")
        yield

    def fail(*_):
        yield None
        raise SystemExit("abort: failure at x.cc:1\n in Linearize()")

    queues.asked.extend(
        [
            WorkerRequest(1, Judge({})),
            WorkerRequest(2, Predict({}, STEP)),
            WorkerRequest(3, FindRanges({})),
        ]
    )
    scheduler(queues, {Judge: refuse, Predict: fail, FindRanges: at_once}).turn()
    failed = "the analyst failed: SystemExit: abort: failure at x.cc:1 in Linearize()"
    assert queues.posted == [
        WorkerRefusal(1, "no such gain"),
        WorkerRefusal(2, failed),
        WorkerResult(3, ("done", FindRanges({}))),
    ]


def test_what_was_stopped_before_it_was_begun_is_not_begun(queues):
    queues.stopped = 7
    queues.asked.extend([WorkerRequest(7, Judge({}))])
    scheduler(queues, {}).turn()
    assert queues.posted == [WorkerRefusal(7, "it was stopped before it was done")]
