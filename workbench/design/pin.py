"""Pin a step as a regression: a spec, its gains, and the baseline of its flight.

A log is pinned as a spec that compares later logs of the same flight with it.
"""

import dataclasses
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.common.resources import find_file, find_model, list_models
from workbench.common.yaml_files import changes_of
from workbench.control.controller import DEFAULT, Controller, load_controller
from workbench.design.linear_step import DecayTimes
from workbench.design.load_step import acting_time, check_load
from workbench.design.regress.baseline import baseline_folder
from workbench.design.regress.flight import Changes
from workbench.design.regress.running import Job, ReadLog, baseline_files, regress
from workbench.design.regress.signals import AXIS_SIGNALS
from workbench.design.regress.spec import Case, Limit, LogConfig, Spec, SpecFile, Tolerance
from workbench.design.regress.spec_names import MARGINS, SUFFIX, spec_name
from workbench.design.regress.verdict import CaseResult
from workbench.design.response_metrics import step_duration
from workbench.design.step_response import check_duration, check_step
from workbench.estimation.settings import ESTIMATORS, TRUTH
from workbench.gains.gains import flight_gains, make_profile, save_gains
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.loads import LOADS, find_excited, find_load
from workbench.scenario.parameters import SIGNAL_PATH, parameter_table
from workbench.scenario.scenario import (
    Rates,
    Scenario,
    SensorsConfig,
    VehicleConfig,
    flown_controller,
)

_HEAD = """\
# Pinned from a flight: limits leave room around its numbers, and baselines are its curves.
# The gains are in the gain file beside this one, so no other gain file changes what is flown.
"""
SHARES = {"rise_time": 0.12, "peak_tilt": 0.12}
"""Numbers with limits on both sides, at this share of the value."""
SPANS = {"overshoot": 2.0, "steady_state_error": 0.5, "peak_rotor_use": 0.05}
"""Others, at this distance [%, %, 1]."""
MOST = {"settling_time": (1.4, 0.0), "coupling_z": (1.5, 0.01), "coupling_yaw": (1.5, 0.005)}
"""Numbers with an upper limit only: a factor on the measured value, and an offset."""
MEASURED = (*SHARES, *SPANS, *MOST)
"""Numbers of a step that get limits."""
PEAK = 0.08
"""Limits of the peak under a load lie this share of its value to both sides."""
LOAD_MEASURED = ("peak", "settling_time", "steady_state_error", "peak_rotor_use")
"""Numbers of a step of a load that get limits."""
LOAD_CURVE = 0.02
"""Tolerance of the curve of the response to a load, as a share of its peak."""
CURVES = {
    "x": {"v_x": (0.015, 0.002), "p_x": (0.002, 0.0005)},
    "y": {"v_y": (0.015, 0.002), "p_y": (0.002, 0.0005)},
    "z": {"v_z": (0.02, 0.002), "p_z": (0.0016, 0.0005)},
    "yaw": {"yaw_rate": (0.02, 0.0005), "yaw": (0.003, 0.0002)},
}
"""Tolerances of the curves of an axis: share of the amplitude, and smallest tolerance [SI].

Half and twice the step of the integrator stay within them, 0.7 times a gain does not."""
CROSSOVER = 0.08
"""Tolerance of crossover frequencies to both sides."""
LEAST = {"phase_margin": 0.93, "gain_margin": 0.8, "delay_margin": 0.85, "disk_margin": 0.85}
"""Lower limit of margins as a share of the value; twice the integrator step costs as much."""
DIGITS = 3
MUCH = 20.0
"""Gain margins count up to this value; larger ones are ample, and depend on the physics step."""
ANYTHING = Limit(min=-1e300)
"""A limit without effect, which only makes a number be measured."""
_LOG_HEAD = """\
# Pinned from a log: limits leave room for the differences between flights of one plan. For another
# flight of the plan, change the name of the file under log.
"""
LOG_SHARES = {"rise_time": 0.25, "lag": 0.25, "measured_rise_time": 0.25}
"""Numbers of a log with limits on both sides, at this share of the value.

This is the usual difference between flights of one plan: in 34 pairs of real flights of one
trajectory (NanoBench), the second is within each limit of the first in 91 to 100 %."""
LOG_MOST = {
    "overshoot": (1.0, 5.0),
    "measured_overshoot": (1.0, 5.0),
    "settling_time": (1.5, 0.0),
    "tracking_error": (1.5, 0.0),
    "mean_rotor_use": (1.0, 0.1),
    "saturation": (1.0, 10.0),
    "trim": (1.0, 0.1),
    "peak_tilt": (1.5, 0.0),
}
"""Numbers of a log with an upper limit only: a factor on the measured value, and an offset."""
OF_LOOP = ("rise_time", "settling_time", "overshoot", "tracking_error", "lag", "measured_rise_time",
           "measured_overshoot")  # fmt: skip
