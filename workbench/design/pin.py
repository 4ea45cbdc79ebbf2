"""Pin a step as a regression: a spec, its gains, and the baseline of its flight.

A log is pinned as a spec that compares later logs of the same flight with it.
"""

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import make_folder, write_atomically
from workbench.common.resources import SPEC_SUFFIX
from workbench.control.controller import Controller
from workbench.design.linear_step import DecayTimes
from workbench.design.load_step import acting_time
from workbench.design.pin_limits import (
    LIMIT_WITHOUT_EFFECT,
    PIN_MARGIN_SHARES,
    PINNED_LOAD_NUMBERS,
    PINNED_NUMBERS,
    load_tolerances,
    margin_limits,
    step_limits,
    step_tolerances,
)
from workbench.design.pin_spec import spec_text
from workbench.design.regress.baseline import baseline_folder
from workbench.design.regress.flight import Changes
from workbench.design.regress.running import Job, baseline_files, regress
from workbench.design.regress.spec import Spec, SpecCase, SpecFile, SpecLimit
from workbench.design.regress.spec_names import MARGINS_PART, SPEC_SUFFIXES, spec_name
from workbench.design.regress.verdict import CaseResult
from workbench.design.step_metrics import step_duration
from workbench.design.step_response import check_amplitude, check_duration, check_step
from workbench.estimation.settings import ESTIMATORS
from workbench.gains.gain_choice import make_profile
from workbench.gains.gains import save_gains
from workbench.parameters.flight_parameters import SIGNAL_PATH, VEHICLE_SYSTEMS
from workbench.scenario.loads import LOAD_NAMES, find_excited, find_load
from workbench.scenario.scenario import Scenario
from workbench.setup import make_setup


@dataclass(frozen=True)
class PinnedStep:
    """A regression that was written.

    Attributes:
        spec: its file.
        gains: the gain file beside it.
        baseline: folder of its curves.
        limits: number of limits on the step.
        curves: number of its curves with a baseline.
        loops: number of loops with limits on their margins.
    """

    spec: Path
    gains: Path
    baseline: Path
    limits: int
    curves: int
    loops: int


def pin_step(
    path: Path | str,
    scenario: Scenario,
    gains: Mapping[str, float],
    axis: str,
    amplitude: float,
    *,
    duration: float | None = None,
    acts: float | None = None,
    margins: bool = True,
    overwrite: bool = False,
    progress: Callable[[float], None] | None = None,
) -> PinnedStep:
    """Fly a step from hover and write a spec for `workbench regress` to judge later flights by.

    The spec is judged before this returns, and passes.

    Args:
        path: of the spec, NAME.workbench.yaml; NAME.gains.yaml and NAME.baseline are written beside
            it.
        scenario: its vehicle, estimator, sensors and rates are pinned; world, start and script are
            those of a step.
        gains: parameter values that replace those of the scenario.
        axis: x, y, z or yaw, or the name of a load, see `fly_load_step`.
        amplitude: of the command [m/s] or [rad/s], of a load [N], [N·m] or [m/s].
        duration: flown after the edge [s]; None for until a step has settled, see `step_duration`.
        acts: duration of the load [s], see `fly_load_step`.
        margins: whether to limit the margins of all loops at hover, too.
        overwrite: whether to replace existing files.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if the step is invalid, the flight is lost, a loop is unstable, or a file
            exists or cannot be written.
    """
    loaded = axis in LOAD_NAMES
    if loaded:
        check_amplitude(amplitude)
    else:
        check_step(axis, amplitude)
    setup = make_setup(scenario, gains)
    if duration is None:
        decay = 0.0 if loaded else DecayTimes(setup).of(axis)
        duration = step_duration(decay)
    check_duration(duration)
    if loaded:
        acting_time(find_load(axis), duration, acts)
    path = Path(path).expanduser().absolute()
    gain_file = path.with_name(f"{spec_name(path)}.gains.yaml")
    check_name(path, (path, gain_file, baseline_folder(path)), overwrite)
    tell = progress or (lambda share: None)
    if scenario.estimator not in ESTIMATORS:
        raise WorkbenchError(
            f"a spec flies on a shipped estimator, not on {scenario.estimator}: pin without it"
        )
    vehicle, law, table = setup.vehicle, setup.controller, setup.table
    kept = make_profile(vehicle, setup.values, f"pinned for {path.name}", law)
    # margins depend on them, and a spec computes margins without the settings of its cases
    systems = (*SIGNAL_PATH, *VEHICLE_SYSTEMS)
    felt = {name: x for name, x in gains.items() if table.find(name).system in systems}
    kept = dataclasses.replace(kept, gains={**kept.gains, **felt})
    unit = find_excited(axis).unit
    what = axis if loaded else f"along {axis}"
    title = f"{vehicle.name}: a step of {amplitude:g} {unit} {what}, pinned"
    case = SpecCase(
        name=f"step {axis} {amplitude:g}",
        axis="" if loaded else axis,
        load=axis if loaded else "",
        acts=acts,
        amplitude=amplitude,
        duration=duration,
        set={name: value for name, value in gains.items() if name not in kept.gains},
        limits=dict.fromkeys(
            PINNED_LOAD_NUMBERS if loaded else PINNED_NUMBERS, LIMIT_WITHOUT_EFFECT
        ),
        baseline=load_tolerances(axis, 1.0) if loaded else step_tolerances(axis, amplitude),
    )
    content = SpecFile(
        title=title,
        vehicle=dataclasses.replace(scenario.vehicle),
        controller=scenario.controller,
        estimator=scenario.estimator,
        sensors=scenario.sensors,
        rates=scenario.rates,
        cases=[case],
        margins=_all_margins(law) if margins else {},
    )
    spec = Spec(path, content)
    flown = _measure_part(spec, case.name, kept.gains)
    tell(0.4)
    values = {each.name: each.value for each in flown.checks}
    sure = {each.name: each.value for each in flown.checks if not each.doubt}
    case.limits = step_limits(sure)
    if loaded:
        case.baseline = load_tolerances(axis, values["peak"])
    if margins:
        content.margins = _loop_margin_limits(_measure_part(spec, MARGINS_PART, kept.gains))
    tell(0.6)
    files = {
        **baseline_files(Job(spec, case.name), flown),
        path: spec_text(content, path, gain_file, law),
    }
    make_folder(baseline_folder(path))
    with _restoring([gain_file, *files]):
        save_gains(gain_file, kept, law)
        for file, text in files.items():  # the spec last: it must not stand alone
            write_atomically(file, text)
        _prove(path, scenario.controller)
        tell(1.0)  # if that raises, as when a user stops it, these files go
    return PinnedStep(
        spec=path,
        gains=gain_file,
        baseline=baseline_folder(path),
        limits=len(case.limits),
        curves=len(case.baseline),
        loops=len(content.margins),
    )


