"""Fly one case of a spec, or work out its margins, and hold it against what is demanded."""

import dataclasses
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import load_controller
from workbench.design.regress.band import Curve, band
from workbench.design.regress.baseline import (
    conditions_file,
    conditions_text,
    curves_file,
    curves_text,
    read_conditions,
    read_curves,
)
from workbench.design.regress.flight import (
    Changes,
    Flight,
    UnknownError,
    changed,
    fly_case,
)
from workbench.design.regress.judged_log import JudgedLog
from workbench.design.regress.measures import MEASURED, Need, find_measure
from workbench.design.regress.spec import Case, Limit, Spec
from workbench.design.regress.spec_names import MARGINS, find_part, spec_title
from workbench.design.regress.verdict import CaseResult, Check, Comparison, Difference
from workbench.design.step_responses import SHORTEST
from workbench.gains.gains import flight_gains
from workbench.plant.loading import make_vehicle
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import read_configured
from workbench.scenario.parameters import parameter_table, vehicle_parameters
from workbench.scenario.scenario import Scenario

SAME, TINY = 1e-6, 1e-12
"""Largest difference, relative and absolute, between values that count as the same."""
_ROTOR_CONSTANTS = (
    "direction",
    "motor_constant",
    "moment_constant",
    "time_constant_up",
    "time_constant_down",
    "max_rot_velocity",
    "rotor_drag_coefficient",
    "rolling_moment_coefficient",
)
_WHERE_STATED = (
    "inflow_coefficient",
    "ground_effect_coefficient",
    "propeller_radius",
    "linear_motor_constant",
)
"""Constants of rotors that are left out where they are 0: baselines may be older than these."""


def conditions(
    vehicle: Vehicle, scenario: Scenario, settings: Mapping[str, float]
) -> dict[str, float]:
    """Return all numbers that a spec's flights have in common, by name.

    Args:
        vehicle: what flies.
        scenario: with which gain file, rates and variation of the plant.
        settings: parameter values over those of the vehicle.
    """
    controller = load_controller(scenario.controller)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, controller)
    rows = vehicle_parameters(vehicle, parameter_table(controller))
    found = {row.name: values[row.name] for row in rows}
    found["mass"] = vehicle.mass
    found |= {f"center_of_mass_{axis}": p for axis, p in zip("xyz", vehicle.p_BoBcm_B, strict=True)}
    for i, row in enumerate("xyz"):
        for j, column in list(enumerate("xyz"))[i:]:
            found[f"inertia_{row}{column}"] = vehicle.I_BBcm_B[i][j]
    for number, rotor in enumerate(vehicle.rotors, start=1):
        for name in _ROTOR_CONSTANTS:
            found[f"rotor {number} {name}"] = float(getattr(rotor, name))
        stated = {name: float(getattr(rotor, name)) for name in _WHERE_STATED}
        found |= {f"rotor {number} {name}": value for name, value in stated.items() if value}
        for axis, place in zip("xyz", rotor.p_BR, strict=True):
            found[f"rotor {number} p_{axis}"] = place
    if vehicle.battery:
        found["battery capacity"] = vehicle.battery.capacity
        found["battery resistance"] = vehicle.battery.resistance
        for index, point in enumerate(vehicle.battery.open_circuit_voltage):
            found[f"battery point {index} charge"], found[f"battery point {index} voltage"] = point
    for name, value in dataclasses.asdict(scenario.rates).items():
        found[f"rates {name}"] = value
    for name, value in dataclasses.asdict(scenario.vehicle.variation).items():
        found[f"variation {name}"] = float(value)
    return found


def differences(baseline: Mapping[str, float], now: Mapping[str, float]) -> tuple[Difference, ...]:
    """Return what is not the same, in the order of now, then what is no more.

    A live parameter that the baseline is too old to have was at its default.
    """
    known = {**parameter_table().defaults(), **baseline}
    names = [*now, *(name for name in baseline if name not in now)]
    found = [Difference(name, known.get(name, math.nan), now.get(name, math.nan)) for name in names]
    return tuple(
        each
        for each in found
        if not math.isclose(each.baseline, each.now, rel_tol=SAME, abs_tol=TINY)
    )


