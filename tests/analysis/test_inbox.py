"""What is kept of what is asked."""

import threading
from multiprocessing import Pipe

import pytest

from workbench.analysis.inbox import Inbox
from workbench.analysis.messages import Ask, Stop, Superseded
from workbench.analysis.questions import Judge, Predict, Step

ENOUGH = 30.0


class Told:
    """An outbox that keeps what is said."""

    def __init__(self):
        self.posted = []

    def post(self, message):
        self.posted.append(message)


@pytest.fixture
def line():
    here, there = Pipe()
    told, gone = Told(), threading.Event()
    inbox = Inbox(there, told, gone.set)
    yield here, inbox, told
    here.close()
    assert gone.wait(ENOUGH), "the caller is gone, and nobody ends"
    there.close()


def test_of_a_kind_the_newest_is_kept_and_the_others_are_told_of(line):
    here, inbox, told = line
    predict = Ask(4, Predict({}, Step("x", 1.0, 1.0)))
    for ask in (*(Ask(number, Judge({"kp_roll": number})) for number in (1, 2, 3)), predict):
        here.send(ask)
    found = []
    while len(found) < 2:
        found += inbox.take({Judge}, wait=not found)
        if found:  # all that came before it was heard
            found += inbox.take(set(), wait=False)
    assert found == [predict, Ask(3, Judge({"kp_roll": 3}))]
    assert told.posted == [Superseded(1), Superseded(2)]


def test_a_stop_is_heard_while_nobody_takes(line):
    here, inbox, _ = line
    first, second = threading.Event(), threading.Event()
    inbox.on_stop(3, first.set)
    here.send(Stop(2))
    here.send(Stop(3))
    assert first.wait(ENOUGH)
    assert inbox.stopped == 3
    inbox.on_stop(3, second.set)  # it came before it was asked to be told
    assert second.is_set()
