"""Flights of the full diagram in two local processes, and on two Dask workers.

Both fly the same candidates in the same run, in alternating turns, so that other load affects both
equally. Processes are started in each turn, as by a command; workers keep running, as in a cluster.
"""

import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from workbench.design.executor.cluster import DaskCluster
from workbench.design.executor.executor import Executor, LocalProcesses
from workbench.design.sweep.case import SweepCase
from workbench.design.sweep.full_flights import fly_full
from workbench.design.sweep.ranges import parse_range
from workbench.setup import make_setup

PROCESSES = 2
FLIGHTS = 24
TURNS = 3
STEP = 3.0
"""Duration of a flight after its edge [s]."""


@dataclass(frozen=True)
class ExecutorRow:
    """Flights of the full diagram in one place.

    Attributes:
        name: place.
        flights_a_second: flights a second in the best turn.
        median_ratio: ratio to the processes, turn by turn, median.
        least_ratio: smallest ratio of all turns.
        largest_ratio: largest ratio of all turns.
    """

    name: str
    flights_a_second: float
    median_ratio: float
    least_ratio: float
    largest_ratio: float


def measure() -> list[ExecutorRow]:
    """Return a row for local processes and one for a cluster on this machine."""
    from tests.clusters import local_cluster  # distributed takes a second to load

    case = SweepCase("x", 2.0, STEP)
    with (
        local_cluster(PROCESSES) as workers,
        DaskCluster(workers.scheduler_address) as cluster,
    ):
        places: dict[str, Executor] = {
            "two processes": LocalProcesses(PROCESSES),
            "Dask, two workers": cluster,
        }
        for executor in places.values():
            _time(case, executor, PROCESSES)  # compiles and loads
        times: dict[str, list[float]] = {name: [] for name in places}
        for _ in range(TURNS):
            for name, executor in places.items():
                times[name].append(_time(case, executor, FLIGHTS))
    return [_row(name, times[name], times["two processes"]) for name in places]


def show(rows: list[ExecutorRow]) -> None:
    """Print the table."""
    print(f"flights of the full diagram   a second   ratio ({TURNS} turns of {FLIGHTS} flights)")
    for row in rows:
        print(
            f"  {row.name:26} {row.flights_a_second:9.2f}   {row.median_ratio:.2f}"
            f"  ({row.least_ratio:.2f} .. {row.largest_ratio:.2f})"
        )


def _time(case: SweepCase, executor: Executor, count: int) -> float:
    """Return how long so many flights take [s]."""
    swept = (parse_range("kp_pitch=150..300:9"),)
    candidates = [case.candidate(swept, [150.0 + index]) for index in range(count)]
    begun = time.perf_counter()
    list(fly_full(case, make_setup(case.scenario), candidates, executor=executor))
    return time.perf_counter() - begun


def _row(name: str, times: list[float], here: list[float]) -> ExecutorRow:
    ratios = [base / own for base, own in zip(here, times, strict=True)]
    return ExecutorRow(
        name, FLIGHTS / min(times), statistics.median(ratios), min(ratios), max(ratios)
    )


if __name__ == "__main__":
    show(measure())
