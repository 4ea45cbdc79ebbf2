"""A send queue over a real pipe; where nobody reads, it must neither wait nor grow."""

import threading
from multiprocessing import Pipe

import pytest

from workbench.ipc.send_queue import SendQueue

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
LARGE = b"x" * 1_000_000
"""More than a pipe takes, so that sending it waits for a reader."""


@pytest.fixture
def pipe():
    here, there = Pipe()
    yield here, there
    here.close()
    there.close()


def received(connection, last):
    """Return all messages up to one."""
    found = []
    while not found or found[-1] != last:
        assert connection.poll(ENOUGH), f"nothing more came after {found}"
        found.append(connection.recv())
    return found


def test_messages_arrive_in_their_order(pipe):
    queue = SendQueue(pipe[0])
    for number in range(1000):
        queue.post(number)
    assert received(pipe[1], 999) == list(range(1000))
    queue.close(ENOUGH)


def test_a_short_message_waits_for_no_thread(pipe, monkeypatch):
    monkeypatch.setattr(threading.Thread, "start", lambda thread: None)
    queue = SendQueue(pipe[0])
    queue.post("first")
    queue.post("second")
    queue.post(LARGE)
    queue.post("behind the large one")
    assert [pipe[1].recv() for _ in range(2)] == ["first", "second"]
    assert not pipe[1].poll()


def test_of_what_is_shown_to_nobody_only_the_newest_is_kept(pipe):
    queue = SendQueue(pipe[0])
    queue.post(LARGE)
    for number in range(10_000):
        queue.show(number)
    found = received(pipe[1], 9999)
    assert found[0] == LARGE
    assert len(found) == 2
    queue.close(ENOUGH)


def test_what_is_shown_before_a_message_arrives_before_it(pipe):
    queue = SendQueue(pipe[0])
    queue.post(LARGE)
    queue.show("old")
    queue.show("before")
    queue.post("answer")
    queue.show("after")
    assert received(pipe[1], "after")[1:] == ["before", "answer", "after"]
    queue.close(ENOUGH)


def test_a_message_is_copied_when_it_is_posted(pipe):
    queue = SendQueue(pipe[0])
    message = ["then"]
    queue.post(LARGE)
    queue.post(message)
    message[0] = "now"
    assert received(pipe[1], ["then"])
    queue.close(ENOUGH)


def test_closing_sends_what_waits_and_ends_although_nobody_reads(pipe):
    queue = SendQueue(pipe[0])
    queue.post("last")
    queue.close(ENOUGH)
    assert received(pipe[1], "last")
    queue = SendQueue(pipe[0])
    queue.post(LARGE)
    queue.close(0.01)
    pipe[1].close()


def test_a_reader_that_is_gone_is_no_failure(pipe):
    queue = SendQueue(pipe[0])
    pipe[1].close()
    for number in range(100):
        queue.post(number)
        queue.show(number)
    queue.close(ENOUGH)
