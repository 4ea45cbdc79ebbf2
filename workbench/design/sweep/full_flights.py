"""Fly candidates on the full Drake diagram, in local processes or on a cluster."""

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.design.executor.executor import Executor, Task, all_cores, without_remarks
from workbench.design.flier import DIAGRAM, Flier
from workbench.design.flown_step import STEP_EDGE_S, axis_velocity
from workbench.design.linear_step import DecayTimes
from workbench.design.lost import find_loss
from workbench.design.metrics import FLOWN_METRICS
from workbench.design.steady_drift import fly_from_rest
from workbench.design.step_metrics import step_duration, step_metrics
from workbench.design.step_response import step_scenario
from workbench.design.sweep.case import FlownPart, Stop, SweepCandidate, SweepCase
from workbench.scenario.scenario import Scenario
from workbench.session.drift import MAX_HOVER_S, air_moves
from workbench.session.recording import Recording
from workbench.setup import Setup, make_setup


def fly_full(
    case: SweepCase,
    setup: Setup,
    candidates: Sequence[SweepCandidate],
    stop: Stop | None = None,
    *,
    executor: Executor | None = None,
) -> Iterator[FlownPart]:
    """Fly candidates on the full diagram, about a second each; yield them as they end.

    A flight is the same to the bit wherever it runs. Local processes are spawned, so a script that
    calls this needs `if __name__ == "__main__":`.

    Args:
        case: the step.
        setup: of the case; each process makes its own.
        candidates: (N) to fly.
        stop: True ends the work with the results so far.
        executor: runs the flights; None for a local process for each core.

    Raises:
        WorkbenchError: if a candidate cannot be built, or a process is lost.
    """
    del setup
    tasks = [Task(case.scenario, _fly_quietly, (case, candidate)) for candidate in candidates]
    for index, (values, diverged_at) in (executor or all_cores()).run(tasks, stop):
        yield [index], np.array([values]), np.array([diverged_at])


def _fly_quietly(
    scenario: Scenario, case: SweepCase, candidate: SweepCandidate
) -> tuple[list[float], float]:
    """Return the result of `fly_one`, without remarks, as the caller has logged them."""
    with without_remarks():
        return fly_one(dataclasses.replace(case, scenario=scenario), candidate)


def fly_one(case: SweepCase, candidate: SweepCandidate) -> tuple[list[float], float]:
    """Fly one candidate on the full diagram.

    Returns:
        Its metrics, see `FLOWN_METRICS`, and the time from the edge to its loss [s], or NaN.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    setup = make_setup(case.scenario, candidate.settings).varied(candidate.variation)
    decay = DecayTimes(setup).of(case.axis)
    duration = step_duration(decay) if case.duration is None else case.duration
    scenario = step_scenario(case.axis, case.amplitude, duration, setup.scenario)
    if candidate.seed is not None:
        scenario.sensors.seed = candidate.seed
    flier = Flier(setup.with_scenario(scenario), fly_on=DIAGRAM)
    hover = MAX_HOVER_S if air_moves(setup.values) else 0.0
    try:
        started = fly_from_rest(
            flier, setup, case.axis, case.amplitude, duration, hover, programs=False
        )
        broken, recording = float("nan"), started.flown.recording
    except FlightBrokenError:
        broken, recording = max(0.0, flier.session.time - STEP_EDGE_S), flier.session.recording()
    edge = STEP_EDGE_S if np.isfinite(broken) else started.edge
    lost = loss_time(recording, edge)
    lost = broken if np.isnan(lost) else lost
    if not np.isnan(lost):
        return [float("nan")] * len(FLOWN_METRICS), lost
    after = recording.between(edge, np.inf)
    response = axis_velocity(after, case.axis)
    metrics = step_metrics(
        after.time - edge,
        response - (response[0] if edge > STEP_EDGE_S else 0.0),
        case.amplitude,
        decay=decay,
        rests=started.rests,
        unsteady=started.unsteady,
        peak_rotor_use=float(after.rotor_use.max()),
    )
    return [getattr(metrics, row.name) for row in FLOWN_METRICS], lost


def loss_time(recording: Recording, edge: float = STEP_EDGE_S) -> float:
    """Return the time from the edge [s] of a step to the loss [s]; 0 if before, NaN if never."""
    loss = find_loss(recording)
    return max(0.0, loss.time - edge) if loss else float("nan")
