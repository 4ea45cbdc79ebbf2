"""Check the cases of a specification."""

import dataclasses
import math
import re

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import Keys, YamlFile
from workbench.control.controller import Controller
from workbench.design.load_metrics import LOAD_NUMBERS
from workbench.design.regress.measures import HOVER_WINDOW_S, Need, find_measure
from workbench.design.regress.signals import AXIS_SIGNALS, SENSOR_SEPARATOR, find_signal
from workbench.design.regress.spec import MISSING_CHOICES, LogConfig, SpecCase, SpecLimit, Tolerance
from workbench.design.step_response import (
    MAX_STEP_DURATION_S,
    MIN_STEP_DURATION_S,
    STEP_DURATIONS_TEXT,
)
from workbench.scenario.axes import AXIS_NAMES
from workbench.scenario.loads import LOAD_NAMES
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.scenario.scenario_check import check_scenario

FLOWN_CASE_KEYS = (
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
_CASE_NAME_PATTERN = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.+-]*")


def check_case(
    case: SpecCase, index: int, file: YamlFile, controller: str, law: Controller
) -> None:
    """Check a case in the list of a spec, which names its controller.

    Raises:
        WorkbenchError: naming file and line of the first thing that is wrong.
    """
    keys: Keys = ("cases", index)
    if not _CASE_NAME_PATTERN.fullmatch(case.name):
        raise _spec_error(
            file, (*keys, "name"), f"is '{case.name}': use letters, digits and _ . + -"
        )
    if not MIN_STEP_DURATION_S <= case.duration <= MAX_STEP_DURATION_S:
        raise _spec_error(file, (*keys, "duration"), f"must be {STEP_DURATIONS_TEXT}")
    if case.acts is not None and not case.load:
        raise _spec_error(file, (*keys, "acts"), "belongs to a load")
    if case.log is not None:
        _check_log(case, case.log, file, keys)
    elif case.loop:
        raise _spec_error(
            file, (*keys, "loop"), "belongs to a log: a flight has an axis or a signal"
        )
    elif case.axis or case.load:
        _check_step(case, file, keys)
    else:
        _check_scripted_case(case, file, keys, controller, law)
    for name, value in case.set.items():
        law.table.checked({name: value}, file.where(*keys, "set", name))
    if not case.limits and not case.baseline:
        where = file.where(*keys)
        raise WorkbenchError(f"{where}'{case.name}' checks nothing: give it limits or a baseline")
    for name, limit in case.limits.items():
        _check_metric(case, file, (*keys, "limits", name), name)
        check_limit(limit, file, (*keys, "limits", name))
    for name, tolerance in case.baseline.items():
        _check_signal(name, file, (*keys, "baseline", name))
        _check_tolerance(tolerance, file, (*keys, "baseline", name))


def check_limit(limit: SpecLimit, file: YamlFile, keys: Keys) -> None:
    """Refuse a limit that nothing, or everything, meets.

    Raises:
        WorkbenchError: naming file and line.
    """
    if not limit.min <= limit.max or (limit.min, limit.max) == (-math.inf, math.inf):
        raise _spec_error(file, keys, "must have a min, a max no smaller, or both, as [0.3, 0.4]")


def _check_step(case: SpecCase, file: YamlFile, keys: Keys) -> None:
    """Refuse a case with an axis or a load if it is not a step."""
    if case.axis and case.load:
        raise _spec_error(file, (*keys, "load"), "and an axis are two steps: make two cases")
    if case.axis and case.axis not in AXIS_NAMES:
        raise WorkbenchError(
            f"{file.where(*keys, 'axis')}{unknown_name('axis', case.axis, AXIS_NAMES)}"
        )
    if case.load and case.load not in LOAD_NAMES:
        raise WorkbenchError(
            f"{file.where(*keys, 'load')}{unknown_name('load', case.load, LOAD_NAMES)}"
        )
    if case.acts is not None and not 0.0 < case.acts <= case.duration:
        raise _spec_error(file, (*keys, "acts"), "must be a time in seconds within the duration")
    if case.amplitude is None or not 0.0 < abs(case.amplitude) < math.inf:
        raise _spec_error(file, (*keys, "amplitude"), "must be a finite number, and not 0")
    for key, given in (
        ("script", bool(case.script)),
        ("start", case.start is not None),
        ("edge", case.edge != 0.0),
        ("command", case.command is not None),
        ("signal", case.signal not in ("", AXIS_SIGNALS[case.axis or case.load])),
    ):
        if given:
            raise _spec_error(
                file,
                (*keys, key),
                "belongs to a script: a step has an axis or a load, and an amplitude",
            )


