"""Does anything grow while clients come and go, stall and flood for half an hour of flight?

Once a second a client does harm, in turns: it connects and goes, resets the connection, sends half
a frame and stays, sends what is no frame, subscribes to all and reads nothing, sends as many pings
or commands as it can for a while, asks for control and dies, opens thirty connections at once. A
good client beside reads eight topics all the time. What the two processes hold is counted when the
first minute, or tenth, is over, and at the end.

`python benchmarks/link_soak.py --minutes 2` is a short one.
"""

import argparse
import contextlib
import json
import random
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from link_age import CLIENT, FLOWN, busy_of, child_of, flown_by

from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight

MINUTES = 30.0
SETTLED = 60.0
"""After so long, or a tenth of the time, processes have loaded what they need [s]."""
PERIOD = 1.0
MOST_OPEN = 4
"""Clients that do harm by staying; the oldest goes."""
FLOOD = 0.3
"""So long a client sends what it can [s]."""
CROWD = 30
LAST_WORDS = 8.0
"""Until the server has forgotten those who did harm [s]."""
HEADER = struct.Struct("<2sBBHHIIq")
RESET = struct.pack("ii", 1, 0)


@dataclass(frozen=True)
class LinkSoakRow:
    """What a process holds.

    Attributes:
        process: which one.
        minutes: flown.
        memory_start: resident, when all is loaded [MB].
        memory_end: at the end [MB].
        threads_start: then.
        threads_end: at the end.
        descriptors_start: then.
        descriptors_end: at the end.
        share: of a core.
    """

    process: str
    minutes: float
    memory_start: float
    memory_end: float
    threads_start: int
    threads_end: int
    descriptors_start: int
    descriptors_end: int
    share: float


@dataclass(frozen=True)
class LinkSoakFigures:
    """All figures.

    Attributes:
        rows: of server and flight.
        real_time_factor: flown over wall time.
        harm: how often somebody did.
        refused: what the server refused.
        good_gaps: samples that the good client has missed.
        good_ended: why its connection ended, "" if it did not.
        last_refusals: of the server, in words.
    """

    rows: list[LinkSoakRow]
    real_time_factor: float
    harm: int
    refused: int
    good_gaps: int
    good_ended: str
    last_refusals: tuple[str, ...]


@dataclass(frozen=True)
class Held:
    """What a process holds, and the time that it has taken [s]."""

    memory: float
    threads: int
    descriptors: int
    busy: float


class Troublemaker:
    """Connects and does harm; `sockets` are those that stay for a while."""

    def __init__(self, host: str, port: int) -> None:
        self._where = (host, port)
        self._draw = random.Random(7)
        self.sockets: list[socket.socket] = []
        self.done = 0
        self._kinds: list[Callable[[socket.socket], None]] = [
            self._go,
            self._reset,
            self._half,
            self._nonsense,
            self._stall,
            self._pings,
            self._commands,
            self._die_in_control,
            self._crowd,
        ]

    def act(self) -> None:
        """Do the next harm."""
        kind = self._kinds[self.done % len(self._kinds)]
        self.done += 1
        with contextlib.suppress(OSError):  # the server may end it first
            kind(self._connect())
        while len(self.sockets) > MOST_OPEN:
            self.sockets.pop(0).close()

    def close(self) -> None:
        """Go."""
        while self.sockets:
            self.sockets.pop().close()

    def _connect(self) -> socket.socket:
        made = socket.create_connection(self._where, 5.0)
        self.sockets.append(made)
        return made

    def _go(self, made: socket.socket) -> None:
        made.recv(100)
        self.sockets.remove(made)
        made.close()

    def _reset(self, made: socket.socket) -> None:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
        self._go(made)

    def _half(self, made: socket.socket) -> None:
        made.sendall(frame(0, b'{"op":"ping"}')[:30])

    def _nonsense(self, made: socket.socket) -> None:
        made.sendall(self._draw.randbytes(4000))

    def _stall(self, made: socket.socket) -> None:
        made.sendall(frame(0, b'{"op":"subscribe","topics":["*"]}'))

    def _pings(self, made: socket.socket) -> None:
        self._flood(made, frame(0, b'{"op":"ping"}') * 100)

    def _commands(self, made: socket.socket) -> None:
        self._flood(made, frame(1, bytes(24), 8) * 100)

    def _flood(self, made: socket.socket, data: bytes) -> None:
        made.setblocking(False)
        end = time.monotonic() + FLOOD
        while time.monotonic() < end:
            try:
                made.send(data)
            except BlockingIOError:
                time.sleep(0.01)

    def _die_in_control(self, made: socket.socket) -> None:
        made.sendall(frame(0, b'{"op":"request_control","name":"trouble"}'))
        time.sleep(0.1)
        self._reset(made)

    def _crowd(self, made: socket.socket) -> None:
        crowd = [socket.create_connection(self._where, 5.0) for _ in range(CROWD)]
        for each in crowd:
            each.close()


