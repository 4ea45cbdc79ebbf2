"""Pin a step as a regression: a spec, the gains it is about, and the baseline of its flight."""

import dataclasses
import math
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.common.resources import find_file, find_model, list_models
from workbench.common.yaml_files import dump_changes
from workbench.control.controller import DEFAULT, Controller, load_controller
from workbench.design.load_step import check_load
from workbench.design.regress.baseline import baseline_folder
from workbench.design.regress.flight import Changes
from workbench.design.regress.running import Job, baseline_files, regress
from workbench.design.regress.signals import AXIS_SIGNALS
from workbench.design.regress.spec import Case, Limit, Spec, SpecFile, Tolerance
from workbench.design.regress.spec_names import MARGINS, SUFFIX, spec_name
from workbench.design.regress.verdict import CaseResult
from workbench.design.step_response import check_duration, check_step
from workbench.estimation.settings import ESTIMATORS, TRUTH
from workbench.gains.gains import flight_gains, make_profile, save_gains
from workbench.plant.loading import make_vehicle
from workbench.scenario.configured import read_configured
from workbench.scenario.loads import LOADS, find_excited
from workbench.scenario.parameters import SIGNAL_PATH, parameter_table
from workbench.scenario.scenario import (
    Rates,
    Scenario,
    SensorsConfig,
    VehicleConfig,
    flown_controller,
)

_HEAD = """\
# Pinned from a flight: limits have room around what it was like, and baselines are its curves.
# The gains stand in the gain file beside this one, so no other profile changes what is flown.
"""
SHARES = {"rise_time": 0.12, "peak_tilt": 0.12}
"""Numbers that are held from both sides, with this share of room."""
SPANS = {"overshoot": 2.0, "steady_state_error": 0.5, "peak_rotor_use": 0.05}
"""Others that are, with so much room [%, %, 1]."""
MOST = {"settling_time": (1.4, 0.0), "coupling_z": (1.5, 0.01), "coupling_yaw": (1.5, 0.005)}
"""Numbers that may not become larger: than so many times what they were, and so much more."""
MEASURED = (*SHARES, *SPANS, *MOST)
"""All that is limited of a step."""
PEAK = 0.08
"""Share of room of a load's peak, to both sides."""
LOAD_MEASURED = ("peak", "settling_time", "steady_state_error", "peak_rotor_use")
"""All that is limited of a step of a load."""
LOAD_CURVE = 0.02
"""How far the curve of what a load moves may be off, as share of its peak."""
CURVES = {
    "x": {"v_x": (0.015, 0.002), "p_x": (0.002, 0.0005)},
    "y": {"v_y": (0.015, 0.002), "p_y": (0.002, 0.0005)},
    "z": {"v_z": (0.02, 0.002), "p_z": (0.0016, 0.0005)},
    "yaw": {"yaw_rate": (0.02, 0.0005), "yaw": (0.003, 0.0002)},
}
"""Curves of an axis: how far each may be off, as share of the amplitude, and at least [SI].

Half and twice the integrator's step stay within that; a gain of 0.7 times its value does not.
"""
CROSSOVER = 0.08
"""Room of crossover frequencies, to both sides."""
LEAST = {"phase_margin": 0.93, "gain_margin": 0.8, "delay_margin": 0.85, "disk_margin": 0.85}
"""Margins may not become smaller than this share; twice the integrator's step takes as much."""
DIGITS = 3
MUCH = 20.0
"""A larger gain margin is none that a loop is in want of, and follows the physics step."""
ANYTHING = Limit(min=-1e300)
"""A limit that only lets a number be measured."""


def spec_text(content: SpecFile, path: Path, profile: Path) -> str:
    """Return the text of a spec of one step, with a line for each limit.

    Args:
        content: of the spec.
        path: where it will be; files that it names are found from there.
        profile: the gain file beside it.
    """
    (case,) = content.cases
    law = load_controller(content.controller)
    flown = vehicle_head(content.vehicle, path.parent) | {"gains": profile.name}
    head: dict[str, object] = {"title": content.title, "vehicle": flown}
    if content.controller != DEFAULT:
        head["controller"] = _controller(content.controller, path.parent)
    if content.estimator != TRUTH:
        head["estimator"] = content.estimator
    if content.sensors != SensorsConfig():
        head["sensors"] = yaml.safe_load(dump_changes(content.sensors))
    if content.rates != Rates():
        head["rates"] = yaml.safe_load(dump_changes(content.rates))
    lines = [_HEAD + yaml.safe_dump(head, sort_keys=False, allow_unicode=True).rstrip("\n")]
    kind, step = ("load", case.load) if case.load else ("axis", case.axis)
    lines += ["cases:", f"  - name: {case.name}", f"    {kind}: {step}"]
    unit = find_excited(step).unit
    lines += [f"    amplitude: {case.amplitude!r} # {unit}", f"    duration: {case.duration!r} # s"]
    if case.acts is not None:
        lines += [f"    acts: {case.acts!r} # s"]
    if case.set:
        lines += ["    set:"]
        lines += [f"      {name}: {_number(name, value, law)}" for name, value in case.set.items()]
    lines += ["    limits:"]
    lines += [f"      {name}: {limit_text(limit)}" for name, limit in case.limits.items()]
    lines += ["    baseline:"]
    for signal, tolerance in case.baseline.items():
        lines += [f"      {signal}: {{absolute: {tolerance.absolute!r}}}"]
    if content.margins:
        lines += ["margins:"]
    for loop, limits in content.margins.items():
        lines += [f"  {loop}:"]
        lines += [f"    {name}: {limit_text(limit)}" for name, limit in limits.items()]
    return "\n".join(lines) + "\n"


