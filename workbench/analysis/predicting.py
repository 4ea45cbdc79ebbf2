"""Flights with given gains: steps, maps, sensitivities and forks."""

import math
from collections.abc import Mapping
from concurrent.futures import wait
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from workbench.analysis.queries import (
    DrawMap,
    Fork,
    Predict,
    RequestedStep,
    Sensitivities,
)
from workbench.analysis.replies import Mapped, Predicted
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.design.attitude_step import predict_attitude_step
from workbench.design.branches import FlownBranch
from workbench.design.load_metrics import load_metrics
from workbench.design.load_step import predict_load_step
from workbench.design.metrics import find_metric
from workbench.design.step_metrics import MAX_AUTO_STEP_S, StepMetrics, step_duration, step_metrics
from workbench.design.step_response import check_amplitude, check_duration
from workbench.design.sweep.ranges import SweepRange
from workbench.scenario.axes import AXIS_NAMES, find_axis
from workbench.scenario.loads import find_excited

if TYPE_CHECKING:
    from collections.abc import Generator

    from workbench.design.judge.sensitivity import Sensitivity
    from workbench.design.rollout.engine import RolloutEngine

MAX_ANSWERED_STEP_S = 20.0
"""Longest allowed duration of a step [s]."""
ENGINE_POLL_PERIOD_S = 0.005
"""Period between checks whether the engine is loaded [s]."""
GAIN_MAP_POINTS = 25
"""Points along each axis; odd, so that the gains themselves are in the middle."""
GAIN_MAP_MODELS = 5
"""Linear models along each axis of a map."""
GAIN_MAP_ROWS_PER_BATCH = 2
"""Rows flown between checks for more urgent work; a range has two values."""
MAX_MAPPED_STEP_S = 10.0
"""Longest allowed duration of a map's step [s]: at this length a band takes 20 ms, for which
margins must wait."""
GAIN_MAP_FACTOR = 2.0
"""The map covers a gain divided by this to the gain times this, within its limits."""
GAIN_MAP_ZERO_SHARE = 0.1
"""Share of a gain's largest value that a map covers if the gain is 0."""
ONE_PERCENT = 0.01
MIN_RELATIVE_SLOPE = 1e-6
"""A slope below this share of the strongest one is rounding."""
MIN_DECAY_TIME_S = 0.01
"""Shortest decay time in a map [s]."""


def fork(subject: AnalysedVehicle, question: Fork, work: Work) -> Working:
    """Continue the flight from a checkpoint with each branch's values, to the bit."""
    flown = subject.forker.fly(
        question.checkpoint,
        question.branches,
        question.duration,
        question.step,
        lambda: work.stopped,
    )
    work.check()
    yield tuple((branch, _branch_numbers(question, branch)) for branch in flown)


def _branch_numbers(question: Fork, branch: FlownBranch) -> StepMetrics | None:
    """Return the metrics of a branch's step, which adds to the earlier command."""
    step, checkpoint = question.step, question.checkpoint
    if step is None or branch.lost:
        return None
    before = (*checkpoint.velocity, checkpoint.yaw_rate)[AXIS_NAMES.index(step.axis)]
    response = branch.response(step.axis) - before
    return step_metrics(
        branch.time - checkpoint.time,
        response,
        step.amplitude,
        peak_rotor_use=float(branch.rotor_use.max()),
    )


def predict(subject: AnalysedVehicle, question: Predict, _: Work) -> Working:
    """Predict the response to a step from hover at the step's heading.

    The air is that of the settings; in wind the response is relative to the steady drift before it,
    see `fly_step`. A step of attitude or rate is predicted by the linear model.
    """
    check_short(question.step)
    if question.step.is_attitude:
        yield _predicted_attitude(subject, question)
        return
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
        numbers = load_metrics(time, response, peak_rotor_use=use)
        yield Predicted(time, response, numbers, not np.isfinite(response).all())
        return
    decay = subject.decay_times.of(step.axis, subject.linear_gains(question.gains))
    # as long as `workbench step` flies it, so that the numbers are the same
    duration = step_duration(decay)
    duration = duration if duration <= MAX_ANSWERED_STEP_S else step.duration
    flown = engine.fly(
        [gains],
        step.axis,
        step.amplitude,
        duration=max(duration, step.duration),
        heading=step.heading,
    )
    response, use = flown.response[0], float(flown.peak_rotor_use[0])
    measured = flown.time <= duration + 1e-9
    numbers = step_metrics(
        flown.time[measured],
        response[measured],
        step.amplitude,
        decay=decay,
        unsteady=flown.unsteady.get(0, ""),
        peak_rotor_use=use,
    )
    lost = not math.isnan(flown.diverged_at[0])
    shown = flown.time <= step.duration + 1e-9
    yield Predicted(flown.time[shown], response[shown], numbers, lost, decay)


def _predicted_attitude(subject: AnalysedVehicle, question: Predict) -> Predicted:
    """Return the response of the linear model to a step of a setpoint of attitude or rate."""
    step, models = question.step, subject.decay_times
    gains = subject.linear_gains(question.gains)
    time, response = predict_attitude_step(models, step.axis, step.amplitude, step.duration, gains)
    return Predicted(time, response, step_metrics(time, response, step.amplitude), lost=False)


def ready_engine(subject: AnalysedVehicle) -> "Generator[None, None, RolloutEngine]":
    """Yield None until the engine of compiled flights is loaded, then return it."""
    loading = subject.load_engine()
    while not loading.done():
        wait([loading], ENGINE_POLL_PERIOD_S)
        yield None
    return loading.result()


