"""The age of data at clients of a live flight, and whether the flight keeps real time.

A flight runs in real time with its server. Eight clients, separate programs that use only sockets,
read eight topics of 200 samples a second each and acknowledge every batch. Age is the time from the
sampling of a frame of time_data to its reading, by the machine's clock. A second test adds two
clients: one reads 20 frames a second, the other one stops reading. With a C compiler, a third test
has eight clients in C, which wake up faster and so show the link's own share. Then the eight
clients read the same bytes from a bare broadcast: a loop of asyncio that sends the frames to
everybody and does nothing else. Last, 64 clients read only time_data. Everything,
including the clients, runs on this machine's cores.

A sample goes through two processes, and that of the bare broadcast through one. Of the median age
of 0.5 to 0.6 ms, 0.12 ms is the way to the server's process, 0.04 ms is the reading of its record,
and 0.2 ms is the writing to eight sockets, nearly all of it in the system. The 99th percentile
comes from samples that arrive while flight, server and clients are all busy: two of three are in a
slice with another one, and one in ten reaches the first client after more than 0.8 ms. A bare
broadcast beside a flight that is not served is as fast as alone.

These changes were tried. A sample is encoded once for all clients, and passed on as a named tuple:
this saves a tenth of the median, and was kept. Slices of the flight as long as a sample's period,
so that each ends with a sample: one in ten arrives after more than 0.5 ms; median and 99th
percentile fall by up to a fifth in some runs and not in others, and the flight needs more of a
core. A sleep after each slice has no effect.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from link_client import DATA, HEADER, TOPICS, Watcher

from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Rates, Scenario, SensorsConfig

SECONDS = 30.0
CLIENTS, MANY = 8, 64
SERVED = ServerConfig(port=0, clients=2 * MANY)
"""Clients of one machine get a share of the places."""
WARM_UP = 2.0
"""Clients are started one after the other; what is read before that is not counted [s]."""
SLOW = 20.0
FLOWN = Scenario(sensors=SensorsConfig(use=["imu"]), rates=Rates(record_period=10.0))
"""With an IMU, as clients subscribe to it too; it keeps no arrays, as `workbench serve` does."""
CLIENT = Path(__file__).with_name("link_client.py")
BROADCAST = Path(__file__).with_name("link_broadcast.py")
PERIOD = 5 / 1024
"""Of the samples of a topic [s]."""
IN_PYTHON = (sys.executable, str(CLIENT))


@dataclass(frozen=True)
class LinkAgeRow:
    """How a kind of client does.

    Attributes:
        clients: kind of clients.
        beside: other clients.
        frames: frames that each client reads a second.
        gaps: missed samples of all these clients.
        age_50: age of what is read, median [ms].
        age_99: the same, 99th percentile [ms].
        age_worst: the same, largest [ms].
        ended: how the server ended the connection, "" if it did not.
        after: time until that end [s].
    """

    clients: str
    beside: str
    frames: float
    gaps: int
    age_50: float
    age_99: float
    age_worst: float
    ended: str
    after: float


@dataclass(frozen=True)
class LinkLoadRow:
    """What it costs.

    Attributes:
        beside: clients.
        real_time_factor: simulated time over wall-clock time.
        server_share: share of a core that the server's process takes.
        flight_share: share of a core that the flight's process takes.
    """

    beside: str
    real_time_factor: float
    server_share: float
    flight_share: float


@dataclass(frozen=True)
class LinkAgeFigures:
    """All figures.

    Attributes:
        ages: of what clients read.
        loads: of the two processes.
        others_99: 99th percentile of the eight clients' age beside the two slow ones over that
            without them.
        over_bare_50: median age of the eight clients over that of a bare broadcast.
        over_bare_99: the same of the 99th percentiles.
    """

    ages: list[LinkAgeRow]
    loads: list[LinkLoadRow]
    others_99: float
    over_bare_50: float
    over_bare_99: float


@dataclass(frozen=True)
class Seen:
    """What a client has printed; ages in s, see link_client.py."""

    ages: list[float]
    gaps: int
    frames: int
    ended: str
    lasted: float


def measure(seconds: float = SECONDS) -> LinkAgeFigures:
    """Fly with the eight clients alone, with two slow ones beside them, and with eight in C."""
    alone, load = _fly(seconds, [])
    beside, load_beside = _fly(seconds, [SLOW, -1.0])
    in_c = _fly_in_c(seconds)
    bare = _row("eight", "a bare broadcast", _broadcast(seconds))
    seen, load_many = _fly(seconds, [], IN_PYTHON, MANY, ["1"])
    many = _row("64, of one topic", "nobody", seen)
    eight = _row("eight", "nobody", alone)
    eight_beside = _row("eight", "two slow ones", beside[:CLIENTS])
    slow = _row("reads 20 frames/s", "eight", [beside[CLIENTS]])
    stopped = _row("stops reading", "eight", [beside[CLIENTS + 1]])
    return LinkAgeFigures(
        [eight, eight_beside, slow, stopped, *in_c, bare, many],
        [load, load_beside, load_many],
        eight_beside.age_99 / eight.age_99,
        eight.age_50 / bare.age_50,
        eight.age_99 / bare.age_99,
    )


def _fly_in_c(seconds: float) -> list[LinkAgeRow]:
    """Return the row of eight clients in C, none where there is no compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return []
    with tempfile.TemporaryDirectory() as folder:
        client = f"{folder}/link_client"
        options = ["-std=c99", "-O2", "-o", client]
        subprocess.run([compiler, *options, str(CLIENT.with_suffix(".c"))], check=True)
        seen, _ = _fly(seconds, [], [client])
    return [_row("eight in C", "nobody", seen)]


