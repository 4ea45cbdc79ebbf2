"""Fly and measure many candidates: a sweep, and a map over two gains in real time."""

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.loop import Loop
from workbench.design.metrics import (
    FLOWN_METRICS,
    MARGIN_METRICS,
    SWEPT_METRICS,
    Metric,
    find_metric,
)
from workbench.design.sweep.case import (
    FlySweep,
    Progress,
    Stop,
    SweepCandidate,
    SweepCase,
    default_axis,
    empty_results,
    partial_progress,
)
from workbench.design.sweep.compiled_flights import fly_fastest
from workbench.design.sweep.kept_flights import KeptFlights
from workbench.design.sweep.ranges import SweepRange, parse_range
from workbench.design.sweep.table import SweepTable
from workbench.parameters.flight_parameters import SIGNAL_PATH
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

if TYPE_CHECKING:
    from workbench.design.rollout.engine import RolloutEngine

FLIGHT_SHARE = 0.1
"""Share of the time for flights if margins are computed as well."""
SWEEP_METHODS = ("grid", "random", "sobol")
MAX_SWEEP_CANDIDATES = 100_000


def sweep(
    ranges: Sequence[SweepRange | str],
    *,
    method: str = "grid",
    samples: int = 256,
    seed: int = 0,
    axis: str = "",
    amplitude: float = 1.0,
    duration: float | None = None,
    scenario: Scenario | Setup | None = None,
    settings: Mapping[str, float] | None = None,
    loop: str = "",
    fly: FlySweep | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    kept: Path | str | None = None,
) -> SweepTable:
    """Fly a step with every candidate of a sweep and measure it.

    Args:
        ranges: of the sweep, as ranges or as texts such as "kp_roll=100..400:9".
        method: grid, random or sobol.
        samples: number of candidates for random and sobol; that of a grid follows from its ranges.
        seed: for random and sobol.
        axis: of the step, x, y, z or yaw; "" for the one that the first gain acts on, such as x for
            kp_pitch, else z.
        amplitude: of its command [m/s] or [rad/s].
        duration: flown after the edge of the command [s]; None for until each candidate has
            settled, see `step_duration`.
        scenario: its vehicle, gains, world and rates are used.
        settings: parameter values common to all candidates.
        loop: the one to compute margins of as well, see `Controller.loops`; "" for none.
        fly: by default `fly_fastest`, or `fly_full` for the full diagram in local processes or,
            with its executor bound by `functools.partial`, anywhere.
        progress: called with the share done, 0 .. 1.
        stop: called regularly; True ends the sweep with the results so far, those of the present
            gains among them.
        kept: file that keeps the flights of a sweep that takes long: an equal sweep that finds it
            flies the others only. Remove it when the table is written. None for no file.

    Raises:
        WorkbenchError: if the sweep is invalid, or the file keeps the flights of another one.
    """
    setup = make_setup(scenario, settings)
    law = setup.controller
    parsed = tuple(parse_range(each, law) if isinstance(each, str) else each for each in ranges)
    axis = axis or default_axis((each.name for each in parsed), law)
    case = SweepCase(axis, amplitude, duration, setup.scenario, setup.settings)
    parameters = sample_candidates(parsed, method, samples, seed)
    case.check(parsed, setup)
    cut = law.loop(loop) if loop else None
    present = np.array(case.present(parsed, setup))
    rows = np.vstack([present, parameters])
    candidates = [case.candidate(parsed, row) for row in rows]
    share = FLIGHT_SHARE if cut else 1.0
    tell, fly = partial_progress(progress, 0.0, share), fly or fly_fastest
    depends = partial(_dependencies, fly, case, [each.name for each in parsed], rows)
    with (
        nullcontext()
        if kept is None
        else KeptFlights(Path(kept), depends, len(candidates)) as keeper
    ):
        flown = keeper.flown if keeper else empty_results(len(candidates))
        todo = np.flatnonzero(~flown.done)

        def ends() -> bool:
            # a table without the present gains compares with nothing: so none ends without them
            return bool(flown.done[0]) and stop is not None and stop()

        flights = fly(case, setup, [candidates[index] for index in todo.tolist()], ends)
        for some, values, diverged_at in flights:
            places = todo[list(some)]
            flown.done[places] = True
            flown.values[places], flown.diverged_at[places] = values, diverged_at
            if keeper:
                keeper.keep(places, values, diverged_at)
            if tell:
                tell(float(flown.done.mean()))
    metrics, values = FLOWN_METRICS, flown.values
    if cut:
        flying = flown.done & np.isnan(flown.diverged_at)
        tell = partial_progress(progress, share, 1.0)
        margins = _candidate_margins(setup, candidates, flying, cut, tell, stop)
        metrics, values = (*FLOWN_METRICS, *MARGIN_METRICS), np.hstack([values, margins])
    done = flown.done[1:]
    return SweepTable(
        case=case,
        vehicle=setup.vehicle.name,
        ranges=parsed,
        method=method,
        seed=seed,
        planned=len(parameters),
        metrics=metrics,
        parameters=parameters[done],
        values=values[1:][done],
        diverged_at=flown.diverged_at[1:][done],
        present=present,
        present_values=values[0],
    )


