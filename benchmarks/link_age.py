"""The age of data at clients of a live flight, and whether the flight keeps real time.

A flight runs in real time with its server. Eight clients, separate programs that use only sockets,
read eight topics of 200 samples a second each and acknowledge every batch. Age is the time from the
sampling of a frame of time_data to its reading, by the machine's clock. A second test adds two
clients: one reads 20 frames a second, the other one stops reading. With a C compiler, a third test
has eight clients in C, which wake up faster and so show the link's own share. Everything, including
the clients, runs on this machine's cores.
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

from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Rates, Scenario, SensorsConfig

SECONDS = 60.0
CLIENTS = 8
WARM_UP = 2.0
"""Clients are started one after the other; what is read before that is not counted [s]."""
SLOW = 20.0
FLOWN = Scenario(sensors=SensorsConfig(use=["imu"]), rates=Rates(record_period=10.0))
"""With an IMU, as clients subscribe to it too; it keeps no arrays, as `workbench serve` does."""
CLIENT = Path(__file__).with_name("link_client.py")
IN_PYTHON = (sys.executable, str(CLIENT))


@dataclass(frozen=True)
class LinkAgeRow:
    """How a kind of client does.

    Attributes:
        clients: which ones.
        beside: who else is there.
        frames: that each reads a second.
        gaps: samples that were missing, of all these clients.
        age_50: of what is read, median [ms].
        age_99: the 99th percentile [ms].
        age_worst: the oldest [ms].
        ended: how the server ended the connection, "" if it did not.
        after: until that end [s].
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
        beside: who is there.
        real_time_factor: flown over wall time.
        server_share: of a core that the server's process takes.
        flight_share: of a core that the flight's process takes.
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
    """

    ages: list[LinkAgeRow]
    loads: list[LinkLoadRow]
    others_99: float


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
    eight = _row("eight", "nobody", alone)
    eight_beside = _row("eight", "two slow ones", beside[:CLIENTS])
    slow = _row("reads 20 frames/s", "eight", [beside[CLIENTS]])
    stopped = _row("stops reading", "eight", [beside[CLIENTS + 1]])
    return LinkAgeFigures(
        [eight, eight_beside, slow, stopped, *in_c],
        [load, load_beside],
        eight_beside.age_99 / eight.age_99,
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


def _fly(
    seconds: float, slow: list[float], program: Sequence[str] = IN_PYTHON
) -> tuple[list[Seen], LinkLoadRow]:
    """Fly with eight clients and some slow ones; return what they saw, and what it cost."""
    with LiveFlight(FLOWN) as flight:
        flight.wait()
        address = flight.serve(ServerConfig(port=0)).result(30.0)
        server = child_of(flight.pid)
        paces = [0.0] * CLIENTS + slow
        clients = [_start(program, address, seconds + WARM_UP, pace) for pace in paces]
        time.sleep(WARM_UP)
        begun, flown = time.perf_counter(), flown_by(flight)
        busy, busy_server = busy_of(flight.pid), busy_of(server)
        time.sleep(seconds - 1.0)
        wall, flown = time.perf_counter() - begun, flown_by(flight) - flown
        load = LinkLoadRow(
            "two slow ones" if slow else "eight clients",
            flown / wall,
            (busy_of(server) - busy_server) / wall,
            (busy_of(flight.pid) - busy) / wall,
        )
        seen = [Seen(**json.loads(client.communicate(timeout=60.0)[0])) for client in clients]
    return seen, load


def _start(
    program: Sequence[str], address: str, seconds: float, pace: float
) -> subprocess.Popen[bytes]:
    host, _, port = address.rpartition(":")
    return subprocess.Popen([*program, host, port, str(seconds), str(pace)], stdout=subprocess.PIPE)


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


if __name__ == "__main__":
    show(measure(float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS))