def _check_log(case: SpecCase, log: LogConfig, file: YamlFile, keys: Keys) -> None:
    """Refuse a case with a log that is also flown, or whose log cannot be judged."""
    usual = SpecCase()
    for key in FLOWN_CASE_KEYS:
        if getattr(case, key) != getattr(usual, key):
            raise _spec_error(
                file, (*keys, key), "belongs to a flight: a log has a span and a loop"
            )
    if not log.file:
        raise _spec_error(file, (*keys, "log"), "must name a file")
    if log.missing not in MISSING_CHOICES:
        raise _spec_error(
            file, (*keys, "log", "missing"), f"must be {' or '.join(MISSING_CHOICES)}"
        )
    if log.number < 0:
        raise _spec_error(
            file, (*keys, "log", "number"), "must be 1 or more, or 0 for the longest log"
        )
    span = log.span
    if span and not (len(span) == 2 and 0.0 <= span[0] < span[1] < math.inf):
        raise _spec_error(file, (*keys, "log", "span"), "must be two times in seconds, as [12, 40]")
    if sorted(log.order) != list(range(1, len(log.order) + 1)):
        order = "must have the number of each motor once, as [2, 1, 4, 3]"
        raise _spec_error(file, (*keys, "log", "order"), order)
    if case.signal:
        _check_signal(case.signal, file, (*keys, "signal"))


def _check_scripted_case(
    case: SpecCase, file: YamlFile, keys: Keys, controller: str, law: Controller
) -> None:
    """Refuse a case without an axis and a load if it is not a flight."""
    if not case.script and case.start is None:
        where = file.where(*keys)
        raise WorkbenchError(f"{where}'{case.name}' has neither an axis nor a script")
    if case.amplitude is not None:
        raise _spec_error(file, (*keys, "amplitude"), "belongs to an axis: a script has a command")
    if not 0.0 <= case.edge <= MAX_STEP_DURATION_S:
        at = f"0 or later, and {MAX_STEP_DURATION_S:g} s at most"
        raise _spec_error(file, (*keys, "edge"), f"must be a time in seconds, {at}")
    if case.command is not None and not 0.0 < abs(case.command) < math.inf:
        raise _spec_error(file, (*keys, "command"), "must be a finite number, and not 0")
    if case.signal:
        _check_signal(case.signal, file, (*keys, "signal"))
    flight = Scenario(
        controller=controller,
        start=case.start or ScenarioStart(),
        script=case.script,
        duration=case.edge + case.duration,
    )
    depth = len(keys)
    lines = {at[depth:]: line for at, line in file.lines.items() if at[:depth] == keys}
    check_scenario(flight, dataclasses.replace(file, lines=lines), law)


def _check_metric(case: SpecCase, file: YamlFile, keys: Keys, name: str) -> None:
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
        Need.HOVER: not (step or case.log) and case.edge < HOVER_WINDOW_S,
    }
    if missing.get(measure.need):
        raise _spec_error(
            file, keys, f"needs {measure.need.value}, which '{case.name}' does not have"
        )


def _check_signal(name: str, file: YamlFile, keys: Keys) -> None:
    """Check that a signal is known; those of a sensor are checked in flight."""
    if SENSOR_SEPARATOR in name:
        return
    try:
        find_signal(name)
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where(*keys)}{error}") from None


def _check_tolerance(tolerance: Tolerance, file: YamlFile, keys: Keys) -> None:
    for field in dataclasses.fields(Tolerance):
        if not 0.0 <= getattr(tolerance, field.name) < math.inf:
            raise _spec_error(file, (*keys, field.name), "must be 0 or more")
    if tolerance.absolute == tolerance.relative == 0.0:
        raise _spec_error(file, keys, "must have an absolute or a relative tolerance")


def _spec_error(file: YamlFile, keys: Keys, reason: str) -> WorkbenchError:
    """Return the error for a key, with its name at the begin of the sentence."""
    return WorkbenchError(f"{file.where(*keys)}{keys[-1]} {reason}")
