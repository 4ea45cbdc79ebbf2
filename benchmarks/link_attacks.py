"""Do clients without a login take control from the pilot, or lock the owner of the token out?

A flight in real time with tokens, its server and its page, on loopback. A pilot flies it, a program
of its own: it repeats its velocity 20 times a second, and sets a parameter 50 times a second, whose
way to the flight and back is measured. First nobody disturbs it, then one or four clients without a
login attack the server: they send requests of HTTP without waiting for the answers, continuations
of a WebSocket without end, read or ask for the page byte by byte, and open 10,000 connections.
Meanwhile the owner of the token logs in once a second, by TCP and by the page in turn, and tries
again whenever its connection ends.

With `--kills`, the process of the server is killed instead, so often: measured is the time until
the owner of the token is logged in again.

All of it runs on this machine's cores. The attackers have the lowest priority, as they stand for
programs of other machines; what the system's network does for them is part of the measurement. What
the machine gives without an attack stands beside, from the same pilot just before. It ends with 1
where the pilot lost control, 99 of 100 commands took longer than 10 ms, a login took longer than a
second, or a restart longer than three.

`python benchmarks/link_attacks.py --seconds 5 --only pipelining` is a short one.
"""

import argparse
import asyncio
import contextlib
import json
import math
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from host import Host
from link_age import FLOWN
from link_attacker import ATTACKS
from link_faults import children
from link_flood import frame
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from workbench.common.errors import WorkbenchError
from workbench.link import AsyncClient
from workbench.link.authentication import Tokens, write_tokens
from workbench.link.server.config import ServerConfig
from workbench.link.wire import Decoder, FrameKind
from workbench.live.flight import LiveFlight
from workbench.live.messages import Phase

ATTACKER = str(Path(__file__).with_name("link_attacker.py"))
SECONDS = 60.0
KILLS = 20
BETWEEN_KILLS = 60.0
"""From one kill to the next [s]."""
ENOUGH = 120.0
"""Nothing takes so long unless it fails [s]."""
LONGEST_TRIP = 10.0
"""From a command to its acknowledgement, 99th percentile [ms]."""
LONGEST_LOGIN = 1.0
LONGEST_RESTART = 3.0
CLIENTS = (1, 4)
COMMAND_PERIOD = 0.02
LOGIN_PERIOD = 1.0
QUIET = 10.0
"""Before each attack, at most [s]."""
LOCKED_OUT = 10.0
"""Time after which the owner gives up a login [s]."""
RETRY = 0.01
"""Before a login is tried again [s]."""
SET = "kp_velocity_x"


@dataclass(frozen=True)
class LinkAttackRow:
    """How pilot and owner do beside an attack.

    Attributes:
        attack: what the clients do.
        clients: how many of them, each a process.
        commands: of the pilot that were acknowledged.
        quiet_99: from a command to its acknowledgement before the attack, 99th percentile [ms].
        trip_50: the same during the attack, median [ms].
        trip_99: 99th percentile [ms].
        trip_worst: the longest [ms].
        lost: how often the pilot lost control during the attack.
        logins: of the owner of the token.
        login_worst: the longest [s].
        connections: that the attackers opened.
        sent: by them [kB/s].
        stolen: by the machine's host, of all processor time meanwhile [%].
    """

    attack: str
    clients: int
    commands: int
    quiet_99: float
    trip_50: float
    trip_99: float
    trip_worst: float
    lost: int
    logins: int
    login_worst: float
    connections: int
    sent: float
    stolen: float


@dataclass(frozen=True)
class LinkKillRow:
    """What came of a kill of the server's process.

    Attributes:
        kill: its number.
        restart: until the owner of the token was logged in again [s].
        flown: simulated time since the kill before [s].
    """

    kill: int
    restart: float
    flown: float


@dataclass(frozen=True)
class Served:
    """A flight that is served with tokens.

    Attributes:
        flight: live.
        address: of its server, "HOST:PORT".
        page: of its page.
        tokens: of its server.
    """

    flight: LiveFlight
    address: str
    page: str
    tokens: Tokens


@contextmanager
def served() -> Iterator[Served]:
    """Fly, and serve the flight with tokens and a page."""
    with tempfile.TemporaryDirectory() as folder, LiveFlight(FLOWN) as flight:
        path = Path(folder) / "tokens"
        tokens = write_tokens(path)
        flight.wait(ENOUGH)
        config = ServerConfig(port=0, web=True, token_file=str(path))
        address = flight.serve(config).result(ENOUGH)
        end = time.monotonic() + ENOUGH
        while (server := flight.latest().network.server) is None:
            assert time.monotonic() < end, "the server is not shown"
            time.sleep(RETRY)
        yield Served(flight, address, server.page.removeprefix("http://").rstrip("/"), tokens)


