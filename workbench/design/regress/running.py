"""Run specs: fly their cases, here or on a cluster, judge them, and record baselines."""

import dataclasses
import math
import shlex
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.series import Series
from workbench.common.yaml_files import read_yaml
from workbench.design.executor.executor import Executor, InThisProcess, LocalProcesses, Task
from workbench.design.metrics import find_metric
from workbench.design.regress.baseline import (
    changed_conditions,
    conditions,
    conditions_file,
    conditions_text,
    curves_file,
    curves_text,
    read_conditions,
    read_curves,
)
from workbench.design.regress.case_log import JudgedLog
from workbench.design.regress.flight import (
    CaseFlight,
    Changes,
    MissingInputError,
    changed_scenario,
    fly_case,
)
from workbench.design.regress.loading import check_named, load_spec
from workbench.design.regress.measures import LOOP_LOG_METRICS, Need, find_measure
from workbench.design.regress.spec import Spec, SpecCase, SpecLimit
from workbench.design.regress.spec_names import MARGINS_PART, spec_title
from workbench.design.regress.verdict import (
    CaseResult,
    CurveComparison,
    LimitCheck,
    band,
)
from workbench.design.step_responses import MIN_CONSTANT_COMMAND_S
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup

Progress = Callable[[float], None]
ReadLog = Callable[[Spec, SpecCase], JudgedLog]


class Recorded(NamedTuple):
    """Results without bands, and the text of each baseline file."""

    results: list[CaseResult]
    files: dict[Path, str]


@dataclass(frozen=True)
class Job:
    """One part of a spec to judge.

    Attributes:
        spec: the one it belongs to.
        part: name of a case, or `MARGINS_PART`.
        changes: of the run from the spec.
        logged: flight of a case with a log, see `with_log`.
    """

    spec: Spec
    part: str
    changes: Changes = field(default_factory=Changes)
    logged: JudgedLog | None = None

    @property
    def case(self) -> SpecCase | None:
        """The case; None for margins.

        Raises:
            WorkbenchError: if the spec has no case with that name.
        """
        if self.part == MARGINS_PART:
            return None
        cases = {case.name: case for case in self.spec.content.cases}
        if self.part not in cases:
            raise unknown_name("case", self.part, cases)
        return cases[self.part]

    @property
    def task(self) -> Task[CaseResult]:
        """The work of an executor: to judge it, without its baseline."""
        return Task(changed_scenario(self.spec, self.changes), _judge_job, (self,))

    def with_log(self, read: ReadLog) -> "Job":
        """Return the job with the flight of its log, if its case has one.

        Args:
            read: reads that flight, such as `workbench.logs.judged_log.read_case`.

        Raises:
            WorkbenchError: if the log cannot be read or lacks a signal named in the case, or if the
                run has a change that does not apply to logs.
        """
        case = self.case
        if case is None or case.log is None:
            return self
        if asked := self.changes.of_flights:
            raise WorkbenchError(
                f"{self.spec.path}: {case.name}: is judged from a log, which {asked[0]} cannot "
                "change: leave it out, or name other specs"
            )
        try:
            return dataclasses.replace(self, logged=read(self.spec, case))
        except WorkbenchError as error:
            raise WorkbenchError(f"{self.spec.path}: {case.name}: {error}") from None


def _judge_job(common: Scenario, job: Job) -> CaseResult:
    """Fly the case of a job, or compute the margins; the baseline is not read.

    Args:
        common: to all cases of the spec, with the changes of the run.
        job: what to judge.

    Raises:
        WorkbenchError: if the vehicle cannot be built.
    """
    began = time.perf_counter()
    case, path, settings = job.case, job.spec.path, job.changes.settings
    result = CaseResult(spec_title(path), path, job.part)
    try:
        setup = make_setup(common, settings)
    except WorkbenchError as error:
        raise WorkbenchError(f"{path}: {job.part}: {error}") from None
    if case is None:
        result = dataclasses.replace(result, checks=_check_loop_margins(job.spec, setup))
    else:
        try:
            result = _judged_result(result, case, _case_flight(job, case, setup))
        except WorkbenchError as error:
            raise WorkbenchError(f"{path}: {case.name}: {error}") from None
    return dataclasses.replace(
        result, seconds=time.perf_counter() - began, conditions=conditions(setup)
    )


