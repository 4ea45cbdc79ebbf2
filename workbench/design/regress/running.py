"""Run specs: fly their cases in processes or on a cluster, compare, and record baselines."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Self

from workbench.design.executor.executor import Executor, InThisProcess, LocalProcesses
from workbench.design.regress.flight import Changes, changed
from workbench.design.regress.judging import (
    Job,
    Measured,
    ReadLog,
    baseline_files,
    compare,
    measure,
)
from workbench.design.regress.loading import check_named, load_spec
from workbench.design.regress.spec_names import MARGINS
from workbench.design.regress.verdict import CaseResult
from workbench.scenario.scenario import Scenario

Progress = Callable[[float], None]


class Recorded(NamedTuple):
    """Results without bands, and the text of each file of the baselines."""

    results: list[CaseResult]
    files: dict[Path, str]


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
        changes: what is to be otherwise than in the specs.
        processes: that fly; 1 flies in this one.
        executor: where cases fly instead, as on a cluster.
        progress: called with the share that is done, 0 .. 1.
        read_log: makes the flight of a case that has a log,
            `workbench.logs.judged_log.read_case`.

    Returns:
        A result for each case, and one for a spec's margins, in the order of the specs.

    Raises:
        WorkbenchError: if a spec is wrong or its vehicle cannot be built.
    """
    jobs = all_jobs(specs, changes or Changes(), read_log)
    measured = measure_all(jobs, executor or local(processes), progress)
    return [compare(job, each) for job, each in zip(jobs, measured, strict=True)]


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
        controller: that they name; a file of Python that only they name does not run.
        processes: that fly; 1 flies in this one.
        executor: where cases fly instead, as on a cluster.
        progress: called with the share that is done, 0 .. 1.
        read_log: as for `regress`.

    Raises:
        WorkbenchError: if a spec is wrong or its vehicle cannot be built.
    """
    for path in specs:
        check_named(Path(path), controller)
    jobs = all_jobs(specs, Changes(controller=controller), read_log)
    measured = measure_all(jobs, executor or local(processes), progress)
    files: dict[Path, str] = {}
    for job, each in zip(jobs, measured, strict=True):
        files |= baseline_files(job, each)
    return Recorded([each.result for each in measured], files)


def all_jobs(
    specs: Sequence[Path | str], changes: Changes, read_log: ReadLog | None = None
) -> list[Job]:
    """Return a job for each case of specs, and one for a spec's margins."""
    found = []
    for path in specs:
        spec = load_spec(path, changes.controller)
        parts = [case.name for case in spec.content.cases] + [MARGINS] * bool(spec.content.margins)
        found += [Job(spec, part, changes) for part in parts]
    return [job.with_log(read_log) for job in found] if read_log else found


def local(processes: int) -> Executor:
    """Return what flies in so many processes; one is this one."""
    return LocalProcesses(processes) if processes > 1 else InThisProcess()


def measure_all(
    jobs: Sequence[Job], executor: Executor, progress: Progress | None = None
) -> list[Measured]:
    """Return what each job came to, in the order of the jobs."""
    found: dict[int, Measured] = {}
    for index, measured in executor.run([Measuring(job) for job in jobs]):
        found[index] = measured
        if progress:
            progress(len(found) / len(jobs))
    return [found[index] for index in range(len(jobs))]


@dataclass(frozen=True)
class Measuring:
    """One job's flight or margins, to be done anywhere; see `executor.Task`."""

    job: Job

    @property
    def scenario(self) -> Scenario:
        """What names the files that are read for it."""
        return changed(self.job.spec, self.job.changes)

    def with_scenario(self, scenario: Scenario) -> Self:
        """Return the same job with the files of that scenario."""
        spec = self.job.spec
        content = dataclasses.replace(
            spec.content,
            vehicle=scenario.vehicle,
            controller=scenario.controller,
            world=scenario.world,
        )
        moved = dataclasses.replace(spec, content=content)
        return dataclasses.replace(self, job=dataclasses.replace(self.job, spec=moved))

    def run(self) -> Measured:
        """Return what the job comes to."""
        return measure(self.job)
