"""Work in threads: its results, its failures, and its end."""

import threading
from concurrent.futures import Future

import pytest

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import BackgroundTasks, FutureCallbacks

ENOUGH = 30.0
"""No test waits so long unless it fails [s]."""


@pytest.fixture
def errands():
    made = BackgroundTasks()
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


@pytest.fixture
def refusals():
    return []


@pytest.fixture
def answers(qapp, refusals):
    return FutureCallbacks(refusals.append)


def in_a_thread(work):
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def test_an_answer_is_heard_in_the_own_thread(answers, qtbot):
    heard, future = [], Future()
    answers.expect(future, lambda value: heard.append((value, threading.current_thread())))
    in_a_thread(lambda: future.set_result(7))
    qtbot.waitUntil(lambda: bool(heard))
    assert heard == [(7, threading.main_thread())]


def test_an_answer_that_is_there_already_is_heard_later_too(answers, qtbot):
    heard, future = [], Future()
    future.set_result(1)
    answers.expect(future, heard.append)
    assert heard == []
    qtbot.waitUntil(lambda: heard == [1])


def test_a_refusal_goes_to_who_asked_or_to_all(answers, refusals, qtbot):
    own = []
    for refused in (own.append, None):
        future = Future()
        answers.expect(future, None, refused)
        future.set_exception(WorkbenchError("no"))
    qtbot.waitUntil(lambda: own == ["no"] and refusals == ["no"])


def test_after_the_end_nobody_is_called(answers, qtbot):
    heard, future = [], Future()
    answers.expect(future, heard.append)
    future.set_result(1)
    answers.close()
    qtbot.wait(20)
    assert heard == []


def test_a_fault_of_ours_is_no_refusal(answers, refusals, qtbot):
    future = Future()
    answers.expect(future)
    with qtbot.captureExceptions() as caught:
        future.set_exception(ZeroDivisionError())
        qtbot.waitUntil(lambda: bool(caught))
    assert caught[0][0] is ZeroDivisionError and refusals == []