def _case_flight(job: Job, case: SpecCase, setup: Setup) -> CaseFlight:
    """Return the flight of a case, simulated now or from its log."""
    if case.log is None:
        return fly_case(case, setup)
    if job.logged is None:
        raise WorkbenchError(
            "is judged from a log: give regress and record "
            "read_log=workbench.logs.judged_log.read_case"
        )
    return job.logged


def regress(
    specs: Sequence[Path | str],
    changes: Changes | None = None,
    *,
    processes: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
    read_log: ReadLog | None = None,
) -> list[CaseResult]:
    """Fly the cases of specs and judge them.

    Args:
        specs: their files.
        changes: of the run from the specs.
        processes: number of processes; 1 for the present one.
        executor: runs the flights instead, such as on a cluster.
        progress: called with the share done, 0 .. 1.
        read_log: reads the flight of a case with a log, such as
            `workbench.logs.judged_log.read_case`.

    Returns:
        A result for each case, and one for the margins of each spec, in the order of the specs.

    Raises:
        WorkbenchError: if a spec is invalid or its vehicle cannot be built.
    """
    jobs = _jobs(specs, changes or Changes(), read_log)
    results = _run_jobs(jobs, executor or local_executor(processes), progress)
    return [compare_to_baseline(job, each) for job, each in zip(jobs, results, strict=True)]


def record(
    specs: Sequence[Path | str],
    *,
    controller: str = "",
    processes: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
    read_log: ReadLog | None = None,
) -> Recorded:
    """Fly the cases of specs for their baselines, and judge their limits.

    Args:
        specs: their files.
        controller: the one that they name; a Python file that only they name is not executed.
        processes: number of processes; 1 for the present one.
        executor: runs the flights instead, such as on a cluster.
        progress: called with the share done, 0 .. 1.
        read_log: as for `regress`.

    Raises:
        WorkbenchError: if a spec is invalid or its vehicle cannot be built.
    """
    for path in specs:
        check_named(Path(path), controller)
    jobs = _jobs(specs, Changes(controller=controller), read_log)
    results = _run_jobs(jobs, executor or local_executor(processes), progress)
    files: dict[Path, str] = {}
    for job, each in zip(jobs, results, strict=True):
        files |= baseline_files(job, each)
    return Recorded(results, files)


def local_executor(processes: int) -> Executor:
    """Return an executor with this number of processes; 1 is the present process."""
    return LocalProcesses(processes) if processes > 1 else InThisProcess()


def _jobs(specs: Sequence[Path | str], changes: Changes, read_log: ReadLog | None) -> list[Job]:
    """Return a job for each case of specs, and one for a spec's margins."""
    found = []
    for path in specs:
        spec = load_spec(path, changes.controller)
        parts = [case.name for case in spec.content.cases] + [MARGINS_PART] * bool(
            spec.content.margins
        )
        found += [Job(spec, part, changes) for part in parts]
    return [job.with_log(read_log) for job in found] if read_log else found


def _run_jobs(
    jobs: Sequence[Job], executor: Executor, progress: Progress | None
) -> list[CaseResult]:
    """Return the results of jobs, in their order."""
    found: dict[int, CaseResult] = {}
    for index, result in executor.run([job.task for job in jobs]):
        found[index] = result
        if progress:
            progress(len(found) / len(jobs))
    return [found[index] for index in range(len(jobs))]


def compare_to_baseline(job: Job, result: CaseResult) -> CaseResult:
    """Return the result of a job with baselines of curves, and with changed conditions.

    Raises:
        WorkbenchError: if a baseline file cannot be read.
    """
    path, case = job.spec.path, job.case
    recorded = read_conditions(conditions_file(path))
    changes = changed_conditions(recorded, result.conditions) if recorded else ()
    curves = result.curves
    if case is not None and not (result.trouble or result.absent):
        baselines = read_curves(curves_file(path, case.name)) if case.baseline else {}
        curves = tuple(_curve_with_baseline(curve, case, baselines, path) for curve in curves)
    return dataclasses.replace(result, curves=curves, differences=changes)


def baseline_files(job: Job, result: CaseResult) -> dict[Path, str]:
    """Return the text of each baseline file of a job; there is none for a lost flight.

    Raises:
        WorkbenchError: if a curve is infinite somewhere, such as a range without a return.
    """
    if result.trouble or result.absent:
        return {}
    path, case = job.spec.path, job.case
    files = {conditions_file(path): conditions_text(result.conditions)}
    wanted = case.baseline if case else {}
    curves = [curve for curve in result.curves if curve.signal in wanted and len(curve.flown.time)]
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


