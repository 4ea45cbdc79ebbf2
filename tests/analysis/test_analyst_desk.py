"""The order in which questions are worked on, with answerers of the test's own."""

import time
from collections import deque

import pytest

from workbench.analysis.desk import Desk
from workbench.analysis.messages import Answered, Ask, Refused
from workbench.analysis.questions import DrawMap, FindRanges, Judge, Predict, Step
from workbench.common.errors import WorkbenchError

STEP = Step("x", 1.0, 1.0)


class Box:
    """An inbox and an outbox in one."""

    stopped = 0

    def __init__(self):
        self.asked = deque()
        self.posted = []

    def take(self, kinds, wait):
        taken = [ask for ask in self.asked if type(ask.question) not in kinds]
        self.asked = deque(ask for ask in self.asked if ask not in taken)
        return taken

    def post(self, message):
        self.posted.append(message)


@pytest.fixture
def box():
    return Box()


def desk(box, answerers):
    return Desk(None, box, box, answerers.__getitem__)


def at_once(_subject, question, _work):
    yield ("done", question)


def slowly(_subject, question, _work):
    for _ in range(40):
        time.sleep(0.001)
        yield None
    yield ("done", question)


def test_margins_come_between_the_slices_of_a_map(box):
    judge = [Ask(number, Judge({})) for number in range(2, 6)]
    box.asked.extend([Ask(1, DrawMap({}, "a", "b", "c", STEP)), judge[0]])
    worked = desk(box, {DrawMap: slowly, Judge: at_once})
    for ask in judge[1:]:
        worked.turn()
        box.asked.append(ask)
    assert [answer.number for answer in box.posted] == [2, 3, 4]
    for _ in range(20):
        worked.turn()
    assert [answer.number for answer in box.posted] == [2, 3, 4, 5, 1]


def test_a_map_is_drawn_although_margins_are_asked_for_all_the_time(box):
    box.asked.append(Ask(0, DrawMap({}, "a", "b", "c", STEP)))
    worked = desk(box, {DrawMap: slowly, Judge: at_once})
    for number in range(1, 30):
        box.asked.append(Ask(number, Judge({})))
        worked.turn()
    assert 0 in [answer.number for answer in box.posted]


def test_the_urgent_ones_come_first(box):
    asked = [FindRanges({}), DrawMap({}, "a", "b", "c", STEP), Predict({}, STEP), Judge({})]
    box.asked.extend(Ask(number, question) for number, question in enumerate(asked))
    desk(box, dict.fromkeys(map(type, asked), at_once)).turn()
    assert [answer.number for answer in box.posted] == [3, 2, 1, 0]


def test_whatever_fails_is_a_sentence_and_the_next_is_answered(box):
    def refuse(*_):
        raise WorkbenchError("no such gain")
        yield

    def fail(*_):
        yield None
        raise SystemExit("abort: failure at x.cc:1\n in Linearize()")

    box.asked.extend([Ask(1, Judge({})), Ask(2, Predict({}, STEP)), Ask(3, FindRanges({}))])
    desk(box, {Judge: refuse, Predict: fail, FindRanges: at_once}).turn()
    failed = "the analyst failed: SystemExit: abort: failure at x.cc:1 in Linearize()"
    assert box.posted == [
        Refused(1, "no such gain"),
        Refused(2, failed),
        Answered(3, ("done", FindRanges({}))),
    ]


def test_what_was_stopped_before_it_was_begun_is_not_begun(box):
    box.stopped = 7
    box.asked.extend([Ask(7, Judge({}))])
    desk(box, {}).turn()
    assert box.posted == [Refused(7, "it was stopped before it was done")]
