"""Read and check a spec."""

import copy
import dataclasses
import math
import re
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import (
    Keys,
    YamlFile,
    as_record,
    check_schema,
    read_yaml,
    with_numbers,
)
from workbench.control.controller import DEFAULT, load_controller
from workbench.design.regress.measures import HOVER, Need, find_measure
from workbench.design.regress.signals import AXIS_SIGNALS, POINT, find_signal
from workbench.design.regress.spec import (
    MISSING,
    SKIP,
    Case,
    Limit,
    LogConfig,
    Spec,
    SpecFile,
    Tolerance,
)
from workbench.design.regress.spec_names import MARGINS, slug
from workbench.design.response_metrics import LOAD_NUMBERS
from workbench.design.step_response import DURATIONS, LEAST_DURATION, MOST_DURATION
from workbench.estimation.settings import ESTIMATORS
from workbench.scenario.axes import AXES
from workbench.scenario.loads import LOADS
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import (
    Scenario,
    Start,
    check_scenario,
    chosen_controller,
    find_files,
    find_scenario_world,
)


def load_spec(path: Path | str, controller: str = "", trusted: Path | str | None = None) -> Spec:
    """Read and check a spec; files named in it are first searched next to it.

    Args:
        path: the file.
        controller: replaces the one that the spec names: the name of a shipped one, or the path of
            a file. A Python file that only the spec names is not executed.
        trusted: a folder of Python files that may be executed; None for none.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    path = Path(path)
    trusted = None if trusted is None else Path(trusted)
    file = with_numbers(_with_plain_limits(read_yaml(path)), SpecFile)
    check_schema(file, SpecFile)
    content: SpecFile = as_record(file.data, SpecFile)
    content.controller = chosen_controller(file, content.controller, controller, trusted)
    if content.estimator not in ESTIMATORS:
        unknown = unknown_name("estimator", content.estimator, ESTIMATORS)
        raise WorkbenchError(f"{file.where('estimator')}{unknown}")
    common = Scenario(
        vehicle=content.vehicle,
        controller=content.controller,
        estimator=content.estimator,
        world=content.world,
        sensors=content.sensors,
        rates=content.rates,
    )
    check_scenario(common, file)
    find_files(common.vehicle, file)
    find_scenario_world(common, file)
    content.world = common.world
    if not content.cases and not content.margins:
        raise WorkbenchError(f"{file.where()}a spec has cases, or margins")
    names = {MARGINS}
    for index, case in enumerate(content.cases):
        _find_log(case, index, file)
        _check_case(case, index, file, content.controller)
        if slug(case.name) in names:
            where = file.where("cases", index, "name")
            raise WorkbenchError(f"{where}there is '{case.name}' already: take another name")
        names.add(slug(case.name))
    if content.margins:
        _check_margins(content, file)
    return Spec(path.resolve(), content)


def check_named(path: Path, controller: str) -> None:
    """Check that a controller is the one that a spec names; "" is none.

    Raises:
        WorkbenchError: if a baseline would be for another one.
    """
    file = read_yaml(path)
    named = str(file.data.get("controller") or DEFAULT)
    same = (path.parent / named).resolve() == Path(controller).resolve()
    if controller not in ("", named) and not same:
        raise WorkbenchError(
            f"{file.where('controller')}a baseline belongs to the spec as it is written, whose "
            f"controller is {named}: leave out --update, or write controller: {controller} into "
            "the spec"
        )


def _find_log(case: Case, index: int, file: YamlFile) -> None:
    """Resolve the log and mapping of a case relative to the spec, and reject missing files.

    A log that may be missing is searched when the case is judged.
    """
    if case.log is None:
        return
    for key in ("file", "mapping"):
        name = getattr(case.log, key)
        if name:
            place = (file.path.parent / Path(name).expanduser()).resolve()
            setattr(case.log, key, str(place))
            if not place.is_file() and case.log.missing != SKIP:
                where = file.where("cases", index, "log", key)
                raise WorkbenchError(
                    f"{where}there is no {name} beside the spec: name a log, or write "
                    f"missing: {SKIP} to leave the case out where it is not there"
                )


def _with_plain_limits(file: YamlFile) -> YamlFile:
    """Return a file with the short forms of limits [least, most] and logs FILE expanded."""
    data = copy.deepcopy(file.data)
    cases, margins = data.get("cases"), data.get("margins")
    for case in cases if isinstance(cases, list) else []:
        _spell_out(case.get("limits") if isinstance(case, dict) else None)
        if isinstance(case, dict) and isinstance(case.get("log"), str):
            case["log"] = {"file": case["log"]}
    for limits in margins.values() if isinstance(margins, dict) else []:
        _spell_out(limits)
    return dataclasses.replace(file, data=data)


def _spell_out(limits: Any) -> None:
    """Make {min: a, max: b} of each [a, b] of a mapping."""
    for name, limit in limits.items() if isinstance(limits, dict) else []:
        if isinstance(limit, list) and len(limit) == 2:
            limits[name] = {"min": limit[0], "max": limit[1]}


FLOWN = (
    "axis",
    "load",
    "acts",
    "amplitude",
    "duration",
    "start",
    "script",
    "edge",
    "command",
    "set",
)
"""Keys of a flight that do not apply to a log."""
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.+-]*")


def _check_case(case: Case, index: int, file: YamlFile, controller: str) -> None:
    """Check a case in the list of a spec.

    Raises:
        WorkbenchError: naming file and line of the first thing that is wrong.
    """
    keys: Keys = ("cases", index)
    if not _NAME.fullmatch(case.name):
        raise _refuse(file, (*keys, "name"), f"is '{case.name}': use letters, digits and _ . + -")
    if not LEAST_DURATION <= case.duration <= MOST_DURATION:
        raise _refuse(file, (*keys, "duration"), f"must be {DURATIONS}")
    if case.acts is not None and not case.load:
        raise _refuse(file, (*keys, "acts"), "belongs to a load")
    if case.log is not None:
        _check_log(case, case.log, file, keys)
    elif case.loop:
        raise _refuse(file, (*keys, "loop"), "belongs to a log: a flight has an axis or a signal")
    elif case.axis or case.load:
        _check_step(case, file, keys)
    else:
        _check_script(case, file, keys, controller)
    for name, value in case.set.items():
        parameter_table(load_controller(controller)).checked(
            {name: value}, file.where(*keys, "set", name)
        )
    if not case.limits and not case.baseline:
        where = file.where(*keys)
        raise WorkbenchError(f"{where}'{case.name}' checks nothing: give it limits or a baseline")
    for name, limit in case.limits.items():
        _check_metric(case, file, (*keys, "limits", name), name)
        _check_limit(limit, file, (*keys, "limits", name))
    for name, tolerance in case.baseline.items():
        _check_signal(name, file, (*keys, "baseline", name))
        _check_tolerance(tolerance, file, (*keys, "baseline", name))


def _check_limit(limit: Limit, file: YamlFile, keys: Keys) -> None:
    """Refuse a limit that nothing, or everything, meets.

    Raises:
        WorkbenchError: naming file and line.
    """
    if not limit.min <= limit.max or (limit.min, limit.max) == (-math.inf, math.inf):
        raise _refuse(file, keys, "must have a min, a max no smaller, or both, as [0.3, 0.4]")


def _check_step(case: Case, file: YamlFile, keys: Keys) -> None:
    """Refuse a case with an axis or a load if it is not a step."""
    if case.axis and case.load:
        raise _refuse(file, (*keys, "load"), "and an axis are two steps: make two cases")
    if case.axis and case.axis not in AXES:
        raise WorkbenchError(f"{file.where(*keys, 'axis')}{unknown_name('axis', case.axis, AXES)}")
    if case.load and case.load not in LOADS:
        raise WorkbenchError(f"{file.where(*keys, 'load')}{unknown_name('load', case.load, LOADS)}")
    if case.acts is not None and not 0.0 < case.acts <= case.duration:
        raise _refuse(file, (*keys, "acts"), "must be a time in seconds within the duration")
    if case.amplitude is None or not 0.0 < abs(case.amplitude) < math.inf:
        raise _refuse(file, (*keys, "amplitude"), "must be a finite number, and not 0")
    for key, given in (
        ("script", bool(case.script)),
        ("start", case.start is not None),
        ("edge", case.edge != 0.0),
        ("command", case.command is not None),
        ("signal", case.signal not in ("", AXIS_SIGNALS[case.axis or case.load])),
    ):
        if given:
            raise _refuse(
                file,
                (*keys, key),
                "belongs to a script: a step has an axis or a load, and an amplitude",
            )


def _check_log(case: Case, log: LogConfig, file: YamlFile, keys: Keys) -> None:
    """Refuse a case with a log that is also flown, or whose log cannot be judged."""
    usual = Case()
    for key in FLOWN:
        if getattr(case, key) != getattr(usual, key):
            raise _refuse(file, (*keys, key), "belongs to a flight: a log has a span and a loop")
    if not log.file:
        raise _refuse(file, (*keys, "log"), "must name a file")
    if log.missing not in MISSING:
        raise _refuse(file, (*keys, "log", "missing"), f"must be {' or '.join(MISSING)}")
    if log.number < 0:
        raise _refuse(file, (*keys, "log", "number"), "must be 1 or more, or 0 for the longest log")
    span = log.span
    if span and not (len(span) == 2 and 0.0 <= span[0] < span[1] < math.inf):
        raise _refuse(file, (*keys, "log", "span"), "must be two times in seconds, as [12, 40]")
    if sorted(log.order) != list(range(1, len(log.order) + 1)):
        order = "must have the number of each motor once, as [2, 1, 4, 3]"
        raise _refuse(file, (*keys, "log", "order"), order)
    if case.signal:
        _check_signal(case.signal, file, (*keys, "signal"))


def _check_script(case: Case, file: YamlFile, keys: Keys, controller: str) -> None:
    """Refuse a case without an axis and a load if it is not a flight."""
    if not case.script and case.start is None:
        where = file.where(*keys)
        raise WorkbenchError(f"{where}'{case.name}' has neither an axis nor a script")
    if case.amplitude is not None:
        raise _refuse(file, (*keys, "amplitude"), "belongs to an axis: a script has a command")
    if not 0.0 <= case.edge <= MOST_DURATION:
        at = f"0 or later, and {MOST_DURATION:g} s at most"
        raise _refuse(file, (*keys, "edge"), f"must be a time in seconds, {at}")
    if case.command is not None and not 0.0 < abs(case.command) < math.inf:
        raise _refuse(file, (*keys, "command"), "must be a finite number, and not 0")
    if case.signal:
        _check_signal(case.signal, file, (*keys, "signal"))
    flight = Scenario(
        controller=controller,
        start=case.start or Start(),
        script=case.script,
        duration=case.edge + case.duration,
    )
    depth = len(keys)
    lines = {at[depth:]: line for at, line in file.lines.items() if at[:depth] == keys}
    check_scenario(flight, dataclasses.replace(file, lines=lines))


def _check_metric(case: Case, file: YamlFile, keys: Keys, name: str) -> None:
    """Check that a metric is known, and that a case has its inputs."""
    try:
        measure = find_measure(name)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where(*keys)}{error}") from None
    if measure.signal:
        _check_signal(measure.signal, file, keys)
    step = bool(case.axis or case.load or case.loop)
    commanded = case.axis or case.loop or (case.signal and case.command)
    missing = {
        Need.SIGNAL: not (step or case.signal),
        Need.COMMAND: not (commanded or (case.load and name in LOAD_NUMBERS)),
        Need.AXIS: not case.axis,
        Need.LOOP: not (case.axis or case.loop),
        Need.LOG: not case.loop,
        Need.HOVER: not (step or case.log) and case.edge < HOVER,
    }
    if missing.get(measure.need):
        raise _refuse(file, keys, f"needs {measure.need.value}, which '{case.name}' does not have")


def _check_signal(name: str, file: YamlFile, keys: Keys) -> None:
    """Check that a signal is known; those of a sensor are checked in flight."""
    if POINT in name:
        return
    try:
        find_signal(name)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where(*keys)}{error}") from None


def _check_tolerance(tolerance: Tolerance, file: YamlFile, keys: Keys) -> None:
    for field in dataclasses.fields(Tolerance):
        if not 0.0 <= getattr(tolerance, field.name) < math.inf:
            raise _refuse(file, (*keys, field.name), "must be 0 or more")
    if tolerance.absolute == tolerance.relative == 0.0:
        raise _refuse(file, keys, "must have an absolute or a relative tolerance")


def _refuse(file: YamlFile, keys: Keys, reason: str) -> WorkbenchError:
    """Return the error for a key, with its name at the begin of the sentence."""
    return WorkbenchError(f"{file.where(*keys)}{keys[-1]} {reason}")


def _check_margins(content: SpecFile, file: YamlFile) -> None:
    """Check that margins exist.

    Raises:
        WorkbenchError: naming file and line of the first thing that is wrong.
    """
    # slow to load, and most specs have no margins
    from workbench.design.judge.margins import LoopMargins
    from workbench.design.linear.operating_point import OperatingPoint, parse_point

    names = [each.name for each in dataclasses.fields(LoopMargins) if each.name != "stable"]
    law = load_controller(content.controller)
    try:
        point = parse_point(content.at)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where('at')}{error}") from None
    for loop, limits in content.margins.items():
        try:
            only_in_hover = law.loop(loop).hold
        except WorkbenchError as error:
            raise WorkbenchError(f"{file.where('margins', loop)}{error}") from None
        if only_in_hover and dataclasses.replace(point, hold=False) != OperatingPoint():
            raise WorkbenchError(
                f"{file.where('margins', loop)}{loop} is closed in hover only, and at is "
                f"'{content.at}': leave one out"
            )
        for name, limit in limits.items():
            where = file.where("margins", loop, name)
            if name not in names:
                raise WorkbenchError(f"{where}{unknown_name('margin', name, names)}")
            _check_limit(limit, file, ("margins", loop, name))
