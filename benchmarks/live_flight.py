"""Does a flight keep real time beside a screen that paints: by timer, in a thread, in a process?

Each shape flies for some seconds while a Qt window paints four plots of three curves of 2,000
points up to 60 times a second: alone; with a thread that computes the margins of all loops ten
times a second, as for a moving slider; with a thread that computes in plain Python all the time;
and alone again, with lidar, camera and all other sensors in the flight. Every third of a second the
pilot commands a velocity, and the first frame that shows it in a snapshot counts.

The shapes are: timer, a QTimer in the window's thread runs the flight; thread, a Python thread runs
it; process, `LiveFlight`. All of them advance at least 60 times a second. Shapes alternate, and
each figure is the median of the turns, so that other load affects all equally.

The last table is the cost of the interpreter's lock: a second of flight alone, and beside a thread
that computes in plain Python; each control update needs the lock and may wait 5 ms for it.
"""

import os
import threading
import time
from dataclasses import dataclass, fields, replace

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported

from live_screen import Screen, compute
from live_shapes import SHAPES, Shape
from PyQt6.QtCore import QCoreApplication, QTimer
from PyQt6.QtWidgets import QApplication

from workbench.design.judge.loop_judgement import live_margins
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario, SensorsConfig
from workbench.session.session import Session

SECONDS = 3.0
TURNS = 2
LOCK_TURNS = 8
COMMAND_PERIOD = 0.3
MARGINS_PERIOD = 0.1
LOADS = ("painting", "and margins", "and Python", "and sensors")
SENSING = Scenario(world="obstacle_field", sensors=SensorsConfig(use=["all"]))


@dataclass(frozen=True)
class LiveFlightRow:
    """How one shape does under one load; times in s.

    Attributes:
        shape: timer, thread or process.
        load: what else runs.
        real_time_factor: simulated time over wall-clock time.
        lag_99: delay of the flight behind the wall clock at the start of a slice, 99th percentile.
        lag_worst: the largest delay.
        frames: frames painted a second.
        gap_worst: longest time between two frames.
        latency: from a command to the first frame that sees it in a snapshot, median.
        latency_worst: the longest latency.
        share: share of a core that the screen's process takes.
        worker_share: share of a core that the flight's process takes, 0 without one.
    """

    shape: str
    load: str
    real_time_factor: float
    lag_99: float
    lag_worst: float
    frames: float
    gap_worst: float
    latency: float
    latency_worst: float
    share: float
    worker_share: float


@dataclass(frozen=True)
class LiveFlightFigures:
    """All figures.

    Attributes:
        rows: of each shape under each load.
        alone: wall time of a second of flight in a thread, best of several turns [s].
        beside: the same beside a thread that computes in plain Python.
    """

    rows: list[LiveFlightRow]
    alone: float
    beside: float


class Pilot:
    """Commands a new velocity now and then, and takes the time until it is seen."""

    def __init__(self, flight: Shape) -> None:
        self._flight = flight
        self._asked = 0.0
        self._asked_at = time.perf_counter()
        self._seen = True
        self.latencies: list[float] = []

    def look(self) -> None:
        """Look at the newest snapshot, as each frame does."""
        snapshot, now = self._flight.latest(), time.perf_counter()
        if not self._seen and snapshot and abs(snapshot.reference[0] - self._asked) < 1e-9:
            self._seen = True
            self.latencies.append(now - self._asked_at)
        if self._seen and now - self._asked_at > COMMAND_PERIOD:
            self._asked, self._asked_at, self._seen = 0.1 + (7 * self._asked) % 1.0, now, False
            self._flight.command(self._asked)


def measure(seconds: float = SECONDS) -> LiveFlightFigures:
    """Return a row for each shape under each load, and what the lock costs."""
    app = QApplication.instance() or QApplication([])
    study = LinearStudy(Scenario())
    live_margins(study)
    cells = [(load, shape) for load in LOADS for shape in SHAPES]
    turns = [
        [_row(app, study, shape, load, seconds) for load, shape in cells] for _ in range(TURNS)
    ]
    rows = [_median(list(cell)) for cell in zip(*turns, strict=True)]
    alone, beside = _lock()
    return LiveFlightFigures(rows, alone, beside)