ReadLog = Callable[[Spec, Case], JudgedLog]


@dataclass(frozen=True)
class Job:
    """One part of a spec to judge.

    Attributes:
        spec: that it is of.
        part: the name of a case, or `MARGINS`.
        changes: what the run has otherwise.
        logged: the flight of a case that has a log, see `with_log`.
    """

    spec: Spec
    part: str
    changes: Changes = field(default_factory=Changes)
    logged: JudgedLog | None = None

    @property
    def case(self) -> Case | None:
        """The case; None of margins."""
        return None if self.part == MARGINS else find_case(self.spec, self.part)

    def with_log(self, read: ReadLog) -> "Job":
        """Return the job with the flight of its log, if its case has one.

        Args:
            read: makes that flight, `workbench.logs.judged_log.read_case`.

        Raises:
            WorkbenchError: if the log cannot be read, or lacks a signal that the case names, or if
                the run has a change that only a new flight can have.
        """
        case = self.case
        if case is None or case.log is None:
            return self
        if asked := self.changes.of_flights:
            raise WorkbenchError(
                f"{self.spec.path}: {case.name}: has a log, which has flown already, so {asked[0]} "
                "cannot change it: leave it out, or name other specs"
            )
        try:
            return dataclasses.replace(self, logged=read(self.spec, case))
        except WorkbenchError as error:
            raise WorkbenchError(f"{self.spec.path}: {case.name}: {error}") from None


@dataclass(frozen=True)
class Measured:
    """What a job came to, before it is held against the baseline.

    Attributes:
        result: with checks, and with curves that have no band.
        conditions: what was flown with, without the case's own settings.
    """

    result: CaseResult
    conditions: Mapping[str, float]


def measure(job: Job) -> Measured:
    """Fly a case, or work out margins; nothing is read from the baseline.

    Raises:
        WorkbenchError: if the vehicle cannot be built.
    """
    began = time.perf_counter()
    spec, changes = job.spec, job.changes
    common = changed(spec, changes)
    result = CaseResult(spec_title(spec.path), spec.path, job.part)
    if job.part == MARGINS:
        from workbench.design.regress.margins import check_loops

        result = dataclasses.replace(result, checks=check_loops(spec, common, changes.settings))
    else:
        case = find_case(spec, job.part)
        try:
            if case.log is None:
                result = _flown(result, case, fly_case(case, common, changes.settings))
            else:
                result = _logged(result, case, job.logged)
        except WorkbenchError as error:
            raise WorkbenchError(f"{spec.path}: {case.name}: {error}") from None
    result = dataclasses.replace(result, seconds=time.perf_counter() - began)
    return Measured(result, _conditions(common, changes))


def compare(job: Job, measured: Measured) -> CaseResult:
    """Return a job's result with curves beside their baselines, and with what has changed.

    Raises:
        WorkbenchError: if a baseline's file cannot be read.
    """
    path, result = job.spec.path, measured.result
    recorded = read_conditions(conditions_file(path))
    changes = differences(recorded, measured.conditions) if recorded else ()
    if result.trouble or result.absent or job.part == MARGINS:
        return dataclasses.replace(result, differences=changes)
    case = find_case(job.spec, job.part)
    baselines = read_curves(curves_file(path, case.name)) if case.baseline else {}
    curves = tuple(_beside(curve, case, baselines, path) for curve in result.curves)
    return dataclasses.replace(result, curves=curves, differences=changes)


def find_case(spec: Spec, name: str) -> Case:
    """Return a spec's case.

    Raises:
        WorkbenchError: if it has none of that name.
    """
    cases = {case.name: case for case in spec.content.cases}
    return cases[find_part(list(cases), name)]


