"""The cost of sensors: a flight in real time with all of them, and the share of a core of each.

The live flight ticks 64 times a second and sleeps in between, as in the app. It must reach a
real-time factor of 1 with at most 60 % of one core, with an IMU at 200 Hz, a GPS at 10 Hz, 10 scans
a second of 5,760 rays and 15 pictures a second of 320 x 240, in a field of obstacles. The shares
are measured without sleeping, each as the best of several alternating turns minus that without
sensors.
"""

import time
from dataclasses import dataclass

from workbench.scenario.scenario import Scenario, SensorsConfig
from workbench.session.session import Session

USUAL = {"imu": 200.0, "gps": 10.0, "lidar": 10.0, "depth_camera": 15.0}
OTHERS = ("range_finder", "barometer")
TICK = 1 / 64
LIVE = 10.0
"""How long the live flight takes [s]."""
TURNS = 6


@dataclass(frozen=True)
class LiveRow:
    """The live flight.

    Attributes:
        real_time_factor: simulated time over wall-clock time spent flying; above 1 it keeps up.
        latest: largest delay of the end of a tick [s].
        share: share of one core, 0 .. 1; all threads together.
    """

    real_time_factor: float
    latest: float
    share: float


@dataclass(frozen=True)
class ShareRow:
    """Share of a core that one sensor takes, at its usual rate [s of processor a second]."""

    name: str
    share: float


@dataclass(frozen=True)
class SensorFigures:
    """The live flight with all sensors, and what each takes."""

    live: LiveRow
    shares: list[ShareRow]


def measure() -> SensorFigures:
    """Measure both."""
    return SensorFigures(measure_live(), measure_shares())


def measure_live() -> LiveRow:
    """Fly with all sensors in real time."""
    session = _session(["all"])
    session.tick(0.5)  # pictures and compiled code are slow the first time
    begun, busy = time.perf_counter(), time.process_time()
    flying = latest = 0.0
    for tick in range(1, round(LIVE / TICK) + 1):
        tick_begun = time.perf_counter()
        session.tick(TICK)
        now = time.perf_counter()
        flying += now - tick_begun
        latest = max(latest, now - begun - tick * TICK)
        time.sleep(max(0.0, begun + tick * TICK - now))
    wall = time.perf_counter() - begun
    return LiveRow(LIVE / flying, latest, (time.process_time() - busy) / wall)


def measure_shares() -> list[ShareRow]:
    """Return what each sensor takes alone, and the flight without any first."""
    sessions = {name: _session([name]) for name in (*USUAL, *OTHERS)}
    sessions = {"no sensor": _session([]), **sessions}
    best = dict.fromkeys(sessions, float("inf"))
    for session in sessions.values():
        session.tick(0.5)
    for _ in range(TURNS):
        for name, session in sessions.items():
            busy = time.process_time()
            session.tick(1.0)
            best[name] = min(best[name], time.process_time() - busy)
    floor = best.pop("no sensor")
    return [ShareRow("no sensor", floor), *(ShareRow(n, s - floor) for n, s in best.items())]


def _session(use: list[str]) -> Session:
    """Return a session in the obstacle field."""
    config = SensorsConfig(use=use, rates=dict(USUAL))
    return Session(Scenario(world="obstacle_field", sensors=config))


def show(figures: SensorFigures) -> None:
    """Print the tables."""
    live, shares = figures.live, figures.shares
    print("live flight, all sensors at their usual rates")
    print(
        f"real-time factor {live.real_time_factor:.2f} while flying, {100.0 * live.share:.0f} % of "
        f"one core; ticks end late by {1000.0 * live.latest:.0f} ms at most\n"
    )
    print("share of one core")
    for row in shares:
        print(f"{row.name:14s} {100.0 * row.share:6.1f} %")


if __name__ == "__main__":
    show(measure())
