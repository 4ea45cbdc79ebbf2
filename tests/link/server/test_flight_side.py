"""Both ends of a real pipe, in a loop."""

import asyncio
from multiprocessing import Pipe

from workbench.link.backplane import Command
from workbench.link.server.flight_side import FlightSide


def command(peer, seq):
    return Command(peer, seq, 0, 7, 15, (0.0, 0.0, 0.0), 0.0)


def test_records_go_both_ways_and_its_end_is_noticed():
    here, there = Pipe()

    async def run():
        heard, ended = [], asyncio.Event()
        side = FlightSide(here)
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
        side = FlightSide(here)
        side.start(lambda records: None, lambda: None)
        for peer in range(1, 2001):
            side.tell(command(peer, 1))
        found = await asyncio.to_thread(lambda: [there.recv().peer for _ in range(2000)])
        await side.close()
        return found

    assert asyncio.run(run()) == list(range(1, 2001))
    there.close()
