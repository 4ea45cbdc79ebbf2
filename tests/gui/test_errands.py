"""Work in threads: its results, its failures, and its end."""

import threading

import pytest

from workbench.gui.errands import Errands

ENOUGH = 30.0
"""No test waits so long unless it fails [s]."""


@pytest.fixture
def errands():
    made = Errands()
    yield made
    made.close()


def test_a_result_and_a_failure_are_the_askers(errands):
    assert errands.run(lambda: 3).result(ENOUGH) == 3
    with pytest.raises(ZeroDivisionError):
        errands.run(lambda: 1 / 0).result(ENOUGH)


def test_what_nobody_asked_about_does_not_fail_in_silence(errands, monkeypatch):
    shown = []
    monkeypatch.setattr(threading, "excepthook", lambda each: shown.append(each.exc_type))
    errands.do(lambda: 1 / 0)
    errands.close()
    assert shown == [ZeroDivisionError]


def test_the_end_waits_for_all(errands):
    go_on, done = threading.Event(), []
    for number in range(3):
        errands.do(lambda number=number: (go_on.wait(ENOUGH), done.append(number)))
    assert done == []
    go_on.set()
    errands.close()
    assert sorted(done) == [0, 1, 2]