def _broadcast(seconds: float) -> list[Seen]:
    """Return what eight clients saw of a bare broadcast of the frames of a flight."""
    given = json.dumps({"frames": [each.hex() for each in _frames()], "period": PERIOD})
    with subprocess.Popen(
        [sys.executable, str(BROADCAST)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as server:
        assert server.stdin and server.stdout
        server.stdin.write(given.encode() + b"\n")
        server.stdin.flush()
        address = f"127.0.0.1:{int(server.stdout.readline())}"
        clients = [_start(IN_PYTHON, address, seconds + WARM_UP, 0.0) for _ in range(CLIENTS)]
        seen = [Seen(**json.loads(each.communicate(timeout=seconds + 60.0)[0])) for each in clients]
        server.stdin.close()
    return seen


class _Recorder(Watcher):
    """Keeps the first frame of each topic."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(host, port)
        self.found: dict[int, bytes] = {}

    def _take(self, kind: int, topic: int, t_ns: int, payload: bytes) -> None:
        if kind == DATA:
            head = HEADER.pack(b"DH", 1, DATA, topic, 0, 0, len(payload), t_ns)
            self.found.setdefault(topic, head + payload)


def _frames() -> list[bytes]:
    """Return a frame of each topic of a flight."""
    with LiveFlight(FLOWN) as flight:
        flight.wait()
        host, _, port = flight.serve(SERVED).result(30.0).rpartition(":")
        recorder = _Recorder(host, int(port))
        recorder.subscribe()
        while len(recorder.found) < len(TOPICS):
            recorder.read()
    return list(recorder.found.values())


def _fly(
    seconds: float,
    slow: list[float],
    program: Sequence[str] = IN_PYTHON,
    count: int = CLIENTS,
    topics: Sequence[str] = (),
) -> tuple[list[Seen], LinkLoadRow]:
    """Fly with clients and some slow ones; return what they saw, and what it cost."""
    with LiveFlight(FLOWN) as flight:
        flight.wait()
        address = flight.serve(SERVED).result(30.0)
        server = child_of(flight.pid)
        paces = [0.0] * count + slow
        clients = [_start(program, address, seconds + WARM_UP, pace, topics) for pace in paces]
        time.sleep(WARM_UP)
        begun, flown = time.perf_counter(), flown_by(flight)
        busy, busy_server = busy_of(flight.pid), busy_of(server)
        time.sleep(seconds - 1.0)
        wall, flown = time.perf_counter() - begun, flown_by(flight) - flown
        load = LinkLoadRow(
            "two slow ones" if slow else f"{count} clients",
            flown / wall,
            (busy_of(server) - busy_server) / wall,
            (busy_of(flight.pid) - busy) / wall,
        )
        seen = [Seen(**json.loads(client.communicate(timeout=60.0)[0])) for client in clients]
    return seen, load


def _start(
    program: Sequence[str],
    address: str,
    seconds: float,
    pace: float,
    topics: Sequence[str] = (),
) -> subprocess.Popen[bytes]:
    host, _, port = address.rpartition(":")
    words = [*program, host, port, str(seconds), str(pace), *topics]
    return subprocess.Popen(words, stdout=subprocess.PIPE)


def _row(clients: str, beside: str, seen: list[Seen]) -> LinkAgeRow:
    rate = max(1, round(len(seen[0].ages) / max(seen[0].lasted, 1.0)))
    ages = sorted(age for each in seen for age in each.ages[round(WARM_UP * rate) :])
    ages = [1000.0 * age for age in ages] or [float("nan")]
    return LinkAgeRow(
        clients=clients,
        beside=beside,
        frames=sum(each.frames / each.lasted for each in seen) / len(seen),
        gaps=sum(each.gaps for each in seen),
        age_50=ages[len(ages) // 2],
        age_99=ages[int(0.99 * len(ages))],
        age_worst=ages[-1],
        ended=" ".join(sorted({each.ended for each in seen if each.ended})),
        after=min(each.lasted for each in seen),
    )


def flown_by(flight: LiveFlight) -> float:
    """Return the simulated time [s]."""
    snapshot = flight.latest().snapshot
    return snapshot.time if snapshot else 0.0


def child_of(pid: int) -> int:
    """Return the process that a process has started last."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()
    return int(children[-1])


def busy_of(pid: int) -> float:
    """Return the time that a process has taken of all cores [s]."""
    words = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def show(figures: LinkAgeFigures) -> None:
    """Print the tables."""
    print("clients             beside         frames/s  gaps  age 50 %, 99 %, worst [ms]  ended")
    for row in figures.ages:
        print(
            f"{row.clients:19s} {row.beside:14s} {row.frames:8.0f} {row.gaps:5d} "
            f"{row.age_50:8.2f} {row.age_99:8.2f} {row.age_worst:8.1f}     "
            f"{row.ended} after {row.after:.1f} s"
        )
    for load in figures.loads:
        print(
            f"{load.beside}: real-time factor {load.real_time_factor:.3f}, share of a core: "
            f"server {load.server_share:.2f}, flight {load.flight_share:.2f}"
        )
    print(f"the eight's 99 % beside the slow ones over that without: {figures.others_99:.2f}")
    print(f"over the bare broadcast: {figures.over_bare_50:.2f}, {figures.over_bare_99:.2f} (99 %)")


if __name__ == "__main__":
    show(measure(float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS))
