"""Run specs: fly their cases in processes, compare, and record baselines."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from workbench.design.regress.flight import Changes
from workbench.design.regress.judging import Job, Measured, baseline_files, compare, measure
from workbench.design.regress.loading import load_spec
from workbench.design.regress.spec_names import MARGINS
from workbench.design.regress.verdict import CaseResult

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
    progress: Progress | None = None,
) -> list[CaseResult]:
    """Fly the cases of specs and judge them.

    Args:
        specs: their files.
        changes: what is to be otherwise than in the specs.
        processes: that fly; 1 flies in this one.
        progress: called with the share that is done, 0 .. 1.

    Returns:
        A result for each case, and one for a spec's margins, in the order of the specs.

    Raises:
        WorkbenchError: if a spec is wrong or its vehicle cannot be built.
    """
    jobs = all_jobs(specs, changes or Changes())
    measured = measure_all(jobs, processes, progress)
    return [compare(job, each) for job, each in zip(jobs, measured, strict=True)]


def record(
    specs: Sequence[Path | str], *, processes: int = 1, progress: Progress | None = None
) -> Recorded:
    """Fly the cases of specs for their baselines, and judge their limits.

    Args:
        specs: their files.
        processes: that fly; 1 flies in this one.
        progress: called with the share that is done, 0 .. 1.

    Raises:
        WorkbenchError: if a spec is wrong or its vehicle cannot be built.
    """
    jobs = all_jobs(specs, Changes())
    measured = measure_all(jobs, processes, progress)
    files: dict[Path, str] = {}
    for job, each in zip(jobs, measured, strict=True):
        files |= baseline_files(job, each)
    return Recorded([each.result for each in measured], files)


def all_jobs(specs: Sequence[Path | str], changes: Changes) -> list[Job]:
    """Return a job for each case of specs, and one for a spec's margins."""
    found = []
    for path in specs:
        spec = load_spec(path)
        parts = [case.name for case in spec.content.cases] + [MARGINS] * bool(spec.content.margins)
        found += [Job(spec, part, changes) for part in parts]
    return found


def measure_all(
    jobs: Sequence[Job], processes: int, progress: Progress | None = None
) -> list[Measured]:
    """Return what each job came to, in the order of the jobs.

    Processes are started anew instead of forked, as threads of Drake and numba do not survive that.
    """
    found: dict[int, Measured] = {}
    for index, measured in _as_done(jobs, min(processes, len(jobs))):
        found[index] = measured
        if progress:
            progress(len(found) / len(jobs))
    return [found[index] for index in range(len(jobs))]


def _as_done(jobs: Sequence[Job], processes: int) -> Iterator[tuple[int, Measured]]:
    """Yield the place of each job and what it came to, as they get done."""
    if processes <= 1:
        yield from enumerate(map(measure, jobs))
        return
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        places = {pool.submit(measure, job): index for index, job in enumerate(jobs)}
        try:
            for done in as_completed(places):
                yield places[done], done.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
