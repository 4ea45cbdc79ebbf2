"""Flights with given gains: steps, maps, sensitivities, forks, and logs that are flown again."""

import logging
import math
from collections.abc import Mapping
from concurrent.futures import wait
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from workbench.analysis.questions import DrawMap, FlyAgain, Fork, Predict, Step, Weigh
from workbench.analysis.replies import FlownAgain, Mapped, Predicted, StepNumbers, step_numbers
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.schedule import split_label
from workbench.design.branches import FlownBranch
from workbench.design.load_step import check_load, predict_load_step
from workbench.design.metrics import find_metric
from workbench.design.response_metrics import (
    LONGEST_DURATION,
    load_metrics,
    step_duration,
    step_metrics,
)
from workbench.design.step_response import check_duration, check_step
from workbench.design.sweep.ranges import SweepRange
from workbench.scenario.axes import AXES, find_axis

if TYPE_CHECKING:
    from collections.abc import Generator

    from workbench.design.judge.sensitivity import Sensitivity
    from workbench.design.predict.what_if import Explained, Law, WhatIf
    from workbench.design.rollout.engine import RolloutEngine
    from workbench.logs.flight_record import FlightRecord

LONGEST = 20.0
"""Longest allowed duration of a step [s]."""
PATIENCE = 0.005
"""Period between checks whether the engine is loaded [s]."""
POINTS = 25
"""Points along each axis; odd, so that the gains themselves are in the middle."""
NODES = 5
"""Linear models along each axis of a map."""
BAND = 2
"""Rows flown between checks for more urgent work; a range has two values."""
LONGEST_MAPPED = 10.0
"""Longest allowed duration of a map's step [s]: at this length a band takes 20 ms, for which
margins must wait."""
FACTOR = 2.0
"""The map covers a gain divided by this to the gain times this, within its limits."""
SHARE = 0.1
"""Share of a gain's largest value that a map covers if the gain is 0."""
PERCENT = 0.01
NOTHING = 1e-6
"""A slope below this share of the strongest one is rounding."""
SHOWN = 0.01
"""Sample time of a log that is flown again [s]; at least one control period."""
PLACES = (4, 5, 6, 10, 11, 12)
"""Indices of position and velocity in a state."""


def fork(subject: Subject, question: Fork, work: Work) -> Working:
    """Continue the flight from a checkpoint with each branch's values, to the bit."""
    flown = subject.forker.fly(
        question.checkpoint,
        question.branches,
        question.duration,
        question.step,
        lambda: work.stopped,
    )
    work.check()
    yield tuple((branch, _numbers(question, branch)) for branch in flown)


def _numbers(question: Fork, branch: FlownBranch) -> StepNumbers | None:
    """Return the metrics of a branch's step, which adds to the earlier command."""
    step, checkpoint = question.step, question.checkpoint
    if step is None or branch.lost:
        return None
    before = (*checkpoint.velocity, checkpoint.yaw_rate)[AXES.index(step.axis)]
    response = branch.response(step.axis) - before
    metrics = step_metrics(branch.time - checkpoint.time, response, step.amplitude)
    return step_numbers(metrics, float(branch.rotor_use.max()))


def predict(subject: Subject, question: Predict, _: Work) -> Working:
    """Predict the response to a step from hover at the step's heading.

    The air is that of the settings.
    """
    check_short(question.step)
    gains = subject.gains(question.gains)
    engine = yield from ready_engine(subject)
    step = question.step
    if step.is_load:
        time, response, use = predict_load_step(
            engine,
            gains,
            step.axis,
            step.amplitude,
            duration=step.duration,
            acts=step.acts,
            heading=step.heading,
        )
        numbers = step_numbers(load_metrics(time, response), use)
        yield Predicted(time, response, numbers, not np.isfinite(response).all())
        return
    decay = subject.decay_times.of(step.axis, subject.linear_gains(question.gains))
    # as long as `workbench step` flies it, so that the numbers are the same
    duration = step_duration(decay)
    duration = duration if duration <= LONGEST else step.duration
    flown = engine.fly(
        [gains],
        step.axis,
        step.amplitude,
        duration=max(duration, step.duration),
        heading=step.heading,
    )
    response, use = flown.response[0], float(flown.peak_rotor_use[0])
    measured = flown.time <= duration + 1e-9
    metrics = step_metrics(flown.time[measured], response[measured], step.amplitude, decay=decay)
    numbers, lost = step_numbers(metrics, use), not math.isnan(flown.diverged_at[0])
    shown = flown.time <= step.duration + 1e-9
    yield Predicted(flown.time[shown], response[shown], numbers, lost, decay)