def _number(name: str, value: float, law: Controller) -> str:
    unit = parameter_table(law).find(name).unit
    return f"{value!r}" if unit == "1" else f"{value!r} # {unit}"


def limit_text(limit: Limit) -> str:
    """Return a limit as a spec has it."""
    if limit.min > -float("inf") and limit.max < float("inf"):
        return f"[{limit.min!r}, {limit.max!r}]"
    if limit.max < float("inf"):
        return f"{{max: {limit.max!r}}}"
    return f"{{min: {limit.min!r}}}"


def _controller(name: str, folder: Path) -> str:
    """Return a controller as a spec in a folder names it."""
    return _beside(Path(name).resolve(), folder) if name.endswith(".py") else name


def vehicle_head(config: VehicleConfig, folder: Path) -> dict[str, object]:
    """Return a vehicle as a spec in a folder names it, without its gains."""
    found: dict[str, object] = {"model": config.model}
    found |= yaml.safe_load(dump_changes(config)) or {}
    if config.model not in list_models():
        found["model"] = _beside(find_model(config.model), folder)
    if config.rotors:
        found["rotors"] = _beside(find_file(config.rotors), folder)
    if config.packages:
        found["packages"] = {
            name: _beside(Path(place).expanduser().resolve(), folder)
            for name, place in config.packages.items()
        }
    found.pop("gains", None)
    return found


def _beside(file: Path, folder: Path) -> str:
    """Return a file's path as seen from a folder, where both lie in the same tree."""
    home = folder.resolve()
    if Path(os.path.commonpath([file, home])) == Path(file.anchor):
        return str(file)
    return os.path.relpath(file, home)


def step_limits(measured: Mapping[str, float]) -> dict[str, Limit]:
    """Return limits of a step's metrics, those that have a value."""
    found = {}
    for name, value in measured.items():
        if not math.isfinite(value):
            continue
        if name in SHARES or name == "peak":
            room = SHARES.get(name, PEAK) * abs(value)
            found[name] = limit_between(value - room, value + room)
        elif name in SPANS:
            found[name] = limit_between(value - SPANS[name], value + SPANS[name])
        else:
            times, more = MOST[name]
            found[name] = Limit(max=_rounded(times * value + more, up=True))
    return found


def load_tolerances(load: str, peak: float) -> dict[str, Tolerance]:
    """Return how far the curve of what a load moves may be from its baseline."""
    return {AXIS_SIGNALS[load]: Tolerance(absolute=_rounded(LOAD_CURVE * peak, up=True))}


def step_tolerances(axis: str, amplitude: float) -> dict[str, Tolerance]:
    """Return how far the curves of a step along an axis may be from their baselines."""
    return {
        signal: Tolerance(absolute=_rounded(max(share * abs(amplitude), least), up=True))
        for signal, (share, least) in CURVES[axis].items()
    }


def margin_limits(measured: Mapping[str, float]) -> dict[str, Limit]:
    """Return limits of a loop's margins, those that have a value."""
    found = {}
    for name, value in measured.items():
        if not math.isfinite(value):
            continue
        if name == "crossover":
            found[name] = limit_between((1.0 - CROSSOVER) * value, (1.0 + CROSSOVER) * value)
        elif name in LEAST and value > 0.0:
            found[name] = Limit(min=_rounded(_less(name, value), up=False))
    return found


def _less(name: str, value: float) -> float:
    """Return the least that a margin may come to; a gain margin is a factor above 1."""
    if name == "gain_margin":
        return 1.0 + LEAST[name] * (min(value, MUCH) - 1.0)
    return LEAST[name] * value


def limit_between(low: float, high: float) -> Limit:
    """Return a limit with few digits around a span; none of its numbers can be below 0."""
    if low <= 0.0:
        return Limit(max=_rounded(high, up=True))
    return Limit(min=_rounded(low, up=False), max=_rounded(high, up=True))


