"""Fly candidates with the compiled engine, thousands per second."""

import logging
from collections.abc import Sequence
from dataclasses import astuple
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.cache import PROGRESS_LOGGER
from workbench.design.linear_step import DecayTimes
from workbench.design.response_metrics import step_duration
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.senses import make_senses, why_not
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

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor

CHUNK = 64
"""Number of candidates between two times that flights are kept, and that a stop is seen."""


def fly_compiled(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
    keep: Keep | None = None,
) -> Flown:
    """Fly candidates with the compiled engine.

    Args:
        case: the step.
        vehicle: as known to its controller.
        candidates: (N) to fly.
        progress: called with the share done.
        stop: True ends the work with the results so far.
        keep: called with each flight, after each `CHUNK` of them.
    """
    seed = case.scenario.sensors.seed
    engine = RolloutEngine(
        vehicle,
        case.scenario.rates,
        own=case.values(vehicle),
        controller=case.controller,
        senses=make_senses(vehicle, case.scenario),
    )
    decay_times = DecayTimes(case.scenario)
    flown = nothing_flown(len(candidates))
    for first in range(0, len(candidates), CHUNK):
        chunk = range(first, min(first + CHUNK, len(candidates)))
        decays: dict[float, dict[int, float]] = {}
        for index in chunk:
            if stop and stop() and first:
                return flown
            each = candidates[index]
            decay = decay_times.of(case.axis, each.settings, each.variation)
            duration = step_duration(decay) if case.duration is None else case.duration
            decays.setdefault(duration, {})[index] = decay
        for duration, decay_of in decays.items():
            some = [candidates[index] for index in decay_of]
            measured = engine.measure(
                [each.settings for each in some],
                case.axis,
                case.amplitude,
                duration=duration,
                variations=[each.variation for each in some],
                seeds=[seed if each.seed is None else each.seed for each in some],
                decay=np.array(list(decay_of.values())),
            )
            metrics = astuple(measured.metrics)[: len(flown.values[0]) - 1]
            values = np.stack([*metrics, measured.peak_rotor_use], axis=1)
            values[np.isfinite(measured.diverged_at)] = np.nan
            done = list(decay_of)
            flown.done[done] = True
            flown.values[done] = values
            flown.diverged_at[done] = measured.diverged_at
        if keep:
            for index in chunk:
                keep(index, flown.values[index], flown.diverged_at[index])
        if progress:
            progress(chunk.stop / len(candidates))
    return flown


def fly_fastest(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
    keep: Keep | None = None,
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
        keep: called with each flight.
        executor: for flights on the full diagram, see `fly_full`.
    """
    law = case.controller
    # swept parameters are compiled, see `ranges`; common settings may not be
    reason = why_not(vehicle, case.scenario, case.values(vehicle))
    if not law.compiles:
        reason = f"{law.name} is not compiled"
    if not reason:
        return fly_compiled(case, vehicle, candidates, progress, stop, keep)
    from workbench.design.sweep.full_flights import fly_full  # it loads all of a session

    logging.getLogger(PROGRESS_LOGGER).warning(f"{reason}: candidates fly on the full diagram")
    return fly_full(case, vehicle, candidates, progress, stop, keep, executor=executor)