def measure(
    seconds: float = SECONDS,
    only: list[str] | None = None,
    clients: tuple[int, ...] = CLIENTS,
) -> list[LinkAttackRow]:
    """Fly once beside each attack, by each number of clients."""
    rows = []
    with served() as scene:
        for name in only or ATTACKS:
            for count in clients:
                scene.flight.reset().result(ENOUGH)
                rows.append(_beside(scene, name, count, seconds))
                print(rows[-1], file=sys.stderr, flush=True)
    return rows


def measure_kills(kills: int = KILLS, period: float = BETWEEN_KILLS) -> list[LinkKillRow]:
    """Kill the server's process so often, and return what came of it."""
    rows = []
    with served() as scene:
        flight = scene.flight
        before = flight.latest().snapshot.time
        for number in range(1, kills + 1):
            time.sleep(period)
            (server,) = children(flight.pid)
            os.kill(server, signal.SIGKILL)
            restart = time_of_login(scene.address, scene.tokens.command)
            view = flight.latest()
            assert view.phase is Phase.FLYING, view.said
            rows.append(LinkKillRow(number, restart, view.snapshot.time - before))
            before = view.snapshot.time
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def holds(row: LinkAttackRow | LinkKillRow) -> bool:
    """Return whether pilot and owner came to no harm."""
    if isinstance(row, LinkKillRow):
        return row.restart <= LONGEST_RESTART and row.flown > 0.0
    return row.trip_99 <= LONGEST_TRIP and not row.lost and row.login_worst <= LONGEST_LOGIN


def show(rows: list[LinkAttackRow]) -> None:
    """Print a table."""
    print("before 99 %   50 %    99 %   worst ms  lost  login s  attack")
    for row in rows:
        print(
            f"{row.quiet_99:8.2f} {row.trip_50:9.2f} {row.trip_99:7.2f} {row.trip_worst:9.2f} "
            f"{row.lost:5d} {row.login_worst:8.3f}  {row.attack}, {row.clients} "
            f"({row.connections} connections, {row.sent:.0f} kB/s, {row.logins} logins, "
            f"{row.stolen:.1f} % stolen)"
        )


def show_kills(rows: list[LinkKillRow]) -> None:
    """Print a summary."""
    restarts = sorted(row.restart for row in rows)
    print(
        f"{len(rows)} kills of the server's process: the owner was logged in again after "
        f"{restarts[len(restarts) // 2]:.2f} s (median), {restarts[-1]:.2f} s (the longest)"
    )


def _beside(scene: Served, name: str, count: int, seconds: float) -> LinkAttackRow:
    """Let a pilot fly undisturbed for a while, then beside an attack."""
    pilot = _Program(__file__, "--pilot", scene.address, scene.tokens.command)
    programs = [pilot]
    try:
        assert pilot.said() == "flies"
        time.sleep(min(QUIET, seconds))
        quiet_end = time.monotonic()
        words = name, str(count), scene.address, scene.page
        attackers = [_Program(ATTACKER, *words) for _ in range(count)]
        programs += attackers
        assert [each.said() for each in attackers] == ["attacks"] * count
        begun, host = time.monotonic(), Host()
        logins = _owner(scene, seconds)
        end = time.monotonic()
        sent = [each.stopped() for each in attackers]
        heard = pilot.stopped()
    finally:
        for each in programs:
            each.close()
    quiet = sorted(trip for at, trip in heard["trips"] if at < quiet_end)
    trips = sorted(trip for at, trip in heard["trips"] if begun <= at < end)
    assert quiet and trips, f"{name}: no command was acknowledged: {heard}"
    return LinkAttackRow(
        name,
        count,
        len(trips),
        1e3 * _share(quiet, 0.99),
        *(1e3 * _share(trips, share) for share in (0.5, 0.99, 1.0)),
        sum(begun <= at < end for at in heard["lost"]),
        len(logins),
        max(logins),
        sum(each["connections"] for each in sent),
        sum(each["bytes"] for each in sent) / seconds / 1e3,
        host.stolen,
    )


class _Program:
    """A program beside this one, which says that it has begun, and how it went.

    Args:
        words: its file and its arguments.
    """

    def __init__(self, *words: str) -> None:
        command = (sys.executable, *words)
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)

    def said(self) -> str:
        """Wait for a line that it prints."""
        assert self._process.stdout
        return self._process.stdout.readline().strip()

    def stopped(self) -> dict:
        """Stop it, and return what it has to say."""
        return json.loads(self._process.communicate("stop\n", timeout=ENOUGH)[0])

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.communicate()