def check_short(step: RequestedStep, longest: float = MAX_ANSWERED_STEP_S) -> None:
    """Refuse a step that is too short for a flight, or too long to wait for.

    Raises:
        WorkbenchError: if it is either.
    """
    find_excited(step.axis)
    check_amplitude(step.amplitude)
    check_duration(step.duration)
    if step.duration > longest:
        raise WorkbenchError(
            f"a step of {step.duration:g} s is too long to predict: give it {longest:g} s at most"
        )


def draw_map(subject: AnalysedVehicle, question: DrawMap, work: Work) -> Working:
    """Compute a metric around the given gains, from a compiled flight for each point."""
    from workbench.design.sweep.sweep import gain_map

    step = question.step
    check_short(step, MAX_MAPPED_STEP_S)
    gains = subject.gains(question.gains)
    names = (subject.flown.gain_of(name) for name in (question.x, question.y))
    x, y = (_gain_map_range(subject, name, gains) for name in names)
    engine = yield from ready_engine(subject)
    values = np.full((y.points, x.points), np.nan)
    decay = _decay_map(subject, step.axis, gains, x, y)
    needed = float(decay[decay <= MAX_MAPPED_STEP_S].max(initial=0.0))
    duration = max(step.duration, needed)
    for first in range(0, y.points, GAIN_MAP_ROWS_PER_BATCH):
        work.check()
        start = min(
            first, y.points - GAIN_MAP_ROWS_PER_BATCH
        )  # the last band repeats a row of the one before
        low, *_, high = y.grid[start : start + GAIN_MAP_ROWS_PER_BATCH]
        band = gain_map(
            engine,
            gains,
            x,
            replace(y, low=float(low), high=float(high), points=GAIN_MAP_ROWS_PER_BATCH),
            metric=question.metric,
            axis=step.axis,
            amplitude=step.amplitude,
            duration=duration,
            heading=step.heading,
        )
        assert band is not None  # nothing can interrupt it
        values[start : start + GAIN_MAP_ROWS_PER_BATCH] = band.values
        yield None
    values[decay > duration] = np.nan  # they have not settled
    unit = find_metric(question.metric).unit_for(find_axis(step.axis).unit)
    yield Mapped(x.grid, y.grid, values, unit)


def _decay_map(
    subject: AnalysedVehicle, axis: str, gains: Mapping[str, float], x: SweepRange, y: SweepRange
) -> np.ndarray:
    """Return the decay time of each point of a map (N_y, N_x) [s], see `decay_time`.

    It is interpolated between `GAIN_MAP_MODELS` linear models along each axis, as each takes
    milliseconds.
    """
    known = {**subject.linear_gains({}), **gains}
    rows, columns = (
        np.linspace(0, each.points - 1, GAIN_MAP_MODELS).round().astype(int) for each in (y, x)
    )
    nodes = np.empty((GAIN_MAP_MODELS, GAIN_MAP_MODELS))
    for j, row in enumerate(rows):
        for i, column in enumerate(columns):
            point = {x.name: float(x.grid[column]), y.name: float(y.grid[row])}
            nodes[j, i] = subject.decay_times.of(axis, {**known, **point})
    nodes = np.log(
        np.clip(nodes, MIN_DECAY_TIME_S, 2.0 * MAX_AUTO_STEP_S)
    )  # infinite: beyond any step
    across = np.array([np.interp(np.arange(x.points), columns, row) for row in nodes])
    found = [np.interp(np.arange(y.points), rows, column) for column in across.T]
    return np.exp(np.array(found).T)


def _gain_map_range(subject: AnalysedVehicle, name: str, gains: dict[str, float]) -> SweepRange:
    """Return values of a gain around its own."""
    if name not in subject.law:
        raise unknown_name(f"parameter of {subject.controller.name}", name, subject.law)
    row, own = subject.table.find(name), gains[name]
    if own <= 0.0:
        return SweepRange(name, row.minimum, GAIN_MAP_ZERO_SHARE * row.maximum, GAIN_MAP_POINTS)
    low, high = max(own / GAIN_MAP_FACTOR, row.minimum), min(own * GAIN_MAP_FACTOR, row.maximum)
    return SweepRange(name, low, high, GAIN_MAP_POINTS, log=True)


def weigh(subject: AnalysedVehicle, question: Sensitivities, work: Work) -> Working:
    """Compute the effect of a percent more of each gain on each metric of a step."""
    from workbench.design.judge.sensitivity import step_sensitivity

    step = question.step
    check_short(step)
    found = step_sensitivity(
        step.axis,
        step.amplitude,
        duration=step.duration,
        heading=step.heading,
        scenario=subject.setup,
        settings=subject.gains(question.gains),
        progress=work.check,
    )
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    yield {
        each.metric: {
            names.get(name, name): slope for name, slope in _ranked_slopes(each, gains).items()
        }
        for each in found
    }


def _ranked_slopes(sensitivity: "Sensitivity", gains: dict[str, float]) -> dict[str, float]:
    """Return the effects of gains on a metric, the strongest first, without those that have none.

    A metric of 0, as an undershoot without reversal, has no slopes: they would be rounding.
    """
    if not sensitivity.value:
        return {}
    slopes = {
        name: ONE_PERCENT * gains[name] * each for name, each in sensitivity.derivatives.items()
    }
    known = {name: slope for name, slope in slopes.items() if math.isfinite(slope)}
    least = MIN_RELATIVE_SLOPE * max(map(abs, known.values()), default=0.0)
    acting = [(name, slope) for name, slope in known.items() if abs(slope) > least]
    return dict(sorted(acting, key=lambda each: -abs(each[1])))
