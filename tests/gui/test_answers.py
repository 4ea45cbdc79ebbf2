"""Answers of other threads are heard in the thread of the screens."""

import threading
from concurrent.futures import Future

import pytest

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import Answers


@pytest.fixture
def refusals():
    return []


@pytest.fixture
def answers(qapp, refusals):
    return Answers(refusals.append)


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
