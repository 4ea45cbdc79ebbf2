"""The queue to a flight that stands still, record by record."""

import pytest

from workbench.link.backplane import Command, Gone, ReleaseControl, RequestControl, ServerStatus
from workbench.link.server.waiting import Waiting


def command(peer, seq):
    return Command(peer, seq, 0, 7, 15, (0.0, 0.0, 0.0), 0.0)


def status(page):
    return ServerStatus("a:1", page, (), {}, ())


@pytest.fixture
def waiting():
    """Return the queue of a flight that stands still."""
    return Waiting()


def sent(waiting):
    """Return what a flight that goes on gets."""
    return list(iter(waiting.next, None))


def test_of_commands_that_wait_the_first_and_the_newest_of_each_client_are_sent(waiting):
    """The first one may be the neutral one that a new holder has to begin with."""
    for seq in range(1000):
        waiting.add(command(1, seq))
        waiting.add(command(2, seq))
    assert sent(waiting) == [command(1, 0), command(2, 0), command(1, 999), command(2, 999)]


def test_a_command_never_comes_before_what_was_asked_before_it(waiting):
    request = RequestControl(1, 1, "me")
    after = [command(1, number) for number in (2, 3, 4)]
    for each in (command(1, 0), command(1, 1), request, command(2, 5), *after):
        waiting.add(each)
    found = sent(waiting)
    assert found == [command(1, 0), command(1, 1), request, command(2, 5), after[0], after[2]]


def test_of_statuses_that_wait_the_newest_is_sent(waiting):
    for page in "abc":
        waiting.add(status(page))
    assert sent(waiting) == [status("c")]


def test_what_a_client_asked_that_has_gone_is_not_sent(waiting):
    for peer in range(1000):
        waiting.add(RequestControl(peer, 1, "me"))
        waiting.add(command(peer, 1))
        waiting.add(Gone(peer))
    assert sent(waiting) == []


def test_what_a_client_asked_just_before_it_went_still_counts(waiting):
    """A landing, or a release, is not undone by the farewell behind it."""
    waiting.add(RequestControl(3, 1, "me"))
    assert waiting.next() == RequestControl(3, 1, "me")
    waiting.add(command(3, 2))
    waiting.add(ReleaseControl(3, 2, 77))
    waiting.add(Gone(3))
    assert sent(waiting) == [ReleaseControl(3, 2, 77), Gone(3)]


def test_that_a_client_has_gone_is_sent_if_the_flight_has_heard_of_it(waiting):
    waiting.add(RequestControl(3, 1, "me"))
    assert waiting.next() == RequestControl(3, 1, "me")
    waiting.add(command(3, 2))
    waiting.add(Gone(3))
    assert sent(waiting) == [Gone(3)]
