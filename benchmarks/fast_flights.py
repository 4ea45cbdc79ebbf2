"""Compiled flights that continue from call to call: a batch of 1,024.

A batch flies closed loops in two threads, each drone with its own setpoint: physics at 1,024 Hz and
controller at 128 Hz. crazyflow does the same at its 500 Hz, with position control at 100 Hz: as it
comes, and with its worlds split over two devices, one for each core. Each flies first ten of its
own control periods a call, then one, with new commands in each call. Turns alternate. Ratios are of
seconds flown and of physics steps, in wall-clock time, and in processor time of all threads, which
depends less on other load: under high load, a program with more threads loses in wall-clock time.

A control period of one drone takes 280 ns of processor time in calls of a hundred periods, 300 in
calls of ten, and 390 in calls of one. It is one step of `runge_kutta5`, so six evaluations of the
motion, and one update of the law, which takes two fifths of it; "What limits" of
docs/performance.md has a profile. Physics steps are counted as those of earlier versions, eight in
a control period.

These changes were tried: four rotors in one loop (13 %, kept); blocks of 32 drones (4 %) and of 8
(half as fast); no counts of references to arrays, and vectors that begin at cache lines (38 %
together, kept); vectors of 512 bits (4 to 14 %; LLVM uses them where the processor has them).
"""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from simulators import NoSimulatorError, OtherSimulator, version
from spread import Spread, ratios, spread, text
from sweep import CORES, Missing

from workbench.design.rollout.batch import Batch

FLIGHTS = 1024
PERIODS = (10, 1)
"""Of control in a call to a batch."""
CALLS = 20
OURS = "Batch"
LAW_RATE = {OURS: 128.0, "crazyflow": 100.0}
PHYSICS_RATE = {OURS: 1024.0, "crazyflow": 500.0}
TURNS = 12


@dataclass(frozen=True)
class BatchRow:
    """How fast 1,024 flights go on.

    Attributes:
        flown_by: name and rate.
        periods: control periods a call.
        flown_a_second: seconds of all flights per second of wall-clock time.
        flown_for_a_second: the same per second of processor time.
        ours_as_fast: seconds flown by `Batch` relative to this one, in equal wall-clock time.
        ours_as_fast_by_processor: the same in equal processor time.
        steps_as_fast: physics steps of `Batch` relative to this one, in equal wall-clock time.
        steps_as_fast_by_processor: the same in equal processor time.
    """

    flown_by: str
    periods: int
    flown_a_second: Spread
    flown_for_a_second: Spread
    ours_as_fast: Spread
    ours_as_fast_by_processor: Spread
    steps_as_fast: Spread
    steps_as_fast_by_processor: Spread


@dataclass(frozen=True)
class FastFigures:
    """All figures.

    Attributes:
        batches: of many flights.
    """

    batches: list[BatchRow | Missing]


@dataclass(frozen=True)
class Fleet:
    """Many that go on.

    Attributes:
        flown_by: name in the table.
        law_rate: control periods a second.
        physics_rate: steps a second.
        fly: takes periods a call, and returns the seconds of `CALLS` calls, by the wall clock and
            of the processor.
    """

    flown_by: str
    law_rate: float
    physics_rate: float
    fly: Callable[[int], tuple[float, float]]


def measure(turns: int = TURNS) -> FastFigures:
    """Fly batches."""
    return FastFigures(list(_batches(turns)))


def show(figures: FastFigures) -> None:
    """Print the tables."""
    print(
        f"{'1,024 flights':34} periods   {'flown a second':28} {'ours as fast':22} "
        f"{'by processor':22} {'by steps':22} both"
    )
    for each in figures.batches:
        if isinstance(each, Missing):
            print(f"{each.simulator:34} {each.reason}")
        else:
            print(
                f"{each.flown_by:34} {each.periods:7d}   {text(each.flown_a_second):28} "
                f"{text(each.ours_as_fast):22} {text(each.ours_as_fast_by_processor):22} "
                f"{text(each.steps_as_fast):22} {text(each.steps_as_fast_by_processor)}"
            )


def _batches(turns: int) -> Iterator[BatchRow | Missing]:
    with ExitStack() as stack:
        ready = [_own(), *_others(stack)]
        fleets = [each for each in ready if isinstance(each, Fleet)]
        yield from (each for each in ready if isinstance(each, Missing))
        for periods in PERIODS:
            paces: dict[str, list[tuple[float, float]]] = {each.flown_by: [] for each in fleets}
            for turn in range(turns + 1):
                for each in fleets:
                    flown = FLIGHTS * CALLS * periods / each.law_rate
                    wall, processor = each.fly(periods)
                    if turn:  # the first one warms up
                        paces[each.flown_by].append((flown / wall, flown / processor))
            print(f"  batches, {periods} periods a call", file=sys.stderr, flush=True)
            ours = [*zip(*paces[OURS], strict=True)]
            for each in fleets:
                by = [*zip(*paces[each.flown_by], strict=True)]
                steps = [[pace * each.physics_rate for pace in own] for own in by]
                own_steps = [[pace * PHYSICS_RATE[OURS] for pace in own] for own in ours]
                often = (ratios(a, b) for a, b in zip(ours + own_steps, by + steps, strict=True))
                yield BatchRow(each.flown_by, periods, *map(spread, by), *often)


def _own() -> Fleet:
    batch = Batch(FLIGHTS, threads=CORES)
    aims = np.linspace(0.5, 1.5, FLIGHTS)
    assert batch.setpoint

    def fly(periods: int) -> tuple[float, float]:
        assert batch.setpoint
        batch.reset()
        begun, used = time.perf_counter(), time.process_time()
        for _ in range(CALLS):
            batch.setpoint.velocity[:, 0] = aims
            batch.step(periods)
        seconds = time.perf_counter() - begun, time.process_time() - used
        if batch.lost.any():
            raise RuntimeError("a flight of the batch was lost")
        return seconds

    return Fleet(OURS, LAW_RATE[OURS], PHYSICS_RATE[OURS], fly)


def _others(stack: ExitStack) -> Iterator[Fleet | Missing]:
    named = version("crazyflow", "crazyflow")
    for title, devices in (
        (f"crazyflow as it comes, {named}", 1),
        (f"crazyflow on two devices, {named}", CORES),
    ):
        try:
            simulator = stack.enter_context(OtherSimulator("crazyflow", devices))
            law, physics = LAW_RATE["crazyflow"], PHYSICS_RATE["crazyflow"]
            yield Fleet(title, law, physics, _asking(simulator))
        except NoSimulatorError as error:
            yield Missing(title, str(error))


def _asking(simulator: OtherSimulator) -> Callable[[int], tuple[float, float]]:
    def fly(periods: int) -> tuple[float, float]:
        duration = CALLS * periods / LAW_RATE["crazyflow"]
        answer = simulator.ask("steps", count=FLIGHTS, duration=duration, calls=CALLS)
        return answer["seconds"], answer["processor"]

    return fly


if __name__ == "__main__":
    show(measure())
