"""An outbox over a real pipe; where nobody reads, it must neither wait nor grow."""

from multiprocessing import Pipe

import pytest

from workbench.live.send_queue import SendQueue

ENOUGH = 30.0
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
    outbox = SendQueue(pipe[0])
    for number in range(1000):
        outbox.post(number)
    assert received(pipe[1], 999) == list(range(1000))
    outbox.close(ENOUGH)


def test_of_what_is_shown_to_nobody_only_the_newest_is_kept(pipe):
    outbox = SendQueue(pipe[0])
    outbox.post(LARGE)
    for number in range(10_000):
        outbox.show(number)
    found = received(pipe[1], 9999)
    assert found[0] == LARGE
    assert len(found) == 2
    outbox.close(ENOUGH)


def test_what_is_shown_before_a_message_arrives_before_it(pipe):
    outbox = SendQueue(pipe[0])
    outbox.post(LARGE)
    outbox.show("old")
    outbox.show("before")
    outbox.post("answer")
    outbox.show("after")
    assert received(pipe[1], "after")[1:] == ["before", "answer", "after"]
    outbox.close(ENOUGH)


def test_a_message_is_copied_when_it_is_posted(pipe):
    outbox = SendQueue(pipe[0])
    message = ["then"]
    outbox.post(LARGE)
    outbox.post(message)
    message[0] = "now"
    assert received(pipe[1], ["then"])
    outbox.close(ENOUGH)


def test_closing_sends_what_waits_and_ends_although_nobody_reads(pipe):
    outbox = SendQueue(pipe[0])
    outbox.post("last")
    outbox.close(ENOUGH)
    assert received(pipe[1], "last")
    outbox = SendQueue(pipe[0])
    outbox.post(LARGE)
    outbox.close(0.01)
    pipe[1].close()


def test_a_reader_that_is_gone_is_no_failure(pipe):
    outbox = SendQueue(pipe[0])
    pipe[1].close()
    for number in range(100):
        outbox.post(number)
        outbox.show(number)
    outbox.close(ENOUGH)
