"""Fly candidates with the compiled engine, thousands per second."""

import logging
from collections.abc import Sequence
from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.cache import PROGRESS_LOGGER
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.senses import make_senses, why_not
from workbench.design.sweep.case import Candidate, Flown, Progress, Stop, SweepCase, nothing_flown
from workbench.plant.vehicle import Vehicle

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor


def fly_compiled(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Flown:
    """Fly candidates with the compiled engine.

    Args:
        case: the step.
        vehicle: as known to its controller.
        candidates: (N) to fly.
        progress: called with the share done.
        stop: True ends the work with the results so far.
    """
    seed = case.scenario.sensors.seed
    engine = RolloutEngine(
        vehicle,
        case.scenario.rates,
        own=case.values(vehicle),
        controller=case.controller,
        senses=make_senses(vehicle, case.scenario),
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


def fly_fastest(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
    *,
    executor: "Executor | None" = None,
) -> Flown:
    """Fly candidates with the compiled engine, or on the full diagram if that cannot compile.

    Args:
        case: the step.
        vehicle: as known to its controller.
        candidates: (N) to fly.
        progress: called with the share done.
        stop: True ends the work with the results so far.
        executor: for flights on the full diagram, see `fly_full`.
    """
    law = case.controller
    # swept parameters are compiled, see `ranges`; common settings may not be
    reason = why_not(vehicle, case.scenario, case.values(vehicle))
    if not law.compiles:
        reason = f"{law.name} is not compiled"
    if not reason:
        return fly_compiled(case, vehicle, candidates, progress, stop)
    from workbench.design.sweep.full_flights import fly_full  # it loads all of a session

    logging.getLogger(PROGRESS_LOGGER).warning(f"{reason}: candidates fly on the full diagram")
    return fly_full(case, vehicle, candidates, progress, stop, executor=executor)
