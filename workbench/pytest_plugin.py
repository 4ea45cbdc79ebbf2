"""The pytest plugin: specs become test items, and a fixture flies steps.

Loaded with every run of pytest where the workbench is installed, so it loads nothing heavy itself;
what flies is loaded when the first spec runs.
"""

from collections.abc import Callable, Iterator
from fnmatch import fnmatch
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.common.plain_text import visible

if TYPE_CHECKING:
    from workbench.design.step_response import StepResponse

SPEC_PATTERN_OPTION = "workbench_spec_files"
UPDATE_OPTION = "workbench_update"
REGEN_OPTION = "force_regen"
"""Also the one of pytest-regressions."""


class RegressionError(Exception):
    """A case is not as its spec demands; its text is all that a reader needs."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add --force-regen, --workbench-update, and the pattern of specs' names."""
    group = parser.getgroup("workbench", "step-response regressions")
    what = "record the baselines of the collected specs again; their limits are judged all the same"
    if find_spec("pytest_regressions") is None:  # which has the option, for the same
        group.addoption("--force-regen", action="store_true", dest=REGEN_OPTION, help=what)
    group.addoption(
        "--workbench-update",
        action="store_true",
        dest=UPDATE_OPTION,
        help=f"as --force-regen, for these baselines alone: {what}",
    )
    parser.addini(
        SPEC_PATTERN_OPTION,
        "patterns of the names of spec files",
        type="args",
        default=["*.workbench.yaml", "*.spec.yaml"],
    )


def pytest_collect_file(parent: pytest.Collector, file_path: Path) -> pytest.Collector | None:
    """Return a collector for a spec."""
    if any(
        fnmatch(file_path.name, pattern) for pattern in parent.config.getini(SPEC_PATTERN_OPTION)
    ):
        collector: pytest.Collector = SpecCollector.from_parent(parent, path=file_path)
        return collector
    return None


class SpecCollector(pytest.File):
    """A spec: an item a case, and one for its margins."""

    def collect(self) -> Iterator[pytest.Item]:
        from workbench.design.regress.spec_names import part_names

        try:
            names = part_names(self.path)
        except WorkbenchError as error:
            raise self.CollectError(str(error)) from None
        for name in names:
            yield SpecItem.from_parent(self, name=name)


class SpecItem(pytest.Item):
    """One case of a spec, or its margins."""

    def runtest(self) -> None:
        from workbench.design.regress.loading import load_spec
        from workbench.design.regress.running import Job, baseline_files, compare_to_baseline
        from workbench.logs.judged_log import read_case

        # a controller of this repository runs as its conftest.py does
        spec = load_spec(self.path, trusted=self.config.rootpath)
        job = Job(spec, self.name).with_log(read_case)
        flown = job.task.run()
        if self.config.getoption(UPDATE_OPTION) or self.config.getoption(REGEN_OPTION, False):
            for path, text in baseline_files(job, flown).items():
                path.parent.mkdir(exist_ok=True)
                write_atomically(path, text)
        result = compare_to_baseline(job, flown)
        if not result.passed:
            raise RegressionError("\n".join(result.story))
        if result.skipped:
            pytest.skip("; ".join(result.skips))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return sentences where that says all, and a traceback only for what is unforeseen."""
        if isinstance(excinfo.value, RegressionError | WorkbenchError):
            return visible(str(excinfo.value))
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        return self.path, None, f"{self.path.name}: {self.name}"


@pytest.fixture(scope="session")
def step_response() -> Callable[..., "StepResponse"]:
    """Return a function that flies a step: `step_response(axis, amplitude, **fly_step's own)`.

    Equal steps are flown once a session.
    """
    from workbench.design.step_response import fly_step

    flown: dict[str, StepResponse] = {}

    def fly(axis: str, amplitude: float, **options: Any) -> "StepResponse":
        # Scenarios are plain dataclasses: their text says all that they are.
        key = repr((axis, float(amplitude), sorted(options.items())))
        if key not in flown:
            flown[key] = fly_step(axis, amplitude, **options)
        return flown[key]

    return fly
