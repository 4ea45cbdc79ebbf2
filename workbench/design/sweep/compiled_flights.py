"""Fly candidates with the compiled engine, thousands per second, here or on a cluster."""

import dataclasses
import logging
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.cache import PROGRESS_LOGGER
from workbench.design.linear_step import DecayTimes
from workbench.design.metrics import FLOWN_METRICS
from workbench.design.step_metrics import step_duration
from workbench.design.sweep.case import (
    FlownPart,
    Stop,
    SweepCandidate,
    SweepCase,
    empty_results,
)
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor

CANDIDATES_PER_CHUNK = 64
"""Number of candidates between two times that flights are kept, and that a stop is seen."""
CANDIDATES_PER_SHARE = 256
"""Number of candidates that a worker of a cluster flies at a time, some tenths of a second long."""


def fly_compiled(
    case: SweepCase,
    setup: Setup,
    candidates: Sequence[SweepCandidate],
    stop: Stop | None = None,
    *,
    threads: int | None = None,
) -> Iterator[FlownPart]:
    """Fly candidates with the compiled engine; yield `CANDIDATES_PER_CHUNK` of them at a time.

    Args:
        case: the step.
        setup: of the case.
        candidates: (N) to fly.
        stop: True ends the work with the results so far.
        threads: that fly at a time; None for one for each core.
    """
    from workbench.design.rollout.engine import RolloutEngine

    seed = setup.scenario.sensors.seed
    engine, decay_times = RolloutEngine.of(setup, threads), DecayTimes(setup)
    for first in range(0, len(candidates), CANDIDATES_PER_CHUNK):
        chunk = range(first, min(first + CANDIDATES_PER_CHUNK, len(candidates)))
        decays: dict[float, dict[int, float]] = {}
        for index in chunk:
            if stop and stop():
                return
            each = candidates[index]
            decay = decay_times.of(case.axis, each.settings, each.variation)
            duration = step_duration(decay) if case.duration is None else case.duration
            decays.setdefault(duration, {})[index] = decay
        flown = empty_results(len(chunk))
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
            metrics = [getattr(measured.metrics, row.name) for row in FLOWN_METRICS]
            values = np.stack(metrics, axis=1)
            values[np.isfinite(measured.diverged_at)] = np.nan
            places = [index - first for index in decay_of]
            flown.values[places] = values
            flown.diverged_at[places] = measured.diverged_at
        yield chunk, flown.values, flown.diverged_at


def fly_fastest(
    case: SweepCase,
    setup: Setup,
    candidates: Sequence[SweepCandidate],
    stop: Stop | None = None,
    *,
    cluster: "Executor | None" = None,
) -> Iterator[FlownPart]:
    """Fly candidates with the compiled engine, or on the full diagram if that cannot compile.

    Args:
        case: the step.
        setup: of the case.
        candidates: (N) to fly.
        stop: True ends the work with the results so far.
        cluster: for shares of compiled flights, or for flights on the full diagram, see `fly_full`;
            None flies them on this machine.
    """
    from workbench.design.rollout.sensor_set import why_not_compiled  # `--full` needs no numba

    law = setup.controller
    # swept parameters are compiled, see `ranges`; common settings may not be
    reason = why_not_compiled(setup)
    if not law.compiles:
        reason = f"{law.name} is not compiled"
    if not reason and cluster:
        return _fly_shares(case, candidates, cluster, stop)
    if not reason:
        return fly_compiled(case, setup, candidates, stop)
    from workbench.design.sweep.full_flights import fly_full  # it loads all of a session

    logging.getLogger(PROGRESS_LOGGER).warning(f"{reason}: candidates fly on the full diagram")
    return fly_full(case, setup, candidates, stop, executor=cluster)


def _fly_shares(
    case: SweepCase,
    candidates: Sequence[SweepCandidate],
    cluster: "Executor",
    stop: Stop | None,
) -> Iterator[FlownPart]:
    """Fly candidates in shares, each a task; a stop keeps the shares that are done."""
    from workbench.design.executor.executor import Task

    firsts = range(0, len(candidates), CANDIDATES_PER_SHARE)
    tasks = [
        Task(case.scenario, _fly_share, (case, candidates[first : first + CANDIDATES_PER_SHARE]))
        for first in firsts
    ]
    for number, parts in cluster.run(tasks, stop):
        for some, values, diverged_at in parts:
            yield [firsts[number] + index for index in some], values, diverged_at


def _fly_share(
    scenario: Scenario, case: SweepCase, candidates: Sequence[SweepCandidate]
) -> list[FlownPart]:
    """Fly some candidates in a thread of a worker; the caller has logged the remarks."""
    from workbench.design.executor.executor import without_remarks

    with without_remarks():
        setup = make_setup(scenario, case.settings)
        own = dataclasses.replace(case, scenario=setup.scenario)
        return list(fly_compiled(own, setup, candidates, threads=1))