def ready_engine(subject: Subject) -> "Generator[None, None, RolloutEngine]":
    """Yield None until the engine of compiled flights is loaded, then return it."""
    loading = subject.load_engine()
    while not loading.done():
        wait([loading], PATIENCE)
        yield None
    return loading.result()


def check_short(step: Step, longest: float = LONGEST) -> None:
    """Refuse a step that is too short for a flight, or too long to wait for.

    Raises:
        WorkbenchError: if it is either.
    """
    check = check_load if step.is_load else check_step
    check(step.axis, step.amplitude)
    check_duration(step.duration)
    if step.duration > longest:
        raise WorkbenchError(
            f"a step of {step.duration:g} s is too long to predict: give it {longest:g} s at most"
        )


def draw_map(subject: Subject, question: DrawMap, work: Work) -> Working:
    """Compute a metric around the given gains, from a compiled flight for each point."""
    from workbench.design.sweep.sweep import gain_map

    step = question.step
    check_short(step, LONGEST_MAPPED)
    gains = subject.gains(question.gains)
    names = (subject.flown.gain_of(name) for name in (question.x, question.y))
    x, y = (_around(subject, name, gains) for name in names)
    engine = yield from ready_engine(subject)
    values = np.full((y.points, x.points), np.nan)
    decay = _decay_map(subject, step.axis, gains, x, y)
    needed = float(decay[decay <= LONGEST_MAPPED].max(initial=0.0))
    duration = max(step.duration, needed)
    for first in range(0, y.points, BAND):
        work.check()
        start = min(first, y.points - BAND)  # the last band repeats a row of the one before
        low, *_, high = y.grid[start : start + BAND]
        band = gain_map(
            engine,
            gains,
            x,
            replace(y, low=float(low), high=float(high), points=BAND),
            metric=question.metric,
            axis=step.axis,
            amplitude=step.amplitude,
            duration=duration,
            heading=step.heading,
        )
        assert band is not None  # nothing can interrupt it
        values[start : start + BAND] = band.values
        yield None
    values[decay > duration] = np.nan  # they have not settled
    unit = find_metric(question.metric).unit_for(find_axis(step.axis).unit)
    yield Mapped(x.grid, y.grid, values, unit)


def _decay_map(
    subject: Subject, axis: str, gains: Mapping[str, float], x: SweepRange, y: SweepRange
) -> np.ndarray:
    """Return the decay time of each point of a map (N_y, N_x) [s], see `decay_time`.

    It is interpolated between `NODES` linear models along each axis, as each takes milliseconds.
    """
    known = {**subject.linear_gains({}), **gains}
    rows, columns = (np.linspace(0, each.points - 1, NODES).round().astype(int) for each in (y, x))
    nodes = np.empty((NODES, NODES))
    for j, row in enumerate(rows):
        for i, column in enumerate(columns):
            point = {x.name: float(x.grid[column]), y.name: float(y.grid[row])}
            nodes[j, i] = subject.decay_times.of(axis, {**known, **point})
    nodes = np.log(np.clip(nodes, SHOWN, 2.0 * LONGEST_DURATION))  # infinite: beyond any step
    across = np.array([np.interp(np.arange(x.points), columns, row) for row in nodes])
    found = [np.interp(np.arange(y.points), rows, column) for column in across.T]
    return np.exp(np.array(found).T)


def _around(subject: Subject, name: str, gains: dict[str, float]) -> SweepRange:
    """Return values of a gain around its own."""
    if name not in subject.law:
        raise unknown_name("gain", name, subject.law)
    row, own = subject.table.find(name), gains[name]
    if own <= 0.0:
        return SweepRange(name, row.minimum, SHARE * row.maximum, POINTS)
    low, high = max(own / FACTOR, row.minimum), min(own * FACTOR, row.maximum)
    return SweepRange(name, low, high, POINTS, log=True)