def _dependencies(
    fly: FlySweep, case: SweepCase, names: Sequence[str], rows: np.ndarray
) -> dict[str, str]:
    """Return what the flights of a sweep depend on, by its description.

    Args:
        fly: flies the candidates.
        case: the step.
        names: of the swept numbers.
        rows: their values, a row a candidate.
    """
    from workbench.design.executor.cluster import process_versions
    from workbench.design.executor.shipment import shipment, with_absolute_paths

    files = shipment(with_absolute_paths(case.scenario)) or {}
    engine = getattr(fly, "func", fly)
    parts: dict[str, object] = {
        "engine": getattr(engine, "__name__", type(engine).__name__),
        "step": (case.axis, case.amplitude, case.duration),
        "candidates": (names, rows.tobytes()),
        "settings": sorted(case.settings.items()),
        "scenario": case.scenario,
        "files": sorted(files.items()),
        "versions": process_versions(),
    }
    return {
        name: hashlib.sha256(repr(part).encode("utf-8", "replace")).hexdigest()[:16]
        for name, part in parts.items()
    }


def sample_candidates(
    ranges: Sequence[SweepRange], method: str, samples: int, seed: int
) -> np.ndarray:
    """Return candidates, (N, len(ranges)).

    A grid has all combinations of the points of its ranges, the last range fastest. Sobol's
    sequence (scrambled, scipy.stats.qmc) fills the space more evenly than random samples, best with
    a power of two.

    Args:
        ranges: of the sweep.
        method: one of `SWEEP_METHODS`.
        samples: their number, for random and sobol.
        seed: for random and sobol; equal seeds yield equal candidates.

    Raises:
        WorkbenchError: if the ranges cannot be sampled.
    """
    if method not in SWEEP_METHODS:
        raise unknown_name("method", method, SWEEP_METHODS)
    names = [each.name for each in ranges]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice or not names:
        what = f"{twice} is swept twice" if twice else "nothing is swept"
        raise WorkbenchError(f"{what}: give each parameter one range, as kp_roll=100..400:9")
    count = math.prod(each.points for each in ranges) if method == "grid" else samples
    if not 1 <= count <= MAX_SWEEP_CANDIDATES:
        raise WorkbenchError(
            f"{count} candidates cannot be swept: give 1 to {MAX_SWEEP_CANDIDATES}, or use the "
            "method "
            "sobol, which needs fewer than a grid"
        )
    if seed < 0:
        raise WorkbenchError(f"the seed is {seed}: give 0 or more")
    if method == "grid":
        mesh = np.meshgrid(*(each.grid for each in ranges), indexing="ij")
        return np.stack([values.ravel() for values in mesh], axis=1)
    if method == "random":
        shares = np.random.default_rng(seed).random((samples, len(ranges)))
    else:
        from scipy.stats import qmc

        sobol = qmc.Sobol(len(ranges), scramble=True, seed=seed)
        shares = sobol.random_base2(math.ceil(math.log2(samples)))[:samples]
    columns = [each.spread(shares[:, index]) for index, each in enumerate(ranges)]
    return np.stack(columns, axis=1)