def _median(rows: list[LiveFlightRow]) -> LiveFlightRow:
    """Return the median of each figure."""
    numbers = [f.name for f in fields(LiveFlightRow) if f.name not in ("shape", "load")]
    middle = {name: float(np.median([getattr(row, name) for row in rows])) for name in numbers}
    return replace(rows[0], **middle)


def _lock() -> tuple[float, float]:
    """Return how long a second of flight takes alone, and beside a thread of plain Python [s]."""
    session = Session()
    session.tick(0.5)
    alone, beside = [], []
    for _ in range(LOCK_TURNS):
        begun = time.perf_counter()
        session.tick(1.0)
        alone.append(time.perf_counter() - begun)
        ended = threading.Event()
        helper = threading.Thread(target=compute, args=(ended.is_set,))
        helper.start()
        begun = time.perf_counter()
        session.tick(1.0)
        beside.append(time.perf_counter() - begun)
        ended.set()
        helper.join()
    return min(alone), min(beside)


def _row(
    app: QCoreApplication, study: LinearStudy, shape: str, load: str, seconds: float
) -> LiveFlightRow:
    ended = threading.Event()

    def margins() -> None:
        kp = 100.0
        while not ended.wait(MARGINS_PERIOD):
            kp = 100.0 + (kp - 99.0) % 20.0
            live_margins(study, {"kp_roll": kp})

    work = {"and margins": [margins], "and Python": [lambda: compute(ended.is_set)]}
    helpers = [threading.Thread(target=target) for target in work.get(load, [])]
    flight = SHAPES[shape](SENSING if load == "and sensors" else Scenario())
    pilot = Pilot(flight)
    screen = Screen(pilot.look)
    screen.show()
    for helper in helpers:
        helper.start()
    first = flight.latest()
    begun, busy, worker = time.perf_counter(), time.process_time(), flight.busy()
    QTimer.singleShot(round(1000 * seconds), app.quit)
    app.exec()
    wall = time.perf_counter() - begun
    last, own, its = flight.latest(), time.process_time() - busy, flight.busy() - worker
    ended.set()
    for helper in helpers:
        helper.join()
    screen.stop()
    screen.close()
    flight.close()
    assert first is not None and last is not None
    latencies = pilot.latencies or [wall]  # no command showed its effect: at least so long
    return LiveFlightRow(
        shape=shape,
        load=load,
        real_time_factor=(last.time - first.time) / wall,
        lag_99=float(np.quantile(flight.lags, 0.99)),
        lag_worst=max(flight.lags),
        frames=len(screen.frames) / wall,
        gap_worst=float(np.diff(screen.frames).max()),
        latency=float(np.median(latencies)),
        latency_worst=max(latencies),
        share=own / wall,
        worker_share=its / wall,
    )


def show(figures: LiveFlightFigures) -> None:
    """Print the table."""
    print("live flight beside a painting screen; times in ms, shares of a core: screen + flight")
    print("load         shape    factor  lag 99 %, worst   frames/s, gap   latency, worst   share")
    for row in figures.rows:
        lag, worst_lag, gap, latency, worst = (
            round(1000 * seconds)
            for seconds in (
                row.lag_99,
                row.lag_worst,
                row.gap_worst,
                row.latency,
                row.latency_worst,
            )
        )
        print(
            f"{row.load:12s} {row.shape:8s} {row.real_time_factor:6.3f} {lag:9d} {worst_lag:6d} "
            f"{row.frames:10.1f} {gap:5d} {latency:9d} {worst:6d} {row.share:8.2f} + "
            f"{row.worker_share:.2f}"
        )
    print(
        f"\na second of flight takes {1000 * figures.alone:.0f} ms alone, and "
        f"{1000 * figures.beside:.0f} beside a thread that computes in plain Python"
    )


if __name__ == "__main__":
    show(measure())