def _judged_result(result: CaseResult, case: SpecCase, flight: CaseFlight) -> CaseResult:
    """Return a result with the checks and curves of a flight, or the reason for none."""
    if isinstance(flight, JudgedLog) and flight.absent:
        return dataclasses.replace(result, absent=flight.absent)
    names = dict.fromkeys([*case.baseline, *filter(None, [flight.signal])])
    curves = tuple(_flown_curve(name, flight) for name in names)
    if flight.trouble:
        return dataclasses.replace(result, trouble=flight.trouble, curves=curves)
    checks = [each for name, limit in case.limits.items() for each in _checks(name, limit, flight)]
    return dataclasses.replace(result, checks=tuple(checks), curves=curves)


def _flown_curve(name: str, flight: CaseFlight) -> CurveComparison:
    """Return a flown curve; an empty one if the log lacks its signals."""
    try:
        return CurveComparison(flight.curve(name))
    except MissingInputError as reason:
        unit = flight.find_signal(name).unit
        none = Series(name, unit, np.empty(0), np.empty(0))
        return CurveComparison(none, missing=str(reason))


def _checks(name: str, limit: SpecLimit, flight: CaseFlight) -> list[LimitCheck]:
    """Return the check of a limit; for a log with several steps, one for each."""
    measure = find_measure(name)
    parts = flight.parts if measure.need is Need.COMMAND else {flight.edge: flight}
    many = len(parts) > 1
    found = []
    try:
        for begin, part in parts.items():
            said = f"{name} of the step at {begin:.2f} s" if many else name
            value, doubt = measure.measured(part)
            found.append(LimitCheck(said, measure.unit_of(part), value, limit, doubt))
        if not found:
            raise MissingInputError(
                f"the setpoint has no step that is constant for {MIN_CONSTANT_COMMAND_S:g} s "
                "before and after "
                f"its edge: {' and '.join(LOOP_LOG_METRICS[:2])} work with any flight"
            )
    except MissingInputError as reason:
        skipped = isinstance(flight, JudgedLog) and flight.skip
        return [LimitCheck(name, measure.unit_of(flight), math.nan, limit, str(reason), skipped)]
    return found


def _check_loop_margins(spec: Spec, setup: Setup) -> tuple[LimitCheck, ...]:
    """Return the checks of the margins of a spec's loops, cut at their actuators.

    Args:
        spec: with its loops.
        setup: vehicle and rates, with the changes of a run.

    Raises:
        WorkbenchError: if the vehicle cannot be built, or cannot fly at the operating point of the
            spec.
    """
    # slow to load, and most specs have no margins
    from workbench.design.judge.margins import loop_margins
    from workbench.design.linear.operating_point import parse_point
    from workbench.design.linear.study import LinearStudy

    study = LinearStudy(setup)
    loops = [study.controller.loop(name) for name in spec.content.margins]
    point = parse_point(spec.content.at)
    # a loop that is closed only while a position is held is judged in that state
    points = [dataclasses.replace(point, hold=point.hold or loop.hold) for loop in loops]
    try:
        models = {at: study.sampled(at) for at in {point, *points}}
    except WorkbenchError as error:
        raise WorkbenchError(f"{read_yaml(spec.path).where('at')}{error}") from None
    found = []
    for loop, at in zip(loops, points, strict=True):
        margins = loop_margins(models[at], loop.point("actuator"))
        for name, limit in spec.content.margins[loop.name].items():
            value = float(getattr(margins, name))
            unit = find_metric(name).file_unit
            found.append(LimitCheck(f"{loop.name} {name}", unit, value, limit))
    return tuple(found)


def _curve_with_baseline(
    curve: CurveComparison, case: SpecCase, baselines: Mapping[str, Series], path: Path
) -> CurveComparison:
    """Return a flown curve with its baseline and its band, if required."""
    if curve.missing or curve.signal not in case.baseline:
        return curve
    baseline = baselines.get(curve.signal)
    if baseline is None or baseline.time[-1] < curve.flown.time[-1] - 1e-6:
        what = "has no baseline yet" if baseline is None else "is longer than its baseline"
        command = f"workbench regress {shlex.quote(str(path))} --update"
        sentence = f"{curve.signal} {what}: record it with `{command}`"
        return dataclasses.replace(curve, missing=sentence)
    allowed = band(baseline, case.baseline[curve.signal], curve.flown.time)
    return dataclasses.replace(curve, baseline=baseline, band=allowed)
