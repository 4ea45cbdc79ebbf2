"""Many closed-loop flights of five seconds, compared with batched simulators and Drake diagrams.

Our flights are compiled velocity steps with different gains, five seconds from the command on. They
have a rigid body, rotors and the controller at its usual rate, and in a second row the controller
at every physics step. Physics runs at 1,024 Hz, in two threads. Metrics are computed and curves
discarded. crazyflow flies each drone to its own point, at 500 Hz, all in one compiled call: as it
comes, and with its worlds split over two devices, one for each core. RotorPy does the same at its
100 Hz, in two single-threaded processes, without its sensors and recording. Drake diagrams fly in
two processes, one session at a time; their rate does not depend on the number of flights. They
hover for a second first, which is subtracted.

One-time compilation, imports and the first turn do not count. RotorPy and diagrams fly only a part,
see `flown`, and their rate is extrapolated. Turns alternate, so that other load affects all
equally; times are wall-clock times.
"""

import multiprocessing
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from simulators import NoSimulatorError, OtherSimulator, version
from spread import Spread, ratios, spread, text

from workbench.common.resources import find_model
from workbench.control.controller_file import load_controller
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.step_response import STEP_EDGE_S, step_scenario
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import Rates, Scenario
from workbench.session.session import Session

COUNTS = (1, 64, 1024, 16384)
DURATION, SPEED = 5.0, 2.0
TURNS, FEWER_TURNS = 4, 2
"""The second for the largest count."""
CORES = 2
DIAGRAMS = 16
"""Flights on the full diagram a turn."""
OURS = "compiled flights"


@dataclass(frozen=True)
class SweepRow:
    """How many flights a second one simulator makes.

    Attributes:
        simulator: name and rate.
        candidates: number that fly at once.
        flown: share of the five seconds of each flight, or of the candidates, 0 .. 1.
        rollouts_a_second: closed-loop flights a second.
        ours_as_often: our rollouts a second, relative to this one.
    """

    simulator: str
    candidates: int
    flown: float
    rollouts_a_second: Spread
    ours_as_often: Spread


@dataclass(frozen=True)
class Missing:
    """What could not be compared, and why."""

    simulator: str
    reason: str


@dataclass(frozen=True)
class Fleet:
    """A way to fly many: returns the seconds that all would take, and the share of it flown."""

    simulator: str
    counts: tuple[int, ...]
    fly: Callable[[int], tuple[float, float]]


def measure(counts: tuple[int, ...] = COUNTS, turns: int = TURNS) -> list[SweepRow | Missing]:
    """Return a row for each simulator and count."""
    rows: list[SweepRow | Missing] = []
    with ExitStack() as stack:
        fleets = [*_own(counts), *_others(counts, stack)]
        rows += [each for each in fleets if isinstance(each, Missing)]
        for count in counts:
            ready = [each for each in fleets if isinstance(each, Fleet) and count in each.counts]
            rows += _rows(ready, count, turns if count < max(COUNTS) else min(turns, FEWER_TURNS))
    return rows


def show(rows: list[SweepRow | Missing]) -> None:
    """Print the table."""
    print(f"{'flights of 5 s at once':44} candidates   a second                 ours as often")
    for row in rows:
        if isinstance(row, Missing):
            print(f"{row.simulator:44} {row.reason}")
        else:
            print(
                f"{row.simulator:44} {row.candidates:10d}   {text(row.rollouts_a_second):24} "
                f"{text(row.ours_as_often)}"
            )


def candidates(own: dict[str, float], count: int) -> np.ndarray:
    """Return gains (count, 19) that all fly, and differ."""
    names = [row.name for row in load_controller().parameters]
    gains = np.tile([own[name] for name in names], (count, 1))
    rng = np.random.default_rng(0)
    for name in ("kp_pitch", "kd_pitch", "kp_velocity_x"):
        gains[:, names.index(name)] *= rng.uniform(0.8, 1.2, count)
    return gains


def _rows(fleets: list[Fleet], count: int, turns: int) -> Iterator[SweepRow]:
    times: dict[str, list[float]] = {each.simulator: [] for each in fleets}
    flown = {}
    for turn in range(turns + 1):
        for each in fleets:
            seconds, flown[each.simulator] = each.fly(count)
            if turn:  # the first one warms up
                times[each.simulator].append(seconds)
        print(f"  sweep of {count}, turn {turn} of {turns}", file=sys.stderr, flush=True)
    for each in fleets:
        own = times[each.simulator]
        rates = spread([count / seconds for seconds in own])
        often = ratios(own, times[OURS])
        yield SweepRow(each.simulator, count, flown[each.simulator], rates, often)


def _own(counts: tuple[int, ...]) -> Iterator[Fleet]:
    vehicle = load_vehicle(find_model("dh_drone"))
    usual = Rates()
    for name, rates in (
        (OURS, usual),
        (f"{OURS}, law at each step", Rates(control_period=usual.physics_step)),
    ):
        yield Fleet(name, counts, _compiled(RolloutEngine(vehicle, rates, threads=CORES)))


def _compiled(engine: RolloutEngine) -> Callable[[int], tuple[float, float]]:
    def fly(count: int) -> tuple[float, float]:
        gains = candidates(engine.gains, count)
        begun = time.perf_counter()
        steps = engine.measure(gains, "x", SPEED, duration=DURATION)
        seconds = time.perf_counter() - begun
        if np.isfinite(steps.diverged_at).any():
            raise RuntimeError("a candidate of the sweep was lost")
        return seconds, 1.0

    return fly


def _others(counts: tuple[int, ...], stack: ExitStack) -> Iterator[Fleet | Missing]:
    crazyflow = f"{version('crazyflow', 'crazyflow')}, 500 Hz"
    for title, name, devices in (
        (f"crazyflow as it comes, {crazyflow}", "crazyflow", 1),
        (f"crazyflow on two devices, {crazyflow}", "crazyflow", CORES),
        (f"RotorPy {version('rotorpy', 'rotorpy')}, 100 Hz", "rotorpy", 1),
    ):
        try:
            simulator = stack.enter_context(OtherSimulator(name, devices))
            whole = name == "crazyflow"
            yield Fleet(title, counts, _asking(simulator, whole))
        except NoSimulatorError as error:
            yield Missing(title, str(error))
    pool = ProcessPoolExecutor(CORES, mp_context=multiprocessing.get_context("spawn"))
    stack.enter_context(pool)

    def fly_diagrams(count: int) -> tuple[float, float]:
        flown = min(count, DIAGRAMS)
        begun = time.perf_counter()
        list(pool.map(fly_diagram, range(flown)))
        seconds = (time.perf_counter() - begun) * DURATION / (STEP_EDGE_S + DURATION)
        return seconds * count / flown, flown / count

    few = tuple(count for count in counts if count < max(COUNTS))
    yield Fleet("Drake diagrams in two processes", few, fly_diagrams)


def fly_diagram(index: int) -> float:
    """Fly a step on the full diagram, and return the time to which it came [s]."""
    scenario = step_scenario("x", SPEED, DURATION, Scenario())
    session = Session(scenario, {"kp_velocity_x": 4.0 + 0.01 * index})
    session.run()
    return session.time


def _asking(simulator: OtherSimulator, whole: bool) -> Callable[[int], tuple[float, float]]:
    def fly(count: int) -> tuple[float, float]:
        share = 1.0 if whole else 0.2 if count < max(COUNTS) else 0.1
        answer = simulator.ask("sweep", count=count, duration=share * DURATION)
        return answer["seconds"] / share, share

    return fly


if __name__ == "__main__":
    show(measure())