"""Those of them that need a loop."""
MARKED = ("rise_time", "settling_time", "overshoot")
"""Numbers of steps that are left out where they are withheld, such as for a step that has not
settled."""
_NOT_IN_NAMES = re.compile(r"^[^A-Za-z0-9]+|[^A-Za-z0-9 _.+-]")


def spec_text(content: SpecFile, path: Path, gain_file: Path) -> str:
    """Return the text of a spec of one step, with a line for each limit.

    Args:
        content: what the spec states.
        path: of the spec; files named in it are relative to it.
        gain_file: the one beside it.
    """
    (case,) = content.cases
    law = load_controller(content.controller)
    flown = vehicle_head(content.vehicle, path.parent) | {"gains": gain_file.name}
    head: dict[str, object] = {"title": content.title, "vehicle": flown}
    if content.controller != DEFAULT:
        head["controller"] = _controller(content.controller, path.parent)
    if content.estimator != TRUTH:
        head["estimator"] = content.estimator
    if content.sensors != SensorsConfig():
        head["sensors"] = changes_of(content.sensors)
    if content.rates != Rates():
        head["rates"] = changes_of(content.rates)
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
    """Return a limit in the form used in a spec."""
    if limit.min > -float("inf") and limit.max < float("inf"):
        return f"[{limit.min!r}, {limit.max!r}]"
    if limit.max < float("inf"):
        return f"{{max: {limit.max!r}}}"
    return f"{{min: {limit.min!r}}}"


def _controller(name: str, folder: Path) -> str:
    """Return the name of a controller for a spec in a folder."""
    return _beside(Path(name).resolve(), folder) if name.endswith(".py") else name


def vehicle_head(config: VehicleConfig, folder: Path) -> dict[str, object]:
    """Return the head of a spec in a folder that names a vehicle, without its gains."""
    found: dict[str, object] = {"model": config.model, **changes_of(config)}
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
    """Return the path of a file relative to a folder, if both lie in the same tree."""
    home = folder.resolve()
    if Path(os.path.commonpath([file, home])) == Path(file.anchor):
        return str(file)
    return os.path.relpath(file, home)


def step_limits(measured: Mapping[str, float]) -> dict[str, Limit]:
    """Return limits of those metrics of a step that have a value."""
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
    """Return the tolerance of the response to a load."""
    return {AXIS_SIGNALS[load]: Tolerance(absolute=_rounded(LOAD_CURVE * peak, up=True))}


def step_tolerances(axis: str, amplitude: float) -> dict[str, Tolerance]:
    """Return the tolerances of the curves of a step along an axis."""
    return {
        signal: Tolerance(absolute=_rounded(max(share * abs(amplitude), least), up=True))
        for signal, (share, least) in CURVES[axis].items()
    }


def margin_limits(measured: Mapping[str, float]) -> dict[str, Limit]:
    """Return limits of those margins of a loop that have a value."""
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
    """Return the lower limit of a margin; a gain margin is a factor above 1."""
    if name == "gain_margin":
        return 1.0 + LEAST[name] * (min(value, MUCH) - 1.0)
    return LEAST[name] * value


