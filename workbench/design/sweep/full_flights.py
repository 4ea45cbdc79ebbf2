"""Candidates flown on the full Drake diagram, in processes."""

import dataclasses
import logging
import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

import numpy as np

from workbench.design.lost import find_loss
from workbench.design.step_metrics import step_metrics
from workbench.design.step_response import EDGE, axis_velocity, step_scenario
from workbench.design.sweep.case import Candidate, SweepCase
from workbench.design.sweep.flown import Flown, Progress, Stop, nothing_flown
from workbench.design.sweep.metrics import FLOWN
from workbench.errors import FlightBrokenError, WorkbenchError
from workbench.plant.vehicle import Vehicle
from workbench.recording import Recording
from workbench.session import Session


def fly_full(
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> Flown:
    """Fly candidates on the full diagram, one a core at a time; about a second each.

    Processes are spawned, so a script that calls this needs `if __name__ == "__main__":`.

    Args:
        case: the step.
        vehicle: as its controller knows it.
        candidates: (N) what is flown.
        progress: called with the share done.
        stop: True ends with what is done.

    Raises:
        WorkbenchError: if a candidate cannot be built, or a process was ended.
    """
    flown = nothing_flown(len(candidates))
    pool = ProcessPoolExecutor(
        min(len(candidates), len(os.sched_getaffinity(0))),
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_keep_quiet,
    )
    try:
        with _without_interrupts():
            begun = {
                pool.submit(fly_one, case, candidate): index
                for index, candidate in enumerate(candidates)
            }
        for count, future in enumerate(as_completed(begun), start=1):
            _note(future, begun[future], flown)
            if progress:
                progress(count / len(candidates))
            if stop and stop():
                break
    except BrokenProcessPool as error:
        raise WorkbenchError(
            "a process that flew candidates was ended from outside, perhaps for want of memory"
        ) from error
    finally:
        pool.shutdown(cancel_futures=True)
    for future, index in begun.items():  # what was in the air when it was stopped
        if future.done() and not future.cancelled() and not flown.done[index]:
            _note(future, index, flown)
    return flown


def fly_one(case: SweepCase, candidate: Candidate) -> tuple[list[float], float]:
    """Fly one candidate on the full diagram.

    Returns:
        Its metrics, see `metrics.FLOWN`, and when it was lost, from the edge on [s], or NaN.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    scenario = step_scenario(case.axis, case.amplitude, case.duration, case.scenario)
    scenario.vehicle = dataclasses.replace(scenario.vehicle, variation=candidate.variation)
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
    return [*dataclasses.astuple(metrics), float(after.rotor_use.max())], lost


def lost_at(recording: Recording) -> float:
    """Return when a step's drone was lost, from the edge on [s]; 0 before it, NaN if never."""
    loss = find_loss(recording)
    return max(0.0, loss.time - EDGE) if loss else float("nan")


def _note(future: "Future[tuple[list[float], float]]", index: int, flown: Flown) -> None:
    """Put what was flown into its place."""
    flown.values[index], flown.diverged_at[index] = future.result()
    flown.done[index] = True


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Start processes that leave Ctrl-C to this one: they inherit what is blocked."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _keep_quiet() -> None:
    """Let a process leave remarks to the one that started it, which has made them."""
    logging.getLogger("workbench").setLevel(logging.ERROR)
