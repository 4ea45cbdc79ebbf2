"""Who is let in at a port, before anything is said."""

import asyncio
import contextlib
import socket
import time

import pytest

from workbench.link.server import tcp
from workbench.link.server.tcp import Acceptor, listen

LIMIT = 300.0
"""Generous: nothing here is a matter of time [s]."""


class Accepted(asyncio.Protocol):
    """Keeps its connection open."""

    def __init__(self, address, inside):
        self.address = address
        self.inside = inside

    def connection_made(self, transport):
        self.transport = transport
        self.inside.append(self)


class Station:
    """An acceptor with who came in, and clients that connect."""

    def __init__(self):
        self.inside = []
        self.refused = []
        self.connecting = []
        self.acceptor = Acceptor(
            listen("127.0.0.1", 0),
            lambda address: Accepted(address, self.inside),
            lambda code, said: self.refused.append((code, said)),
            None,
        )

    def connect(self, source):
        end = socket.create_connection(self.acceptor.address, LIMIT, (source, 0))
        self.connecting.append(end)
        return end

    async def until(self, condition):
        end = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < end
            await asyncio.sleep(0.01)

    async def close(self):
        await self.acceptor.close()
        for accepted in self.inside:
            accepted.transport.abort()
        for end in self.connecting:
            end.close()
        await asyncio.sleep(0)


def run(scenario):
    async def set_up():
        station = Station()
        try:
            await scenario(station)
        finally:
            await station.close()

    asyncio.run(set_up())


def test_an_address_has_so_many_and_gets_more_when_some_go(monkeypatch):
    monkeypatch.setattr(tcp, "MOST_OF_A_NETWORK", 3)

    async def scenario(station):
        ends = [station.connect("127.0.0.2") for _ in range(5)]
        await station.until(lambda: len(station.refused) == 2 and len(station.inside) == 3)
        assert station.refused == [("too_many", "127.0.0.2: too many connections at once")] * 2
        for end in ends[3:]:
            with contextlib.suppress(ConnectionResetError):
                assert end.recv(1) == b""
        station.connect("127.0.0.3")
        await station.until(lambda: len(station.inside) == 4)
        station.inside[0].transport.abort()
        await asyncio.sleep(0)
        station.connect("127.0.0.2")
        await station.until(lambda: len(station.inside) == 5)
        assert len(station.refused) == 2

    run(scenario)


def test_there_are_so_many_in_all(monkeypatch):
    monkeypatch.setattr(tcp, "MOST", 4)

    async def scenario(station):
        for n in range(6):
            station.connect(f"127.0.0.{n + 2}")
        await station.until(lambda: len(station.refused) == 2 and len(station.inside) == 4)

    run(scenario)


@pytest.mark.parametrize(
    ("level", "option", "least", "most"),
    [
        (socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1, 1),
        (socket.IPPROTO_TCP, socket.TCP_NODELAY, 1, 1),
        (socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 1, 10),
        (socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, 1000, 10_000),
    ],
)
def test_the_system_notices_when_the_other_side_is_no_more(level, option, least, most):
    async def scenario(station):
        station.connect("127.0.0.1")
        await station.until(lambda: station.inside)
        end = station.inside[0].transport.get_extra_info("socket")
        assert least <= end.getsockopt(level, option) <= most

    run(scenario)


def test_who_comes_in_is_known_by_its_address():
    async def scenario(station):
        end = station.connect("127.0.0.5")
        await station.until(lambda: station.inside)
        assert station.inside[0].address == f"127.0.0.5:{end.getsockname()[1]}"

    run(scenario)