def limit_between(low: float, high: float) -> Limit:
    """Return a limit with few digits around a span; its numbers are never below 0."""
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
) -> Pinned:
    """Fly a step from hover and write a spec for `workbench regress` to judge later flights by.

    The spec is judged before this returns, and passes.

    Args:
        path: of the spec, NAME.spec.yaml; NAME.gains.yaml and NAME.baseline are written beside it.
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
    loaded = axis in LOADS
    (check_load if loaded else check_step)(axis, amplitude)
    if duration is None:
        decay = 0.0 if loaded else DecayTimes(scenario).of(axis, gains)
        duration = step_duration(decay)
    check_duration(duration)
    if loaded:
        acting_time(find_load(axis), duration, acts)
    path = Path(path).expanduser().absolute()
    gain_file = _gain_file(path)
    check_name(path, (path, gain_file, baseline_folder(path)), overwrite)
    tell = progress or (lambda share: None)
    if scenario.estimator not in ESTIMATORS:
        raise WorkbenchError(
            f"a spec flies on a shipped estimator, not on {scenario.estimator}: pin without it"
        )
    vehicle = configured_vehicle(scenario.vehicle)
    law = flown_controller(scenario)
    settings = parameter_table(law).checked(gains)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, law)
    kept = make_profile(vehicle, values, f"pinned for {path.name}", law)
    # margins depend on them, and a spec computes margins without the settings of its cases
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
    sure = {each.name: each.value for each in flown.checks if not each.doubt}
    case.limits = step_limits(sure)
    if loaded:
        case.baseline = load_tolerances(axis, values["peak"])
    if margins:
        content.margins = _margins(_measured(spec, MARGINS, kept.gains))
    tell(0.6)
    files = {
        **baseline_files(Job(spec, case.name), flown),
        path: spec_text(content, path, gain_file),
    }
    _make_folder(baseline_folder(path))
    with _restoring([gain_file, *files]):
        save_gains(gain_file, kept, law)
        for file, text in files.items():  # the spec last: it must not stand alone
            write_atomically(file, text)
        _prove(path, scenario.controller)
        tell(1.0)  # if that raises, as when a user stops it, these files go
    return Pinned(
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


def _gain_file(path: Path) -> Path:
    """Return the path of the gain file of a spec."""
    return path.with_name(f"{spec_name(path)}.gains.yaml")


def check_name(path: Path, files: Sequence[Path], overwrite: bool) -> None:
    """Check the name of a spec, and that no file would be lost.

    Raises:
        WorkbenchError: if the name must be different.
    """
    if not path.name.endswith(SUFFIX) or path.name == SUFFIX:
        raise WorkbenchError(f"{path}: is not a name for a spec: name it NAME{SUFFIX}")
    for file in files:
        if file.exists() and not overwrite:
            raise WorkbenchError(
                f"{file}: exists already: take another name, or overwrite it with --force"
            )


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WorkbenchError(f"{folder}: cannot be made: {error.strerror}") from error


def _measured(spec: Spec, part: str, gains: Mapping[str, float]) -> CaseResult:
    """Return the measured numbers of a part of a spec with gains.

    Raises:
        WorkbenchError: if the flight is lost.
    """
    found = Job(spec, part, Changes(settings=gains)).task.run()
    if found.trouble:
        raise WorkbenchError(f"the step cannot be pinned: {found.trouble}")
    return found


def _all_margins(law: Controller) -> dict[str, dict[str, Limit]]:
    """Return limits without effect on all margins, so that they are measured."""
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
    """Judge the spec written.

    Raises:
        WorkbenchError: if it does not pass.
    """
    as_flown = Changes(controller=controller)
    failures = [said for result in regress([path], as_flown) for said in result.failures]
    if failures:
        raise WorkbenchError(f"{path}: the pinned flight is not repeatable: {failures[0]}")


@dataclass(frozen=True)
class PinnedLog:
    """A regression that was written.

    Attributes:
        spec: its file.
        limits: their number.
        left_out: why other numbers have no limit, by name.
    """

    spec: Path
    limits: int
    left_out: dict[str, str]


def pin_log(
    path: Path | str,
    vehicle: VehicleConfig,
    log: LogConfig,
    loop: str,
    read_log: ReadLog,
    *,
    overwrite: bool = False,
) -> PinnedLog:
    """Write a spec that compares later logs of a flight with this one.

    Args:
        path: of the spec, NAME.spec.yaml.
        vehicle: the one that flew.
        log: the log and the part of it.
        loop: the one to judge the response of; "" for none.
        read_log: reads the flight, such as `workbench.logs.judged_log.read_case`.
        overwrite: whether to replace an existing spec.

    Raises:
        WorkbenchError: if the log cannot be read or yields no number, or a file exists or cannot be
            written.
    """
    path = Path(path).expanduser().absolute()
    check_name(path, (path,), overwrite)
    for name in filter(None, (log.file, log.mapping)):
        find_file(name)
    place = Path(log.file).expanduser().absolute()
    mapping = str(Path(log.mapping).expanduser().absolute()) if log.mapping else ""
    log = dataclasses.replace(log, file=str(place), mapping=mapping)
    names = [name for name in (*LOG_SHARES, *LOG_MOST) if loop or name not in OF_LOOP]
    case = Case(name=_NOT_IN_NAMES.sub("-", place.name.split(".")[0]), log=log, loop=loop)
    case.limits = dict.fromkeys(names, ANYTHING)
    content = SpecFile(title=f"{place.name}, pinned", vehicle=vehicle, cases=[case])
    spec = Spec(path, content)
    job = Job(spec, case.name, logged=read_log(spec, case))
    found: dict[str, list[float]] = {}
    left_out: dict[str, str] = {}
    for check in job.task.run().checks:
        name = check.name.split(" ")[0]
        if math.isnan(check.value) or (check.doubt and name in MARKED):
            left_out[name] = check.doubt
        else:
            found.setdefault(name, []).append(check.value)
    # The spec will judge each step. If the number is withheld for one of them, none gets a limit.
    limits = {
        name: log_limit(name, values) for name, values in found.items() if name not in left_out
    }
    if not limits:
        raise WorkbenchError(f"{place}: has nothing that can be pinned: {left_out[names[0]]}")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, _log_text(path, vehicle, case, limits))
    return PinnedLog(path, len(limits), left_out)


def log_limit(name: str, values: list[float]) -> Limit:
    """Return the limit of a metric; a log has one value of it, or one for each step."""
    if name in LOG_SHARES:
        return limit_between(
            (1.0 - LOG_SHARES[name]) * min(values), (1.0 + LOG_SHARES[name]) * max(values)
        )
    times, more = LOG_MOST[name]
    return limit_between(0.0, times * max(values) + more)


def _log_text(path: Path, vehicle: VehicleConfig, case: Case, limits: dict[str, Limit]) -> str:
    """Return the text of the spec."""
    assert case.log is not None
    log = {
        key: value
        for key, value in dataclasses.asdict(case.log).items()
        if value != getattr(LogConfig(), key)
    }
    for key in ("file", "mapping"):
        if key in log:
            log[key] = os.path.relpath(str(log[key]), path.parent)
    head = {"title": f"{case.name}, pinned", "vehicle": vehicle_head(vehicle, path.parent)}
    lines = [_LOG_HEAD + yaml.safe_dump(head, sort_keys=False, allow_unicode=True).rstrip("\n")]
    flow = yaml.safe_dump(log, default_flow_style=True, sort_keys=False, width=1000).strip()
    lines += ["cases:", f"  - name: {case.name}", f"    log: {flow}"]
    lines += [f"    loop: {case.loop}"] if case.loop else []
    lines += ["    limits:"]
    lines += [f"      {name}: {limit_text(limit)}" for name, limit in limits.items()]
    return "\n".join(lines) + "\n"
