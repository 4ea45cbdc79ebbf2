"""Fly candidates on the full Drake diagram, in local processes or on a cluster."""

import dataclasses
import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Self

import numpy as np

from workbench.common.errors import FlightBrokenError
from workbench.design.executor.executor import Executor, all_cores
from workbench.design.lost import find_loss
from workbench.design.metrics import FLOWN
from workbench.design.response_metrics import step_metrics
from workbench.design.step_response import EDGE, axis_velocity, step_scenario
from workbench.design.sweep.case import Candidate, Flown, Progress, Stop, SweepCase, nothing_flown
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
        executor: runs the flights; None for a local process for each core.

    Raises:
        WorkbenchError: if a candidate cannot be built, or a process is lost.
    """
    flown = nothing_flown(len(candidates))
    tasks = [StepFlight(case, candidate) for candidate in candidates]
    found = (executor or all_cores()).run(tasks, stop)
    for count, (index, result) in enumerate(found, start=1):
        flown.values[index], flown.diverged_at[index] = result
        flown.done[index] = True
        if progress:
            progress(count / len(candidates))
    return flown


@dataclass(frozen=True)
class StepFlight:
    """The flight of one candidate, to run anywhere; see `executor.Task`."""

    case: SweepCase
    candidate: Candidate

    @property
    def scenario(self) -> Scenario:
        """The scenario with the files to read for it."""
        return self.case.scenario

    def with_scenario(self, scenario: Scenario) -> Self:
        """Return the same flight, with the files of a scenario."""
        return dataclasses.replace(self, case=dataclasses.replace(self.case, scenario=scenario))

    def run(self) -> tuple[list[float], float]:
        """Return the result of `fly_one`, without remarks, as the caller has logged them."""
        with _quietly():
            return fly_one(self.case, self.candidate)


def fly_one(case: SweepCase, candidate: Candidate) -> tuple[list[float], float]:
    """Fly one candidate on the full diagram.

    Returns:
        Its metrics, see `metrics.FLOWN`, and the time from the edge to its loss [s], or NaN.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    scenario = step_scenario(case.axis, case.amplitude, case.duration, case.scenario)
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
    metrics = step_metrics(after.time - EDGE, axis_velocity(after, case.axis), case.amplitude)
    return [*metrics.numbers.values(), float(after.rotor_use.max())], lost


def lost_at(recording: Recording) -> float:
    """Return the time from the edge of a step to the loss [s]; 0 if before, NaN if never."""
    loss = find_loss(recording)
    return max(0.0, loss.time - EDGE) if loss else float("nan")


@contextmanager
def _quietly() -> Iterator[None]:
    """Log only errors."""
    logger = logging.getLogger("workbench")
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(before)