def weigh(subject: Subject, question: Weigh, work: Work) -> Working:
    """Compute the effect of a percent more of each gain on each metric of a step."""
    from workbench.design.judge.sensitivity import step_sensitivity

    step = question.step
    check_short(step)
    found = step_sensitivity(
        step.axis,
        step.amplitude,
        duration=step.duration,
        heading=step.heading,
        scenario=subject.judged,
        settings=subject.gains(question.gains),
        progress=work.check,
    )
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    yield {
        each.metric: {names.get(name, name): slope for name, slope in _slopes(each, gains).items()}
        for each in found
    }


def _slopes(sensitivity: "Sensitivity", gains: dict[str, float]) -> dict[str, float]:
    """Return the effects of gains on a metric, the strongest first, without those that have none.

    A metric of 0, as an undershoot without reversal, has no slopes: they would be rounding.
    """
    if not sensitivity.value:
        return {}
    slopes = {name: PERCENT * gains[name] * each for name, each in sensitivity.derivatives.items()}
    known = {name: slope for name, slope in slopes.items() if math.isfinite(slope)}
    least = NOTHING * max(map(abs, known.values()), default=0.0)
    acting = [(name, slope) for name, slope in known.items() if abs(slope) > least]
    return dict(sorted(acting, key=lambda each: -abs(each[1])))


def fly_again(subject: Subject, question: FlyAgain, _: Work) -> Working:
    """Fly a logged flight again with other gains, or with another law.

    The part of the log that the vehicles cannot explain is kept, so that the next gains take one
    flight per vehicle.
    """
    flight, explained = _read_log(subject, question)
    flights: list[np.ndarray] = []
    for states in islice(explained.flights(_other_law(subject, question)), 1 + question.draws):
        flights.append(states)
        yield None
    yield _flown_again(flight, explained, explained.compare(flights))


def _read_log(subject: Subject, question: FlyAgain) -> "tuple[FlightRecord, Explained]":
    """Return a log and the part that the vehicle cannot explain; cached while the file is the same.

    Raises:
        WorkbenchError: if it cannot be read or flown again.
    """
    from workbench.design.predict.what_if import Explained
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.motion import flown_law, law_name, motion_of

    path = question.log
    try:
        status = path.stat()
    except OSError as error:
        raise WorkbenchError(f"{path} cannot be read: {error.strerror}") from error
    key = (path, status.st_mtime_ns, status.st_size, question.flown)
    if subject.log is not None and subject.log[0] == key:
        return subject.log[1:]
    logging.getLogger(PROGRESS_LOGGER).warning(f"reading {path.name}")
    flight, vehicle = read_flight(path), subject.study.vehicle
    name = question.flown or law_name(flight, {subject.flown.name: subject.flown.reference})
    if not name:
        raise WorkbenchError(f"{path.name} does not say which controller flew: choose it")
    values = {}
    if split_label(name)[0] == split_label(subject.flown.reference)[0]:
        values = {each: subject.own[each] for each in subject.law}
    law = flown_law(flight, vehicle, name, values)
    explained = Explained(motion_of(flight, vehicle), vehicle, law)
    subject.log = key, flight, explained
    return flight, explained


def _other_law(subject: Subject, question: FlyAgain) -> "Law":
    from workbench.design.predict.what_if import Law

    if question.controller:
        other = subject.other(question.controller)
        return Law(other.flown, other.own)
    return Law(subject.flown, subject.flown_gains(question.gains))


def _flown_again(flight: "FlightRecord", explained: "Explained", found: "WhatIf") -> FlownAgain:
    law, other = explained.flown, found.other[:, PLACES]
    other[found.stays :] = np.nan
    period = float(found.time[1] - found.time[0])
    kept = slice(None, None, max(1, round(SHOWN / period)))
    return FlownAgain(
        vehicle=explained.vehicle.name,
        logged_vehicle=str(flight.parameters.get("vehicle", "")),
        doubt=explained.doubt,
        flown=law.controller.name,
        flown_gains={row.name: law.gains[row.name] for row in law.controller.parameters},
        time=found.time[kept],
        setpoint=found.setpoint[kept],
        logged=found.logged[kept][:, PLACES],
        other=other[kept],
        low=found.low[kept],
        high=found.high[kept],
        off_setpoint=found.off_setpoint,
        difference=np.sqrt(np.mean(found.difference**2, axis=0)),
        band=0.5 * np.mean(found.high - found.low, axis=0),
        stays=found.stays == len(found.time),
        lost=found.lost,
        drawn=found.drawn,
    )