@contextmanager
def _restoring(files: Sequence[Path]) -> Iterator[None]:
    """Restore files if the body of the `with` statement fails."""
    before = {file: file.read_bytes() if file.is_file() else None for file in files}
    try:
        yield
    except BaseException:
        for file, content in before.items():
            if content is None:
                file.unlink(missing_ok=True)
            else:
                file.write_bytes(content)
        with suppress(OSError):  # not empty: it was there before
            baseline_folder(files[-1]).rmdir()
        raise


def check_name(path: Path, files: Sequence[Path], overwrite: bool) -> None:
    """Check the name of a spec, and that no file would be lost.

    Raises:
        WorkbenchError: if the name must be different.
    """
    if not path.name.endswith(SPEC_SUFFIXES) or path.name in SPEC_SUFFIXES:
        raise WorkbenchError(f"{path}: is not a name for a spec: name it NAME{SPEC_SUFFIX}")
    for file in files:
        if file.exists() and not overwrite:
            raise WorkbenchError(
                f"{file}: exists already: take another name, or overwrite it with --force"
            )


def _measure_part(spec: Spec, part: str, gains: Mapping[str, float]) -> CaseResult:
    """Return the measured numbers of a part of a spec with gains.

    Raises:
        WorkbenchError: if the flight is lost.
    """
    found = Job(spec, part, Changes(settings=gains)).task.run()
    if found.trouble:
        raise WorkbenchError(f"the step cannot be pinned: {found.trouble}")
    return found


def _all_margins(law: Controller) -> dict[str, dict[str, SpecLimit]]:
    """Return limits without effect on all margins, so that they are measured."""
    names = ("crossover", *PIN_MARGIN_SHARES)
    return {loop.name: dict.fromkeys(names, LIMIT_WITHOUT_EFFECT) for loop in law.loops}


def _loop_margin_limits(measured: CaseResult) -> dict[str, dict[str, SpecLimit]]:
    """Return the limits of every loop that has margins.

    Raises:
        WorkbenchError: if one is unstable.
    """
    values: dict[str, dict[str, float]] = {}
    for check in measured.checks:
        loop, name = check.name.split(" ")
        values.setdefault(loop, {})[name] = check.value
    for loop, found in values.items():
        if found["disk_margin"] <= 0.0:
            raise WorkbenchError(
                f"the margins cannot be pinned: {loop} is not stable with these gains"
            )
    limits = {loop: margin_limits(found) for loop, found in values.items()}
    return {loop: found for loop, found in limits.items() if found}


def _prove(path: Path, controller: str) -> None:
    """Judge the spec written.

    Raises:
        WorkbenchError: if it does not pass.
    """
    as_flown = Changes(controller=controller)
    failures = [said for result in regress([path], as_flown) for said in result.failures]
    if failures:
        raise WorkbenchError(f"{path}: the pinned flight is not repeatable: {failures[0]}")