def frame(kind: int, payload: bytes, topic: int = 0) -> bytes:
    """Return a frame."""
    return HEADER.pack(b"DH", 1, kind, topic, 0, 1, len(payload), 0) + payload


def measure(minutes: float = MINUTES) -> LinkSoakFigures:
    """Fly for so long beside those who do harm."""
    seconds = 60.0 * minutes
    with LiveFlight(FLOWN) as flight:
        flight.wait()
        address = flight.serve(ServerConfig(port=0)).result(30.0)
        host, _, port = address.rpartition(":")
        trouble = Troublemaker(host, int(port))
        pids = {"server": child_of(flight.pid), "flight": flight.pid}
        words = [sys.executable, str(CLIENT), host, port, str(seconds), "0"]
        good = subprocess.Popen(words, stdout=subprocess.PIPE)
        _annoy(trouble, min(SETTLED, 0.1 * seconds))
        start = {name: held(pid) for name, pid in pids.items()}
        begun, flown = time.perf_counter(), flown_by(flight)
        _annoy(trouble, seconds - min(SETTLED, 0.1 * seconds))
        wall, flown = time.perf_counter() - begun, flown_by(flight) - flown
        time.sleep(LAST_WORDS)
        end = {name: held(pid) for name, pid in pids.items()}
        status = flight.latest().network.server
        seen = json.loads(good.communicate(timeout=60.0)[0])
    return LinkSoakFigures(
        rows=[_row(name, wall, start[name], end[name]) for name in pids],
        real_time_factor=flown / wall,
        harm=trouble.done,
        refused=sum(status.refusals.values()) if status else 0,
        good_gaps=seen["gaps"],
        good_ended=seen["ended"],
        last_refusals=status.log if status else (),
    )


def _annoy(trouble: Troublemaker, seconds: float) -> None:
    """Do harm once a second, and end all that stays at the end."""
    begun = time.monotonic()
    for turn in range(round(seconds / PERIOD)):
        trouble.act()
        time.sleep(max(0.0, begun + (turn + 1) * PERIOD - time.monotonic()))
    trouble.close()


def _row(name: str, wall: float, start: Held, end: Held) -> LinkSoakRow:
    return LinkSoakRow(
        process=name,
        minutes=wall / 60.0,
        memory_start=start.memory,
        memory_end=end.memory,
        threads_start=start.threads,
        threads_end=end.threads,
        descriptors_start=start.descriptors,
        descriptors_end=end.descriptors,
        share=(end.busy - start.busy) / (wall + LAST_WORDS),
    )


def held(pid: int) -> Held:
    """Return what a process holds."""
    lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    said = dict(line.partition(":")[::2] for line in lines)
    return Held(
        memory=int(said["VmRSS"].split()[0]) / 1024.0,
        threads=int(said["Threads"]),
        descriptors=len(list(Path(f"/proc/{pid}/fd").iterdir())),
        busy=busy_of(pid),
    )


def show(figures: LinkSoakFigures) -> None:
    """Print the table."""
    print("process  minutes  memory [MB]      threads     descriptors  share of a core")
    for row in figures.rows:
        print(
            f"{row.process:8s} {row.minutes:7.1f}  {row.memory_start:6.1f} {row.memory_end:6.1f}  "
            f"{row.threads_start:5d} {row.threads_end:5d}  {row.descriptors_start:7d} "
            f"{row.descriptors_end:5d}  {row.share:10.2f}"
        )
    print(
        f"real-time factor {figures.real_time_factor:.3f}, {figures.harm} times harm, "
        f"{figures.refused} refusals; the good client: {figures.good_gaps} gaps"
        + (f", ended: {figures.good_ended}" if figures.good_ended else "")
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=MINUTES, help="of flight")
    show(measure(parser.parse_args().minutes))


if __name__ == "__main__":
    main()
