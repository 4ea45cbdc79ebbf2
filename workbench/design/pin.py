"""Pin a step as a regression: a spec, the gains it is about, and the baseline of its flight."""

import dataclasses
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from workbench.common.atomic_write import write_atomically
from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller, load_controller
from workbench.design.pin_limits import (
    LEAST,
    MEASURED,
    margin_limits,
    step_limits,
    step_tolerances,
)
from workbench.design.pin_text import spec_text
from workbench.design.regress.baseline import baseline_folder
from workbench.design.regress.flight import Changes
from workbench.design.regress.judging import Job, Measured, baseline_files, measure
from workbench.design.regress.running import regress
from workbench.design.regress.spec import Case, Limit, Spec, SpecFile
from workbench.design.regress.spec_names import MARGINS, SUFFIX, spec_name
from workbench.design.step_response import check_duration, check_step
from workbench.gains.gains import flight_gains, make_profile, save_gains
from workbench.plant.loading import make_vehicle
from workbench.scenario.axes import find_axis
from workbench.scenario.configured import read_configured
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Scenario

ANYTHING = Limit(min=-1e300)
"""A limit that only lets a number be measured."""


@dataclass(frozen=True)
class Pinned:
    """A regression that was written.

    Attributes:
        spec: its file.
        gains: the gain file beside it.
        baseline: the folder of its curves.
        limits: how many numbers of the step are limited.
        curves: how many of its curves have a baseline.
        loops: how many loops' margins are limited.
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
    duration: float = 3.0,
    margins: bool = True,
    overwrite: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Pinned:
    """Fly a step from hover and write what `workbench regress` holds later flights to.

    What is written is judged before this returns, and is green.

    Args:
        path: of the spec, NAME.spec.yaml; NAME.gains.yaml and NAME.baseline are written beside it.
        scenario: its vehicle and rates are pinned; world, sensors, start and script are a step's.
        gains: parameter values over those of the scenario.
        axis: x, y, z or yaw.
        amplitude: of the command [m/s] or [rad/s].
        duration: flown after the command's edge [s].
        margins: whether the margins of all loops at hover become limits too.
        overwrite: whether files that are there may be replaced.
        progress: called with the share that is done, 0 .. 1.

    Raises:
        WorkbenchError: if that makes no step, the flight is lost, a loop is unstable, a file is
            there already or cannot be written.
    """
    check_step(axis, amplitude)
    check_duration(duration)
    path = Path(path).expanduser().absolute()
    profile = _profile(path)
    _check_files(path, profile, overwrite)
    tell = progress or _tell_nobody
    vehicle = make_vehicle(read_configured(scenario.vehicle))
    law = load_controller(scenario.controller)
    settings = parameter_table(law).checked(gains)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, law)
    kept = make_profile(vehicle, values, f"pinned for {path.name}", law)
    title = f"{vehicle.name}: a step of {amplitude:g} {find_axis(axis).unit} along {axis}, pinned"
    case = Case(
        name=f"step {axis} {amplitude:g}",
        axis=axis,
        amplitude=amplitude,
        duration=duration,
        set={name: value for name, value in gains.items() if name not in kept.gains},
        limits=dict.fromkeys(MEASURED, ANYTHING),
        baseline=step_tolerances(axis, amplitude),
    )
    content = SpecFile(
        title=title,
        vehicle=dataclasses.replace(scenario.vehicle),
        controller=scenario.controller,
        rates=scenario.rates,
        cases=[case],
        margins=_all_margins(law) if margins else {},
    )
    spec = Spec(path, content)
    flown = _measured(spec, case.name, kept.gains)
    tell(0.4)
    case.limits = step_limits({each.name: each.value for each in flown.result.checks})
    if margins:
        content.margins = _margins(_measured(spec, MARGINS, kept.gains))
    tell(0.6)
    files = {
        **baseline_files(Job(spec, case.name), flown),
        path: spec_text(content, path, profile),
    }
    _make_folder(baseline_folder(path))
    with _Restoring([profile, *files]):
        save_gains(profile, kept, law)
        for file, text in files.items():  # the spec last: it must not stand alone
            write_atomically(file, text)
        _prove(path, scenario.controller)
        tell(1.0)  # who stops it here wants none of these files
    return Pinned(
        spec=path,
        gains=profile,
        baseline=baseline_folder(path),
        limits=len(case.limits),
        curves=len(case.baseline),
        loops=len(content.margins),
    )


class _Restoring:
    """Leaves files as they were if what is done meanwhile fails."""

    def __init__(self, files: list[Path]) -> None:
        self._before = {file: file.read_bytes() if file.is_file() else None for file in files}

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            return
        for file, content in self._before.items():
            if content is None:
                file.unlink(missing_ok=True)
            else:
                file.write_bytes(content)
        with suppress(OSError):  # not empty: it was there before
            baseline_folder(list(self._before)[-1]).rmdir()


def _tell_nobody(_: float) -> None:
    """Tell nobody how far it is."""


def _profile(path: Path) -> Path:
    """Return where a spec's gains are kept."""
    return path.with_name(f"{spec_name(path)}.gains.yaml")


def _check_files(path: Path, profile: Path, overwrite: bool) -> None:
    """Refuse names that are no spec's, and files that must not be lost."""
    if not path.name.endswith(SUFFIX) or path.name == SUFFIX:
        raise WorkbenchError(f"{path}: is no name for a spec: name it NAME{SUFFIX}")
    for file in (path, profile, baseline_folder(path)):
        if file.exists() and not overwrite:
            raise WorkbenchError(f"{file}: is there already: take another name, or overwrite it")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WorkbenchError(f"{folder}: cannot be made: {error.strerror}") from error


def _measured(spec: Spec, part: str, gains: Mapping[str, float]) -> Measured:
    """Return what a part of a spec comes to with gains.

    Raises:
        WorkbenchError: if the flight is lost.
    """
    found = measure(Job(spec, part, Changes(settings=gains)))
    if found.result.trouble:
        raise WorkbenchError(f"the step cannot be pinned: {found.result.trouble}")
    return found


def _all_margins(law: Controller) -> dict[str, dict[str, Limit]]:
    """Return limits on all margins, that let them be measured."""
    names = ("crossover", *LEAST)
    return {loop.name: dict.fromkeys(names, ANYTHING) for loop in law.loops}


def _margins(measured: Measured) -> dict[str, dict[str, Limit]]:
    """Return the limits of every loop that has margins.

    Raises:
        WorkbenchError: if one is unstable.
    """
    values: dict[str, dict[str, float]] = {}
    for check in measured.result.checks:
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
    """Judge what was written.

    Raises:
        WorkbenchError: if it is not green.
    """
    as_flown = Changes(controller=controller)
    failures = [said for result in regress([path], as_flown) for said in result.failures]
    if failures:
        raise WorkbenchError(f"{path}: what was pinned does not fly twice alike: {failures[0]}")