def _rounded(value: float, *, up: bool) -> float:
    """Return a number with few digits, on the safe side."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - DIGITS)
    steps = math.ceil(value / unit) if up else math.floor(value / unit)
    return float(f"{steps * unit:.{DIGITS + 1}g}")


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
    acts: float | None = None,
    margins: bool = True,
    overwrite: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Pinned:
    """Fly a step from hover and write what `workbench regress` holds later flights to.

    What is written is judged before this returns, and is green.

    Args:
        path: of the spec, NAME.spec.yaml; NAME.gains.yaml and NAME.baseline are written beside it.
        scenario: its vehicle, estimator, sensors and rates are pinned; world, start and script are
            a step's.
        gains: parameter values over those of the scenario.
        axis: x, y, z or yaw, or the name of a load, see `fly_load_step`.
        amplitude: of the command [m/s] or [rad/s], of a load [N], [N·m] or [m/s].
        duration: flown after the edge [s].
        acts: for how long the load acts [s], see `fly_load_step`.
        margins: whether the margins of all loops at hover become limits too.
        overwrite: whether files that are there may be replaced.
        progress: called with the share that is done, 0 .. 1.

    Raises:
        WorkbenchError: if that makes no step, the flight is lost, a loop is unstable, a file is
            there already or cannot be written.
    """
    loaded = axis in LOADS
    (check_load if loaded else check_step)(axis, amplitude)
    check_duration(duration)
    path = Path(path).expanduser().absolute()
    profile = _profile(path)
    check_name(path, (path, profile, baseline_folder(path)), overwrite)
    tell = progress or _tell_nobody
    if scenario.estimator not in ESTIMATORS:
        raise WorkbenchError(
            f"a spec flies on a shipped estimator, and not on {scenario.estimator}: pin without it"
        )
    vehicle = make_vehicle(read_configured(scenario.vehicle))
    law = flown_controller(scenario)
    settings = parameter_table(law).checked(gains)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, law)
    kept = make_profile(vehicle, values, f"pinned for {path.name}", law)
    # margins feel them, and those of a spec know no settings of its cases
    table = parameter_table(law)
    felt = {name: x for name, x in gains.items() if table.find(name).system in SIGNAL_PATH}
    kept = dataclasses.replace(kept, gains={**kept.gains, **felt})
    unit = find_excited(axis).unit
    what = axis if loaded else f"along {axis}"
    title = f"{vehicle.name}: a step of {amplitude:g} {unit} {what}, pinned"
    case = Case(
        name=f"step {axis} {amplitude:g}",
        axis="" if loaded else axis,
        load=axis if loaded else "",
        acts=acts,
        amplitude=amplitude,
        duration=duration,
        set={name: value for name, value in gains.items() if name not in kept.gains},
        limits=dict.fromkeys(LOAD_MEASURED if loaded else MEASURED, ANYTHING),
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
    flown = _measured(spec, case.name, kept.gains)
    tell(0.4)
    values = {each.name: each.value for each in flown.checks}
    case.limits = step_limits(values)
    if loaded:
        case.baseline = load_tolerances(axis, values["peak"])
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


def check_name(path: Path, files: Sequence[Path], overwrite: bool) -> None:
    """Refuse names that are no spec's, and files that must not be lost.

    Raises:
        WorkbenchError: naming what is to be named otherwise.
    """
    if not path.name.endswith(SUFFIX) or path.name == SUFFIX:
        raise WorkbenchError(f"{path}: is no name for a spec: name it NAME{SUFFIX}")
    for file in files:
        if file.exists() and not overwrite:
            raise WorkbenchError(
                f"{file}: is there already: take another name, or overwrite it with --force"
            )


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WorkbenchError(f"{folder}: cannot be made: {error.strerror}") from error


def _measured(spec: Spec, part: str, gains: Mapping[str, float]) -> CaseResult:
    """Return what a part of a spec comes to with gains.

    Raises:
        WorkbenchError: if the flight is lost.
    """
    found = Job(spec, part, Changes(settings=gains)).run()
    if found.trouble:
        raise WorkbenchError(f"the step cannot be pinned: {found.trouble}")
    return found


def _all_margins(law: Controller) -> dict[str, dict[str, Limit]]:
    """Return limits on all margins, that let them be measured."""
    names = ("crossover", *LEAST)
    return {loop.name: dict.fromkeys(names, ANYTHING) for loop in law.loops}


def _margins(measured: CaseResult) -> dict[str, dict[str, Limit]]:
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
    """Judge what was written.

    Raises:
        WorkbenchError: if it is not green.
    """
    as_flown = Changes(controller=controller)
    failures = [said for result in regress([path], as_flown) for said in result.failures]
    if failures:
        raise WorkbenchError(f"{path}: what was pinned does not fly twice alike: {failures[0]}")