def _share(sorted_values: list[float], share: float) -> float:
    return sorted_values[round(share * (len(sorted_values) - 1))]


def _owner(scene: Served, seconds: float) -> list[float]:
    """Log in once a second for so long, by TCP and by the page; return how long it took [s]."""
    logins = []
    end = time.monotonic() + seconds
    while (begun := time.monotonic()) < end:
        page = scene.page if len(logins) % 2 else ""
        logins.append(time_of_login(scene.address, scene.tokens.command, page))
        time.sleep(max(0.0, min(begun + LOGIN_PERIOD, end) - time.monotonic()))
    return logins


def time_of_login(address: str, token: str, page: str = "") -> float:
    """Log in, by a page if one is given; try again until it succeeds, for `LOCKED_OUT` at most.

    Returns:
        How long it took [s], infinite if it did not succeed.
    """
    begun = time.monotonic()
    while True:
        with contextlib.suppress(OSError, EOFError, WebSocketException):
            if page:
                _log_in_by_page(page, token)
            else:
                _log_in(address, token)
            return time.monotonic() - begun
        if time.monotonic() > begun + LOCKED_OUT:
            return math.inf
        time.sleep(RETRY)


def _log_in(address: str, token: str) -> None:
    host, _, port = address.rpartition(":")
    with socket.create_connection((host, int(port)), LONGEST_LOGIN) as link:
        _exchange(lambda: link.recv(65536), link.sendall, token)


def _log_in_by_page(page: str, token: str) -> None:
    with connect(
        f"ws://{page}/ws", origin=f"http://{page}", compression=None, open_timeout=LONGEST_LOGIN
    ) as link:
        _exchange(lambda: link.recv(LONGEST_LOGIN), link.send, token)


def _exchange(receive, send, token: str) -> None:
    """Read hello, and log in.

    Raises:
        EOFError: if the connection ends before.
    """
    decoder = Decoder()
    while True:
        data = receive()
        if not data:
            raise EOFError
        for each in decoder.feed(data):
            if each.kind != FrameKind.CONTROL:
                continue
            said = json.loads(each.payload)
            if said["op"] == "login":
                send(frame(FrameKind.CONTROL, b'{"op":"bye"}'))
                return
            if said["op"] == "error":
                raise EOFError(said)
            if said["op"] == "hello":
                login = {"op": "login", "role": "command", "token": token}
                send(frame(FrameKind.CONTROL, json.dumps(login).encode()))


async def pilot(address: str, token: str) -> None:
    """Fly until a line is read; print how long each command took, and when control was lost."""
    stopped = asyncio.Event()
    loop = asyncio.get_running_loop()
    loop.add_reader(sys.stdin, stopped.set)
    trips: list[tuple[float, float]] = []
    lost: list[float] = []
    async with AsyncClient(address, name="pilot", token=token, topics=[], rate=50.0) as client:
        value = (await client.parameters(SET))[SET]
        said = False
        while not stopped.is_set():
            try:
                async with client.control() as control:
                    if not said:
                        print("flies", flush=True)
                        said = True
                    while not stopped.is_set():
                        control.velocity(0.0, 0.0, 0.0)
                        begun = time.monotonic()
                        await control.set(**{SET: value})
                        trips.append((begun, time.monotonic() - begun))
                        await asyncio.sleep(max(0.0, begun + COMMAND_PERIOD - time.monotonic()))
            except WorkbenchError as error:
                lost.append(time.monotonic())
                print(error, file=sys.stderr, flush=True)
                await asyncio.sleep(COMMAND_PERIOD)
    print(json.dumps({"trips": trips, "lost": lost}))


def main() -> int:
    """Measure, or be one of the programs that are measured; 1 if somebody came to harm."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of each attack")
    parser.add_argument(
        "--only", nargs="+", choices=ATTACKS, metavar="ATTACK", help=", ".join(ATTACKS)
    )
    parser.add_argument("--clients", nargs="+", type=int, default=CLIENTS, help="that attack")
    parser.add_argument("--kills", type=int, default=0, help="of the server's process, no attack")
    parser.add_argument("--period", type=float, default=BETWEEN_KILLS, help="between kills [s]")
    parser.add_argument("--pilot", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.pilot:
        asyncio.run(pilot(*arguments.pilot))
        return 0
    if arguments.kills:
        killed = measure_kills(arguments.kills, arguments.period)
        show_kills(killed)
        return 0 if all(map(holds, killed)) else 1
    rows = measure(arguments.seconds, arguments.only, tuple(arguments.clients))
    show(rows)
    return 0 if all(map(holds, rows)) else 1


if __name__ == "__main__":
    sys.exit(main())
