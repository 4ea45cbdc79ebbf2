"""Both ends of a real pipe, in a loop."""

import asyncio
from multiprocessing import Pipe

import pytest

from workbench.link.backplane import Command, Gone, Request, ServerStatus
from workbench.link.operations import ReleaseControl, RequestControl
from workbench.link.server.flight_connection import FlightConnection


def command(peer, seq):
    return Command(peer, seq, 0, 7, 15, (0.0, 0.0, 0.0), 0.0)


def test_records_go_both_ways_and_its_end_is_noticed():
    here, there = Pipe()

    async def run():
        heard, ended = [], asyncio.Event()
        side = FlightConnection(here)
        side.tell(command(1, 1))
        side.start(heard.extend, ended.set)
        assert await asyncio.to_thread(there.recv) == command(1, 1)
        await asyncio.to_thread(lambda: [there.send(number) for number in range(10_000)])
        there.close()
        await asyncio.wait_for(ended.wait(), 20.0)
        await side.close()
        return heard

    assert asyncio.run(run()) == list(range(10_000))


def test_a_flight_that_stands_still_is_not_waited_for():
    """More than the buffer holds: the loop goes on, and all arrives once the flight reads."""
    here, there = Pipe()

    async def run():
        side = FlightConnection(here)
        side.start(lambda records: None, lambda: None)
        for peer in range(1, 2001):
            side.tell(command(peer, 1))
        found = await asyncio.to_thread(lambda: [there.recv().peer for _ in range(2000)])
        await side.close()
        return found

    assert asyncio.run(run()) == list(range(1, 2001))
    there.close()


def status(page):
    return ServerStatus("a:1", page, (), {}, ())


ASKS = Request(3, RequestControl(1, "me"))
RELEASES = Request(3, ReleaseControl(2, 77))
COMMANDS = [command(3, seq) for seq in range(6)]


@pytest.mark.parametrize(
    ("told", "sent"),
    [
        (  # the first one may be the neutral one that a new holder has to begin with
            [command(peer, seq) for seq in range(1000) for peer in (1, 2)],
            [command(1, 0), command(2, 0), command(1, 999), command(2, 999)],
        ),
        (  # a command never comes before what was asked before it
            [*COMMANDS[:2], ASKS, command(2, 5), *COMMANDS[2:5]],
            [*COMMANDS[:2], ASKS, command(2, 5), COMMANDS[2], COMMANDS[4]],
        ),
        ([status(page) for page in "abc"], [status("c")]),
        ([ASKS, COMMANDS[1], Gone(3)], []),  # of who was never heard of, nothing counts
    ],
)
def test_of_what_waits_the_newest_counts(told, sent):
    assert what_a_flight_gets([], told) == sent


@pytest.mark.parametrize(
    ("told", "sent"),
    [
        ([COMMANDS[2], RELEASES, Gone(3)], [RELEASES, Gone(3)]),  # goodbye undoes no release
        ([COMMANDS[2], Gone(3)], [Gone(3)]),
    ],
)
def test_what_a_client_asked_before_it_went_counts_if_the_flight_knows_it(told, sent):
    assert what_a_flight_gets([ASKS], told) == [ASKS, *sent]


def what_a_flight_gets(before, told):
    """Return what a flight reads that had read some records, stood still, and then goes on."""
    here, there = Pipe()
    filler = Request(9, RequestControl(0, "x" * 900_000))  # more than any buffer holds

    async def run():
        connection = FlightConnection(here)
        connection.start(lambda records: None, lambda: None)
        for record in before:
            connection.tell(record)
        connection.tell(filler)
        for record in told:
            connection.tell(record)
        connection.tell(Request(9, RequestControl(0, "end")))

        def read():
            found = []
            while (record := there.recv()) != Request(9, RequestControl(0, "end")):
                found.append(record)
            return found

        found = await asyncio.to_thread(read)
        await connection.close()
        return [record for record in found if record != filler]

    try:
        return asyncio.run(run())
    finally:
        there.close()
