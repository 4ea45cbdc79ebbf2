"""Do margins follow a slider while a flight with sensors runs?

A live flight with lidar, IMU, GPS and barometer in an obstacle field runs in one process, the
analyst in another. Margins and poles of nine loops are requested again as soon as they are
answered. In a second test, a moving slider also requests a prediction, a map and the stable ranges
sixty times a second, as on the Tuning screen. There must be at least 20 answers a second, with the
flight in real time. Turns with and without the flight alternate.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from spread import Spread, spread

from workbench.analysis.analyst import Analyst
from workbench.analysis.queries import (
    DrawFrequency,
    DrawMap,
    FindRanges,
    Judge,
    Predict,
    Query,
    RequestedStep,
)
from workbench.ipc.worker_process import SupersededError
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Scenario, SensorsConfig

WANTED = 20.0
"""Answers a second."""
OTHERS = (DrawFrequency, Predict, DrawMap, FindRanges)
SECONDS = 3.0
TURNS = 5
SLIDER = 1 / 60
"""Between two values of a slider that moves [s]."""
STEP = RequestedStep("x", 2.0, 2.0)
FLOWN = Scenario(
    world="obstacle_field",
    sensors=SensorsConfig(use=["imu", "gps", "lidar", "barometer"]),
)


@dataclass(frozen=True)
class AnalystRow:
    """How margins follow.

    Attributes:
        beside: what else runs.
        answers: answers of margins and poles a second.
        to_wanted: the same relative to the required 20.
        longest: longest time from a question to its answer in a turn [s].
        others: other answers a second.
        real_time_factor: real-time factor of the flight; 0 without one.
    """

    beside: str
    answers: Spread
    to_wanted: Spread
    longest: Spread
    others: Spread
    real_time_factor: Spread


@dataclass(frozen=True)
class KindRow:
    """How often one kind is answered beside a flight and a slider, frequency curves among them.

    To hold: 20 a second of curves and of predictions, too.

    Attributes:
        kind: of the question.
        rate: answers, a second.
    """

    kind: str
    rate: Spread


@dataclass(frozen=True)
class AnalystFigures:
    """All figures.

    Attributes:
        rows: by what goes on beside.
        kinds: the others, by kind.
        first: from the first question, with which the process is started, to its answer [s].
        unasked: real-time factor of the flight while nothing is asked.
    """

    rows: list[AnalystRow]
    kinds: list[KindRow]
    first: float
    unasked: Spread


@dataclass(frozen=True)
class _Turn:
    """Some seconds of asking."""

    answers: float
    longest: float
    others: dict[type, float]
    factor: float


def measure() -> AnalystFigures:
    """Ask alone, beside a flight, and beside a flight with a slider that never rests."""
    analyst = Analyst(FLOWN, {})
    try:
        began = time.perf_counter()
        analyst.ask(Judge({})).result()
        first = time.perf_counter() - began
        for question in _others(100.0):
            analyst.ask(question).result()
        unasked: list[float] = []
        turns: dict[str, list[_Turn]] = {"nothing": [], "a flight": [], "a flight and a slider": []}
        for _ in range(TURNS):
            turns["nothing"].append(_turn(analyst, None, _rest))
            with LiveFlight(FLOWN, stream=True) as flight:
                flight.wait()
                unasked.append(_unasked(flight))
                turns["a flight"].append(_turn(analyst, flight, _rest))
                turns["a flight and a slider"].append(_turn(analyst, flight, _slide))
    finally:
        analyst.close()
    return AnalystFigures(
        [_row(beside, each) for beside, each in turns.items()],
        [_kind(kind, turns["a flight and a slider"]) for kind in OTHERS],
        *(first, spread(unasked)),
    )


def show(figures: AnalystFigures) -> None:
    """Print the table."""
    print(f"analyst: the first margins after {figures.first:.2f} s; then, a second:")
    print(f"  (the flight is at {figures.unasked.median:.3f} while nothing is asked)")
    for row in figures.rows:
        print(
            f"  beside {row.beside:22} {row.answers.median:7.1f} answers, "
            f"{row.to_wanted.median:5.2f} of what is wanted, the longest after "
            f"{1e3 * row.longest.median:5.1f} ms, {row.others.median:6.1f} others, "
            f"flight at {row.real_time_factor.median:.3f}"
        )
    for kind in figures.kinds:
        print(f"  beside a flight and a slider: {kind.kind:14} {kind.rate.median:6.1f}")


def _kind(kind: type, turns: list[_Turn]) -> KindRow:
    return KindRow(kind.__name__, spread([turn.others.get(kind, 0.0) for turn in turns]))


def _row(beside: str, turns: list[_Turn]) -> AnalystRow:
    answers = [turn.answers for turn in turns]
    return AnalystRow(
        beside=beside,
        answers=spread(answers),
        to_wanted=spread([each / WANTED for each in answers]),
        longest=spread([turn.longest for turn in turns]),
        others=spread([sum(turn.others.values()) for turn in turns]),
        real_time_factor=spread([turn.factor for turn in turns]),
    )


def _turn(
    analyst: Analyst,
    flight: LiveFlight | None,
    beside: Callable[[Analyst, threading.Event], Counter],
) -> _Turn:
    """Ask for margins as often as they are answered, and let something go on beside."""
    over = threading.Event()
    counted = [Counter()]

    def go_on() -> None:
        counted[0] = beside(analyst, over)

    thread = threading.Thread(target=go_on)
    thread.start()
    flown = _flown(flight)
    began = time.perf_counter()
    waited = []
    while time.perf_counter() - began < SECONDS:
        asked = time.perf_counter()
        with suppress(SupersededError):
            analyst.ask(Judge({"kp_pitch": 150.0 + len(waited) % 50})).result()
            waited.append(time.perf_counter() - asked)
    spent = time.perf_counter() - began
    factor = (_flown(flight) - flown) / spent
    over.set()
    thread.join()
    others = {kind: count / spent for kind, count in counted[0].items()}
    return _Turn(len(waited) / spent, max(waited), others, factor)


def _unasked(flight: LiveFlight) -> float:
    """Return the real-time factor of a flight while nothing is asked."""
    flown, began = _flown(flight), time.perf_counter()
    time.sleep(SECONDS)
    return (_flown(flight) - flown) / (time.perf_counter() - began)


def _flown(flight: LiveFlight | None) -> float:
    """Return the time that was flown so far [s]."""
    snapshot = flight.latest().snapshot if flight else None
    return snapshot.time if snapshot else 0.0


def _rest(_: Analyst, over: threading.Event) -> Counter:
    over.wait()
    return Counter()


def _slide(analyst: Analyst, over: threading.Event) -> Counter:
    """Ask for all the rest as a moving slider does; return how often each kind was answered."""
    asked: list[tuple[type, Future[Any]]] = []
    value = 150.0
    while not over.wait(SLIDER):
        value = 150.0 + (value - 149.0) % 100.0
        asked += [(type(each), analyst.ask(each)) for each in _others(value)]
    return Counter(kind for kind, reply in asked if reply.done() and reply.exception() is None)


def _others(value: float) -> list[Query]:
    gains = {"kp_pitch": value}
    return [
        DrawFrequency(gains, "pitch"),
        Predict(gains, STEP),
        DrawMap(gains, "kp_pitch", "kd_pitch", "overshoot", STEP),
        FindRanges(gains),
    ]


if __name__ == "__main__":
    show(measure())