def baseline_files(job: Job, measured: Measured) -> dict[Path, str]:
    """Return the text of each file that makes up a job's baseline; a lost flight makes none.

    Raises:
        WorkbenchError: if a curve is infinite somewhere, as a range where nothing is seen.
    """
    if measured.result.trouble or measured.result.absent:
        return {}
    path = job.spec.path
    files = {conditions_file(path): conditions_text(measured.conditions)}
    if job.part != MARGINS:
        wanted = find_case(job.spec, job.part).baseline
        curves = [
            curve
            for curve in measured.result.curves
            if curve.signal in wanted and len(curve.flown.time)
        ]
        for curve in curves:
            infinite = ~np.isfinite(curve.flown.values)
            if infinite.any():
                raise WorkbenchError(
                    f"{path}: {job.part}: {curve.signal} is {curve.flown.values[infinite][0]:g} at "
                    f"{curve.flown.time[infinite][0]:.3f} s: a baseline needs finite values"
                )
        if curves:
            files[curves_file(path, job.part)] = curves_text(curves)
    return files


def _flown(result: CaseResult, case: Case, flight: Flight) -> CaseResult:
    """Return a result with a flight's checks and curves, or with what was the trouble."""
    names = dict.fromkeys([*case.baseline, *filter(None, [flight.signal])])
    curves = tuple(_curve(name, flight) for name in names)
    if flight.trouble:
        return dataclasses.replace(result, trouble=flight.trouble, curves=curves)
    checks = [each for name, limit in case.limits.items() for each in _checks(name, limit, flight)]
    return dataclasses.replace(result, checks=tuple(checks), curves=curves)


def _curve(name: str, flight: Flight) -> Comparison:
    """Return a flown curve; an empty one of a log that does not tell."""
    unit = flight.find_signal(name).unit
    try:
        return Comparison(name, unit, flight.curve(name))
    except UnknownError as reason:
        return Comparison(name, unit, Curve(np.empty(0), np.empty(0)), missing=str(reason))


def _logged(result: CaseResult, case: Case, flight: JudgedLog | None) -> CaseResult:
    """Return a result with the checks and curves of a log, or why there is none."""
    if flight is None:
        raise WorkbenchError(
            "is judged from a log: give regress and record "
            "read_log=workbench.logs.judged_log.read_case"
        )
    if flight.absent:
        return dataclasses.replace(result, absent=flight.absent)
    return _flown(result, case, flight)


def _checks(name: str, limit: Limit, flight: Flight) -> list[Check]:
    """Return a limit's check; of a log with several steps, one for each."""
    measure = find_measure(name)
    parts = flight.parts if measure.need is Need.COMMAND else {flight.edge: flight}
    many = len(parts) > 1
    found = []
    try:
        for begin, part in parts.items():
            said = f"{name} of the step at {begin:.2f} s" if many else name
            value, doubt = measure.measured(part)
            found.append(Check(said, measure.unit_of(part), value, limit, doubt))
        if not found:
            raise UnknownError(
                f"the set-point has no step that stands for {SHORTEST:g} s before and after its "
                f"edge: {' and '.join(MEASURED[:2])} take any flying"
            )
    except UnknownError as reason:
        skipped = isinstance(flight, JudgedLog) and flight.skip
        return [Check(name, measure.unit_of(flight), math.nan, limit, str(reason), skipped)]
    return found


def _beside(
    curve: Comparison, case: Case, baselines: Mapping[str, Curve], path: Path
) -> Comparison:
    """Return a flown curve with its baseline and its band, if one is demanded."""
    if curve.missing or curve.signal not in case.baseline:
        return curve
    baseline = baselines.get(curve.signal)
    if baseline is None or baseline.time[-1] < curve.flown.time[-1] - 1e-6:
        what = "has no baseline yet" if baseline is None else "is longer than its baseline"
        sentence = f"{curve.signal} {what}: record it with `workbench regress {path} --update`"
        return dataclasses.replace(curve, missing=sentence)
    allowed = band(baseline, case.baseline[curve.signal], curve.flown.time)
    return dataclasses.replace(curve, baseline=baseline, band=allowed)


def _conditions(common: Scenario, changes: Changes) -> dict[str, float]:
    vehicle = make_vehicle(read_configured(common.vehicle))
    return conditions(vehicle, common, changes.settings)
