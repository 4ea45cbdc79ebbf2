"""Candidates flown by the compiled engine, thousands a second."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.metrics import rollout_metrics
from workbench.design.rollout.rollouts import Rollouts
from workbench.design.sweep.case import Candidate, SweepCase
from workbench.design.sweep.flown import Flown, Progress, Stop, nothing_flown
from workbench.design.sweep.metrics import FLOWN
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle

BATCH = 1024
"""Candidates whose curves are kept at a time; each takes 20 kB."""


def fly_compiled(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Flown:
    """Fly candidates on the compiled engine, two at a time.

    Args:
        case: the step.
        vehicle: as its controller knows it.
        candidates: (N) what is flown.
        progress: called with the share done.
        stop: True ends with what is done.
    """
    flown = nothing_flown(len(candidates))
    own = case.values(vehicle)
    finished = 0
    engine = RolloutEngine(vehicle, case.scenario.rates, seed=case.scenario.sensors.seed)
    for variation, indices in _batches(candidates):

        def tell(share: float, before: int = finished, size: int = len(indices)) -> None:
            if progress:
                progress((before + share * size) / len(candidates))

        rollouts = engine.varied(variation).fly(
            [{**own, **candidates[index].settings} for index in indices],
            case.axis,
            case.amplitude,
            duration=case.duration,
            progress=tell,
            stop=stop,
        )
        _note(rollouts, case.amplitude, np.array(indices)[: len(rollouts)], flown)
        finished += len(rollouts)
        if len(rollouts) < len(indices) or (stop and stop()):
            break
    return flown


def _batches(candidates: Sequence[Candidate]) -> list[tuple[Variation, list[int]]]:
    """Return the indices of candidates that may fly together, with their common variation."""
    alike: dict[tuple[float, ...], list[int]] = {}
    for index, candidate in enumerate(candidates):
        alike.setdefault(dataclasses.astuple(candidate.variation), []).append(index)
    return [
        (candidates[indices[0]].variation, indices[first : first + BATCH])
        for indices in alike.values()
        for first in range(0, len(indices), BATCH)
    ]


def _note(rollouts: Rollouts, command: float, indices: np.ndarray, flown: Flown) -> None:
    """Put what was flown into its places."""
    metrics = rollout_metrics(rollouts, command)
    columns = [getattr(metrics, metric.name) for metric in FLOWN[:-1]]
    values = np.stack([*columns, rollouts.peak_rotor_use], axis=1)
    values[np.isfinite(rollouts.diverged_at)] = np.nan
    flown.done[indices] = True
    flown.values[indices] = values
    flown.diverged_at[indices] = rollouts.diverged_at
