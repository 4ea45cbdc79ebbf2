"""What is kept of what is asked."""

import threading
from multiprocessing import Pipe

import pytest

from workbench.analysis.queries import Judge, Predict, RequestedStep, StopQueries
from workbench.analysis.work import RequestQueue
from workbench.ipc.worker_process import Superseded, WorkerRequest

ENOUGH = 300.0


class Told:
    """A send queue that keeps what is said."""

    def __init__(self):
        self.posted = []

    def post(self, message):
        self.posted.append(message)


@pytest.fixture
def connected():
    here, there = Pipe()
    told, gone = Told(), threading.Event()
    requests = RequestQueue(there, told, gone.set)
    yield here, requests, told
    here.close()
    assert gone.wait(ENOUGH), "the caller is gone, and nobody ends"
    there.close()


def test_of_an_asker_and_a_kind_the_newest_is_kept_and_the_others_are_told_of(connected):
    here, requests, told = connected
    judge = [WorkerRequest(number, Judge({"kp_roll": number})) for number in (1, 2, 3)]
    other = WorkerRequest(4, Judge({"kp_roll": 0.0}, asker=1))
    predict = WorkerRequest(5, Predict({}, RequestedStep("x", 1.0, 1.0)))
    for request in (judge[0], other, *judge[1:], predict):
        here.send(request)
    found = []
    while len(found) < 3:
        found += requests.take({Judge}, wait=not found)
        if found:  # all that came before it was heard
            found += requests.take(set(), wait=False)
    assert found == [predict, other, judge[-1]]  # of a kind the one that waits longest
    assert told.posted == [Superseded(1), Superseded(2)]


def test_a_stop_is_heard_while_nobody_takes(connected):
    here, requests, _ = connected
    first, second = threading.Event(), threading.Event()
    requests.on_stop(3, first.set)
    here.send(StopQueries(2))
    here.send(StopQueries(3))
    assert first.wait(ENOUGH)
    assert requests.stopped == 3
    requests.on_stop(3, second.set)  # it came before it was asked to be told
    assert second.is_set()
