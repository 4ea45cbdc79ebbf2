import asyncio
from multiprocessing import Pipe

import pytest

from workbench.link.backplane import Command, Gone, RequestControl, ServerStatus
from workbench.link.server.flight_side import FlightSide


def command(peer, seq):
    return Command(peer, seq, 0, 7, 15, (0.0, 0.0, 0.0), 0.0)


def status(page):
    return ServerStatus("a:1", page, (), {}, ())


@pytest.fixture
def side():
    """Return one whose flight stands still: nothing is sent."""
    ends = Pipe()
    yield FlightSide(ends[0])
    for end in ends:
        end.close()


def sent(side):
    """Return what a flight that goes on gets."""
    side._closing = True
    return list(iter(side._next, None))


def test_of_commands_that_wait_the_newest_of_each_client_is_sent(side):
    for seq in range(1000):
        side.tell(command(1, seq))
        side.tell(command(2, seq))
    assert sent(side) == [command(1, 999), command(2, 999)]


def test_a_command_never_comes_before_what_was_asked_before_it(side):
    request = RequestControl(1, 1, "me")
    for each in (command(1, 1), request, command(2, 5), command(1, 2), command(1, 3)):
        side.tell(each)
    assert sent(side) == [command(1, 1), request, command(2, 5), command(1, 3)]


def test_of_statuses_that_wait_the_newest_is_sent(side):
    for page in "abc":
        side.tell(status(page))
    assert sent(side) == [status("c")]


def test_what_a_client_asked_that_has_gone_is_not_sent(side):
    for peer in range(1000):
        side.tell(RequestControl(peer, 1, "me"))
        side.tell(command(peer, 1))
        side.tell(Gone(peer))
    assert sent(side) == []


def test_that_a_client_has_gone_is_sent_if_the_flight_has_heard_of_it(side):
    side.tell(RequestControl(3, 1, "me"))
    assert side._next() == RequestControl(3, 1, "me")
    side.tell(command(3, 2))
    side.tell(Gone(3))
    assert sent(side) == [Gone(3)]


def test_records_go_both_ways_and_its_end_is_noticed():
    here, there = Pipe()

    async def run():
        heard, ended = [], asyncio.Event()
        side = FlightSide(here)
        side.start(heard.extend, ended.set)
        side.tell(command(1, 1))
        assert await asyncio.to_thread(there.recv) == command(1, 1)
        await asyncio.to_thread(lambda: [there.send(number) for number in range(10_000)])
        there.close()
        await asyncio.wait_for(ended.wait(), 20.0)
        await asyncio.to_thread(side.close)
        return heard

    assert asyncio.run(run()) == list(range(10_000))
