"""Processes of this machine: what they give back, and what is done when they are killed."""

import logging
import multiprocessing
import threading

import pytest
from far_tasks import Losing, Remarking, Signalled, Square

from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError
from workbench.design.executor import executor
from workbench.design.executor.executor import InThisProcess, LocalProcesses, without_remarks

FOR_EVER = 3600.0


@pytest.mark.parametrize("executor", [InThisProcess(), LocalProcesses(2)])
def test_every_task_is_done_once(executor):
    found = list(executor.run([Square(number) for number in range(8)]))
    assert sorted(found) == [(number, number**2) for number in range(8)]
    assert list(executor.run([])) == []


@pytest.mark.parametrize("executor", [InThisProcess(), LocalProcesses(1)])
def test_a_stop_keeps_what_was_finished(executor):
    found = []
    tasks = [Square(number, seconds=0.02) for number in range(500)]
    for each in executor.run(tasks, stop=lambda: len(found) >= 2):
        found.append(each)
    assert 2 <= len(found) < 500
    assert all(result == index**2 for index, result in found)


@pytest.mark.parametrize("executor", [InThisProcess(), LocalProcesses(1)])
def test_what_a_task_refuses_arrives_as_it_was_said(executor):
    with pytest.raises(WorkbenchError, match="^13 has no square: take another number$"):
        list(executor.run([Square(13)]))


def test_what_a_killed_process_was_at_is_done_again(tmp_path):
    marker = tmp_path / "killed"
    found = list(Losing(LocalProcesses(2), marker).run([Square(n) for n in range(4)]))
    assert marker.exists()
    assert sorted(found) == [(number, number**2) for number in range(4)]


def test_signals_to_end_are_left_to_the_caller():
    """A group of processes gets them, as from a terminal: what flies ends with its caller."""
    assert list(LocalProcesses(1).run([Signalled(3)])) == [(0, 9)]


def test_processes_that_are_killed_too_often_are_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(executor, "MAX_KILLED_PROCESSES", 0)
    with pytest.raises(WorkbenchError, match="ended from outside, 1 times: let fewer fly"):
        list(Losing(LocalProcesses(1), tmp_path / "killed").run([Square(1)]))


def test_remarks_are_left_out_of_one_thread(caplog):
    def remark(text):
        logging.getLogger("workbench").warning(text)

    with without_remarks():
        remark("of this thread")
        logging.getLogger(PROGRESS_LOGGER).warning("how far it is")
        logging.getLogger("workbench").error("an error")
        other = threading.Thread(target=remark, args=("of another",))
        other.start()
        other.join()
    remark("afterwards")
    assert caplog.messages == ["an error", "of another", "afterwards"]


@pytest.mark.parametrize("executor", [InThisProcess(), LocalProcesses(2)])
def test_what_is_logged_there_is_logged_here(executor, caplog):
    """As that the law is compiled, for which a first `regress` waited a minute without a word."""
    list(executor.run([Remarking(number) for number in range(3)]))
    assert sorted(caplog.messages) == ["squaring 0", "squaring 1", "squaring 2"]


def test_who_does_not_want_the_rest_waits_for_none_of_it():
    """As with Ctrl-C: what is being flown would go on for as long as it takes."""
    others = multiprocessing.active_children()
    tasks = [Square(1), Square(2, seconds=FOR_EVER)]
    done = LocalProcesses(2).run(tasks)
    assert next(done) == (0, 1)
    done.close()
    assert set(multiprocessing.active_children()) <= set(others)
