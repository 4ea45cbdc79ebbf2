"""Fly candidates on the full Drake diagram, in local processes or on a cluster."""

import dataclasses
import logging
from collections.abc import Sequence

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.design.executor.executor import Executor, Task, all_cores
from workbench.design.linear_step import DecayTimes
from workbench.design.lost import find_loss
from workbench.design.metrics import FLOWN
from workbench.design.response_metrics import step_duration, step_metrics
from workbench.design.step_response import EDGE, axis_velocity, step_scenario
from workbench.design.sweep.case import (
    Candidate,
    Flown,
    Keep,
    Progress,
    Stop,
    SweepCase,
    nothing_flown,
)
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.session.recording import Recording
from workbench.session.session import Session


def fly_full(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
    keep: Keep | None = None,
    *,
    executor: Executor | None = None,
) -> Flown:
    """Fly candidates on the full diagram; about a second each.

    A flight is the same to the bit wherever it runs. Local processes are spawned, so a script that
    calls this needs `if __name__ == "__main__":`.

    Args:
        case: the step.
        vehicle: as known to its controller.
        candidates: (N) to fly.
        progress: called with the share done.
        stop: True ends the work with the results so far.
        keep: called with each flight, in the order of their ends.
        executor: runs the flights; None for a local process for each core.

    Raises:
        WorkbenchError: if a candidate cannot be built, or a process is lost.
    """
    flown = nothing_flown(len(candidates))
    tasks = [Task(case.scenario, _fly_quietly, (case, candidate)) for candidate in candidates]
    found = (executor or all_cores()).run(tasks, stop)
    for count, (index, result) in enumerate(found, start=1):
        flown.values[index], flown.diverged_at[index] = result
        flown.done[index] = True
        if keep:
            keep(index, flown.values[index], flown.diverged_at[index])
        if progress:
            progress(count / len(candidates))
    return flown


def _fly_quietly(
    scenario: Scenario, case: SweepCase, candidate: Candidate
) -> tuple[list[float], float]:
    """Return the result of `fly_one`, without remarks, as the caller has logged them."""
    logger = logging.getLogger("workbench")
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        return fly_one(dataclasses.replace(case, scenario=scenario), candidate)
    finally:
        logger.setLevel(before)


def fly_one(case: SweepCase, candidate: Candidate) -> tuple[list[float], float]:
    """Fly one candidate on the full diagram.

    Returns:
        Its metrics, see `metrics.FLOWN`, and the time from the edge to its loss [s], or NaN.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    decay = DecayTimes(case.scenario).of(case.axis, candidate.settings, candidate.variation)
    duration = step_duration(decay) if case.duration is None else case.duration
    scenario = step_scenario(case.axis, case.amplitude, duration, case.scenario)
    scenario.vehicle = dataclasses.replace(scenario.vehicle, variation=candidate.variation)
    if candidate.seed is not None:
        scenario.sensors.seed = candidate.seed
    session = Session(scenario, dict(candidate.settings))
    try:
        session.run()
        broken = float("nan")
    except FlightBrokenError:
        broken = max(0.0, session.time - EDGE)
    recording = session.recording()
    lost = lost_at(recording)
    lost = broken if np.isnan(lost) else lost
    after = recording.between(EDGE, np.inf)
    if not np.isnan(lost):
        return [float("nan")] * len(FLOWN), lost
    response = axis_velocity(after, case.axis)
    metrics = step_metrics(after.time - EDGE, response, case.amplitude, decay=decay)
    return [*metrics.numbers.values(), float(after.rotor_use.max())], lost


def lost_at(recording: Recording) -> float:
    """Return the time from the edge of a step to the loss [s]; 0 if before, NaN if never."""
    loss = find_loss(recording)
    return max(0.0, loss.time - EDGE) if loss else float("nan")
