"""Who is let in at a port, before anything is said."""

import asyncio
import contextlib
import socket
import time

import pytest

from workbench.link.address import Address, network_of
from workbench.link.server import acceptor
from workbench.link.server.acceptor import (
    AcceptedConnection,
    AcceptedProtocol,
    Acceptor,
    PendingConnections,
    listen,
)

LIMIT = 300.0
"""Generous: nothing here is a matter of time [s]."""


class Stranger(AcceptedProtocol):
    """Keeps its connection open; it has logged in once the test says so."""

    is_in = False

    def __init__(self, address, inside):
        super().__init__()
        self.address = address
        self.inside = inside

    def connection_made(self, transport):
        self.transport = transport
        self.inside.append(self)

    def connection_lost(self, exc):
        self.inside.remove(self)
        self.ended.set()

    def close(self):
        self.transport.abort()

    abort = close


class Station:
    """An acceptor with who came in, and clients that connect."""

    def __init__(self):
        self.inside = []
        self.refused = []
        self.connecting = []
        self.acceptor = Acceptor(
            listen("127.0.0.1", 0),
            lambda address: Stranger(address, self.inside),
            lambda code, said: self.refused.append((code, said)),
        )

    async def connect(self, source):
        """Connect from an address, and return the protocol of the connection once it is in."""
        end = socket.create_connection(self.acceptor.address, LIMIT, (source, 0))
        self.connecting.append(end)
        address = f"{source}:{end.getsockname()[1]}"
        await self.until(lambda: address in [each.address for each in self.inside])
        return self.inside[-1]

    def hosts(self):
        return [each.address.split(":")[0] for each in self.inside]

    async def until(self, condition):
        end = time.monotonic() + LIMIT
        while not condition():
            assert time.monotonic() < end
            await asyncio.sleep(0.001)

    async def close(self):
        await self.acceptor.close()
        for end in self.connecting:
            end.close()


def run(scenario):
    async def set_up():
        station = Station()
        try:
            await scenario(station)
        finally:
            await station.close()

    asyncio.run(set_up())


def test_who_has_not_logged_in_makes_room_and_who_has_stays(monkeypatch):
    """The oldest of the network that has most goes, so one address cannot keep out another."""
    monkeypatch.setattr(acceptor, "MAX_BEGUN_CONNECTIONS", 4)

    async def scenario(station):
        owner = await station.connect("127.0.0.2")
        owner.is_in = True
        other = await station.connect("127.0.0.3")
        crowd = [await station.connect("127.0.0.2") for _ in range(6)]
        assert station.inside == [owner, other, *crowd[-2:]]
        assert {code for code, _ in station.refused} == {"too_many"}
        assert [said.split(":")[0] for _, said in station.refused] == ["127.0.0.2"] * 4
        # Also one more of another address does not cost the only one of its address.
        await station.connect("127.0.0.4")
        assert station.hosts() == ["127.0.0.2", "127.0.0.3", "127.0.0.2", "127.0.0.4"]
        # If all have one connection, the oldest goes.
        await station.connect("127.0.0.5")
        assert station.hosts() == ["127.0.0.2", "127.0.0.2", "127.0.0.4", "127.0.0.5"]

    run(scenario)


def test_a_place_is_free_when_a_connection_ends(monkeypatch):
    monkeypatch.setattr(acceptor, "MAX_BEGUN_CONNECTIONS", 2)

    async def scenario(station):
        first = await station.connect("127.0.0.2")
        await station.connect("127.0.0.2")
        first.transport.abort()
        await station.until(lambda: len(station.inside) == 1)
        await station.connect("127.0.0.2")
        assert len(station.inside) == 2
        assert not station.refused

    run(scenario)


def test_only_clients_that_have_logged_in_can_take_all_places(monkeypatch):
    monkeypatch.setattr(acceptor, "MAX_BEGUN_CONNECTIONS", 2)

    async def scenario(station):
        for host in ("127.0.0.2", "127.0.0.3"):
            (await station.connect(host)).is_in = True
        with socket.create_connection(station.acceptor.address, LIMIT, ("127.0.0.4", 0)) as late:
            await station.until(lambda: station.refused)
            with contextlib.suppress(ConnectionResetError):
                assert late.recv(1) == b""
        assert station.hosts() == ["127.0.0.2", "127.0.0.3"]

    run(scenario)


def accepted(host):
    return AcceptedConnection(object(), Address(host, 1), network_of(host))


def test_of_those_that_wait_the_newest_of_the_smallest_network_begins(monkeypatch):
    """Networks of IPv6 are of 64 bits: nobody has many of them for its many addresses."""
    monkeypatch.setattr(acceptor, "MAX_PENDING_CONNECTIONS", 4)
    waiting = PendingConnections()
    one, two, three = (accepted(f"2001:db8::{n}") for n in range(1, 4))
    other, owner = accepted("2001:db8:0:1::1"), accepted("192.0.2.7")
    assert [waiting.add(each) for each in (one, other, two, owner)] == [None] * 4
    assert waiting.add(three) is one
    assert waiting.take({three.network: 2, other.network: 1}) is owner
    assert waiting.take({three.network: 2, other.network: 1}) is other
    assert [waiting.take({}), waiting.take({}), waiting.take({})] == [three, two, None]
    assert waiting.count == 0


def test_connections_begin_no_faster_than_they_can_log_in(monkeypatch):
    """Without time, a burst begins; the others wait, and the oldest of them are turned away."""
    monkeypatch.setattr(acceptor, "BEGIN_RATE_HZ", 0.0)
    monkeypatch.setattr(acceptor, "BEGINS_PER_TURN", 8)
    monkeypatch.setattr(acceptor, "MAX_PENDING_CONNECTIONS", 5)

    async def scenario(station):
        station.acceptor._due = 3.0
        for _ in range(12):
            end = socket.create_connection(station.acceptor.address, LIMIT)
            station.connecting.append(end)
        await station.until(lambda: len(station.inside) == 3)
        assert len(station.refused) == 7
        monkeypatch.setattr(acceptor, "BEGIN_RATE_HZ", 1e6)
        await station.until(lambda: len(station.inside) == 5)

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
        await station.connect("127.0.0.1")
        end = station.inside[0].transport.get_extra_info("socket")
        assert least <= end.getsockopt(level, option) <= most

    run(scenario)


def test_who_comes_in_is_known_by_its_address():
    async def scenario(station):
        guest = await station.connect("127.0.0.5")
        assert guest.address == f"127.0.0.5:{station.connecting[0].getsockname()[1]}"

    run(scenario)
