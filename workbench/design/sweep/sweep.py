"""Fly and measure many candidates: a sweep, and a map over two gains in real time."""

import hashlib
import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Loop
from workbench.design.metrics import FLOWN, MARGINS, SWEPT, Metric, find_metric
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.sweep.case import (
    Candidate,
    Flown,
    FlySweep,
    Progress,
    Stop,
    SweepCase,
    default_axis,
    part_of,
)
from workbench.design.sweep.compiled_flights import fly_fastest
from workbench.design.sweep.kept_flights import KeptFlights
from workbench.design.sweep.ranges import SweepRange, parse_range
from workbench.design.sweep.table import SweepTable
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import SIGNAL_PATH, parameter_table
from workbench.scenario.scenario import Scenario, at_own_period, flown_controller

FLIGHT_SHARE = 0.1
"""Share of the time for flights if margins are computed as well."""
METHODS = ("grid", "random", "sobol")
MOST_CANDIDATES = 100_000


def sweep(
    ranges: Sequence[SweepRange | str],
    *,
    method: str = "grid",
    samples: int = 256,
    seed: int = 0,
    axis: str = "",
    amplitude: float = 1.0,
    duration: float | None = None,
    scenario: Scenario | None = None,
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
        stop: called regularly; True ends the sweep with the results so far.
        kept: file that keeps the flights of a sweep that takes long: an equal sweep that finds it
            flies the others only. Remove it when the table is written. None for no file.

    Raises:
        WorkbenchError: if the sweep is invalid, or the file keeps the flights of another one.
    """
    scenario = at_own_period(scenario or Scenario())
    law = flown_controller(scenario)
    parsed = tuple(parse_range(each, law) if isinstance(each, str) else each for each in ranges)
    axis = axis or default_axis((each.name for each in parsed), law)
    case = SweepCase(axis, amplitude, duration, scenario, dict(settings or {}))
    parameters = sample(parsed, method, samples, seed)
    vehicle = case.vehicle()
    case.check(parsed, vehicle)
    cut = law.loop(loop) if loop else None
    present = np.array(case.present(parsed, vehicle))
    # the present gains fly first, so that they are complete whenever the sweep is stopped
    rows = np.vstack([present, parameters])
    candidates = [case.candidate(parsed, row) for row in rows]
    share = FLIGHT_SHARE if cut else 1.0
    tell, fly = part_of(progress, 0.0, share), fly or fly_fastest
    if kept is None:
        flown = fly(case, vehicle, candidates, tell, stop)
    else:
        depends = partial(_dependencies, fly, case, [each.name for each in parsed], rows)
        with KeptFlights(Path(kept), depends, len(candidates)) as keeper:
            flown = _fly_rest(fly, case, vehicle, candidates, tell, stop, keeper)
    metrics, values = FLOWN, flown.values
    if cut:
        flying = flown.done & np.isnan(flown.diverged_at)
        tell = part_of(progress, share, 1.0)
        margins = _candidate_margins(case, candidates, flying, cut, tell, stop)
        metrics, values = (*FLOWN, *MARGINS), np.hstack([values, margins])
    done = flown.done[1:]
    return SweepTable(
        case=case,
        vehicle=vehicle.name,
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


def _fly_rest(
    fly: FlySweep,
    case: SweepCase,
    vehicle: Vehicle,
    candidates: Sequence[Candidate],
    progress: Progress | None,
    stop: Stop | None,
    kept: KeptFlights,
) -> Flown:
    """Fly the candidates that are not in a file yet, and keep them there."""
    flown, count = kept.flown, len(candidates)
    todo = np.flatnonzero(~flown.done)
    if len(todo) < count:
        logging.getLogger("workbench").warning(
            "%d of %d flights are kept from the sweep that was ended: flying the others",
            count - len(todo),
            count,
        )
    found = fly(
        case,
        vehicle,
        [candidates[index] for index in todo.tolist()],
        part_of(progress, 1.0 - len(todo) / count, 1.0),
        stop,
        lambda index, values, diverged_at: kept.keep(int(todo[index]), values, diverged_at),
    )
    for whole, part in zip(flown, found, strict=True):
        whole[todo[found.done]] = part[found.done]
    return flown


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
    from workbench.design.executor.cluster import versions
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
        "versions": versions(),
    }
    return {
        name: hashlib.sha256(repr(part).encode("utf-8", "replace")).hexdigest()[:16]
        for name, part in parts.items()
    }


def sample(ranges: Sequence[SweepRange], method: str, samples: int, seed: int) -> np.ndarray:
    """Return candidates, (N, len(ranges)).

    A grid has all combinations of the points of its ranges, the last range fastest. Sobol's
    sequence (scrambled, scipy.stats.qmc) fills the space more evenly than random samples, best with
    a power of two.

    Args:
        ranges: of the sweep.
        method: one of `METHODS`.
        samples: their number, for random and sobol.
        seed: for random and sobol; equal seeds yield equal candidates.

    Raises:
        WorkbenchError: if the ranges cannot be sampled.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    names = [each.name for each in ranges]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice or not names:
        what = f"{twice} is swept twice" if twice else "nothing is swept"
        raise WorkbenchError(f"{what}: give each parameter one range, as kp_roll=100..400:9")
    count = math.prod(each.points for each in ranges) if method == "grid" else samples
    if not 1 <= count <= MOST_CANDIDATES:
        raise WorkbenchError(
            f"{count} candidates cannot be swept: give 1 to {MOST_CANDIDATES}, or use the method "
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
    case: SweepCase,
    candidates: Sequence[Candidate],
    wanted: np.ndarray,
    loop: Loop,
    progress: Progress | None = None,
    stop: Stop | None = None,
) -> np.ndarray:
    """Return the margins of a loop, opened at its actuator, in the sampled model of hover.

    Args:
        case: its scenario and settings are used.
        candidates: (N) of the sweep.
        wanted: (N) whether to compute the margins of each.
        loop: the one to compute margins of.
        progress: called with the share done.
        stop: True ends with what is done.

    Returns:
        (N, 4) see `metrics.MARGINS`; NaN if not wanted or not known yet, or if the candidate cannot
        hover.
    """
    from workbench.design.judge.margins import loop_margins
    from workbench.design.linear.operating_point import OperatingPoint
    from workbench.design.linear.study import LinearStudy

    margins = np.full((len(candidates), len(MARGINS)), np.nan)
    point = OperatingPoint(hold=loop.hold)
    own = case.values(case.vehicle())
    study: LinearStudy | None = None
    study_of = Variation()
    todo = np.flatnonzero(wanted)
    for count, index in enumerate(map(int, todo), start=1):
        if stop and stop():
            break
        candidate = candidates[index]
        if study is None or study_of != candidate.variation:
            study_of = candidate.variation
            vehicle = replace(case.scenario.vehicle, variation=study_of)
            varied = replace(case.scenario, vehicle=vehicle)
            study = study.like(varied) if study else LinearStudy(varied)
        try:
            model = study.sampled(point, {**own, **candidate.settings})
            found = loop_margins(model, loop.actuator)
        except WorkbenchError:
            continue
        margins[index] = [getattr(found, metric.name) for metric in MARGINS]
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
    engine: RolloutEngine,
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
        metric: of the flight, see `metrics.FLOWN`.
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
    names = [row.name for row in engine.controller.parameters]
    table = parameter_table(engine.controller)
    around = [row.name for system in SIGNAL_PATH for row in table.of(system)]
    for asked, known in (((x.name, y.name), names), (gains, [*names, *around])):
        for name in asked:
            if name not in known:
                raise unknown_name("gain", name, known)
    if x.name == y.name:
        raise WorkbenchError(f"both axes of the map are {x.name}: give two different gains")
    wanted = find_metric(metric, SWEPT)
    if wanted not in FLOWN:
        raise unknown_name("metric of a flight", metric, [each.name for each in FLOWN])
    points = [{**gains, x.name: column, y.name: row} for row in y.grid for column in x.grid]
    measured = engine.measure(
        points, axis, amplitude, duration=duration, heading=heading, stop=stop
    )
    if len(measured) < len(points):
        return None
    if metric == "peak_rotor_use":
        found = measured.peak_rotor_use
    else:
        found = getattr(measured.metrics, metric)
    lost, shape = np.isfinite(measured.diverged_at), (len(y.grid), len(x.grid))
    return GainMap(x, y, wanted, np.where(lost, np.nan, found).reshape(shape), lost.reshape(shape))
