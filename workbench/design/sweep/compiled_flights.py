"""Candidates flown by the compiled engine, thousands a second."""

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from workbench.design.rollout.engine import RolloutEngine
from workbench.design.sweep.case import Candidate, SweepCase
from workbench.design.sweep.flown import Flown, Progress, Stop, nothing_flown
from workbench.plant.vehicle import Vehicle


def fly_compiled(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Flown:
    """Fly candidates on the compiled engine.

    Args:
        case: the step.
        vehicle: as its controller knows it.
        candidates: (N) what is flown.
        progress: called with the share done.
        stop: True ends with what is done.
    """
    seed = case.scenario.sensors.seed
    engine = RolloutEngine(
        vehicle, case.scenario.rates, own=case.values(vehicle), controller=case.controller
    )
    measured = engine.measure(
        [each.settings for each in candidates],
        case.axis,
        case.amplitude,
        duration=case.duration,
        variations=[each.variation for each in candidates],
        seeds=[seed if each.seed is None else each.seed for each in candidates],
        progress=progress,
        stop=stop,
    )
    flown = nothing_flown(len(candidates))
    done = slice(0, len(measured))
    metrics = astuple(measured.metrics)[: len(flown.values[0]) - 1]
    values = np.stack([*metrics, measured.peak_rotor_use], axis=1)
    values[np.isfinite(measured.diverged_at)] = np.nan
    flown.done[done] = True
    flown.values[done] = values
    flown.diverged_at[done] = measured.diverged_at
    return flown