def _candidate_margins(
    setup: Setup,
    candidates: Sequence[SweepCandidate],
    wanted: np.ndarray,
    loop: Loop,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> np.ndarray:
    """Return the margins of a loop, opened at its actuator, in the sampled model of hover.

    Args:
        setup: of the sweep.
        candidates: (N) of the sweep.
        wanted: (N) whether to compute the margins of each.
        loop: the one to compute margins of.
        progress: called with the share done.
        stop: True ends with what is done.

    Returns:
        (N, 4) see `MARGIN_METRICS`; NaN if not wanted or not known yet, or if the candidate cannot
        hover.
    """
    from workbench.design.judge.margins import loop_margins
    from workbench.design.linear.operating_point import OperatingPoint
    from workbench.design.linear.study import LinearStudy

    margins = np.full((len(candidates), len(MARGIN_METRICS)), np.nan)
    point = OperatingPoint(hold=loop.hold)
    study: LinearStudy | None = None
    todo = np.flatnonzero(wanted)
    for count, index in enumerate(map(int, todo), start=1):
        if stop and stop():
            break
        candidate = candidates[index]
        if study is None or study.setup.variation != candidate.variation:
            study = LinearStudy(setup.varied(candidate.variation))
        try:
            model = study.sampled(point, candidate.settings)
            found = loop_margins(model, loop.actuator)
        except WorkbenchError:
            continue
        margins[index] = [getattr(found, metric.name) for metric in MARGIN_METRICS]
        if progress:
            progress(count / len(todo))
    return margins


@dataclass(frozen=True)
class GainMap:
    """A metric of flown steps on a grid of two gains; N_y rows of N_x values.

    Attributes:
        x: the gain along the columns.
        y: the gain along the rows.
        metric: the measured one.
        values: (N_y, N_x), NaN if a flight was lost or never reached the command.
        lost: (N_y, N_x) whether the flight was lost.
    """

    x: SweepRange
    y: SweepRange
    metric: Metric
    values: np.ndarray
    lost: np.ndarray


def gain_map(
    engine: "RolloutEngine",
    gains: Mapping[str, float],
    x: SweepRange,
    y: SweepRange,
    *,
    metric: str = "overshoot",
    axis: str = "x",
    amplitude: float = 1.0,
    duration: float = 2.0,
    heading: float = 0.0,
    stop: Callable[[], bool] | None = None,
) -> GainMap | None:
    """Fly a step at every point of a grid, in about 30 ms for 32 x 32 flights of 2 s on two cores.

    None of these flights is on the full diagram; confirm a choice by one that is.

    Args:
        engine: of the vehicle.
        gains: gains and limits of the controller, and settings of filters and estimator, that
            differ from those of the engine, by name.
        x: a gain or limit of the controller, and its values along the columns.
        y: another one, along the rows.
        metric: of the flight, see `FLOWN_METRICS`.
        axis: of the step, x, y, z or yaw.
        amplitude: of its command [m/s] or [rad/s].
        duration: flown after the edge of the command [s].
        heading: yaw of the drone at the start [rad].
        stop: called every few milliseconds; True abandons the map.

    Returns:
        The map, or None if abandoned.

    Raises:
        WorkbenchError: if the two gains are not different, or the step is invalid.
    """
    law = engine.controller
    names = [row.name for row in law.parameters]
    around = [row.name for system in SIGNAL_PATH for row in law.table.of(system)]
    for asked, known in (((x.name, y.name), names), (gains, [*names, *around])):
        for name in asked:
            if name not in known:
                raise unknown_name(f"parameter of {law.name}", name, known)
    if x.name == y.name:
        raise WorkbenchError(f"both axes of the map are {x.name}: give two different gains")
    wanted = find_metric(metric, SWEPT_METRICS)
    if wanted not in FLOWN_METRICS:
        raise unknown_name("metric of a flight", metric, [each.name for each in FLOWN_METRICS])
    points = [{**gains, x.name: column, y.name: row} for row in y.grid for column in x.grid]
    measured = engine.measure(
        points, axis, amplitude, duration=duration, heading=heading, stop=stop
    )
    if len(measured) < len(points):
        return None
    found = getattr(measured.metrics, metric)
    lost, shape = np.isfinite(measured.diverged_at), (len(y.grid), len(x.grid))
    return GainMap(x, y, wanted, np.where(lost, np.nan, found).reshape(shape), lost.reshape(shape))
