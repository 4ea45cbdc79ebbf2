"""Check that a scenario can be flown."""

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.parameter import is_servo_parameter
from workbench.common.yaml_files import Keys, YamlFile, dotted
from workbench.control.controller import COMMON_PARAMETERS, Controller
from workbench.control.installed_laws import installed_laws, is_shipped, known_laws
from workbench.control.schedule import split_label
from workbench.parameters.parameter_table import flight_table
from workbench.scenario.attitude_axes import find_attitude_axis
from workbench.scenario.flown_controller import flown_estimator, script_controllers
from workbench.scenario.scenario import Action, AttitudeSetpoint, Injection, Rates, Scenario
from workbench.scenario.sensors_config import check_sensors

REQUESTS = ("arm", "take_off", "hold", "land", "stop", "abort_landing")
START_MODES = ("off", "hovering")
MIN_PHYSICS_STEP_S = 1e-5
MAX_SCENARIO_PERIODS_S = {
    "physics_step": 0.01,
    "control_period": 0.05,
    "mode_period": 0.25,
    "record_period": 10.0,
}
"""Limits of the periods [s]."""
MAX_VECTOR_COMPONENT = 1e6
"""Largest component of a vector, in its unit."""
_DISTURBANCE_KEYS = (
    ("gust", "velocity", "gust"),
    ("gust", "duration", "gust_duration"),
    ("push", "force", "push"),
    ("push", "point", "push_at"),
    ("push", "torque", "push_torque"),
    ("push", "duration", "push_duration"),
)
"""A part of an action, its key, and the parameters that it sets."""
_MAX_TILT_RAD = next(row.maximum for row in COMMON_PARAMETERS if row.name == "max_tilt")
MAX_SETPOINTS = {"rad": _MAX_TILT_RAD, "rad/s": 35.0}
"""Largest setpoints of an attitude [rad], the largest `max_tilt`, and of a rate [rad/s]."""
MIN_INJECTION_RAD_S = 0.02
"""Lowest frequency of an injection [rad/s]; its period is five minutes."""
MAX_INJECTION_PERIODS = 100
"""Largest number of periods of an injection."""
MAX_PATH_DURATION_S = 3600.0
"""Longest duration of all laps of a figure of eight [s]."""


def check_scenario(
    scenario: Scenario, file: YamlFile | None = None, controller: Controller | None = None
) -> None:
    """Check that a scenario can be flown.

    Args:
        scenario: to check.
        file: that it was read from, for messages.
        controller: that of the scenario, with its estimator, if already read.

    Raises:
        WorkbenchError: with the key, and with file and line if there is a file.
    """

    def refuse(keys: Keys, reason: str) -> WorkbenchError:
        where = file.where(*keys) if file else ""
        return WorkbenchError(f"{where}{dotted(keys)} {reason}")

    if file:
        _check_takers_over(scenario, file)
    if not 0.0 < scenario.duration < math.inf:
        raise refuse(("duration",), "must be a positive time in seconds")
    if scenario.start.mode not in START_MODES:
        raise refuse(("start", "mode"), f"must be one of {', '.join(START_MODES)}")

    def stated(key: str) -> str:
        return file.where(key) if file and key in file.data else ""

    try:
        if controller is None:
            flown_estimator(scenario)
    except WorkbenchError as error:
        raise WorkbenchError(f"{stated('estimator')}{error}") from None
    try:
        laws = script_controllers(scenario, controller)
    except WorkbenchError as error:
        raise WorkbenchError(f"{stated('controller')}{error}") from None
    step = scenario.rates.physics_step
    if not step >= MIN_PHYSICS_STEP_S:
        raise refuse(("rates", "physics_step"), f"must be {MIN_PHYSICS_STEP_S:g} s or more")
    for rate in dataclasses.fields(Rates):
        if getattr(scenario.rates, rate.name) > MAX_SCENARIO_PERIODS_S[rate.name]:
            raise refuse(
                ("rates", rate.name), f"must be at most {MAX_SCENARIO_PERIODS_S[rate.name]:g} s"
            )
        steps = getattr(scenario.rates, rate.name) / step
        if steps < 1.0 or not float(steps).is_integer():
            raise refuse(("rates", rate.name), f"must be a multiple of the physics step {step:g} s")
    check_sensors(scenario.sensors, refuse)
    scenario.vehicle.variation.check(file.where("vehicle", "variation") if file else "")
    for index, action in enumerate(scenario.script):
        keys: Keys = ("script", index)
        if action.request is not None and action.request not in REQUESTS:
            raise refuse((*keys, "request"), f"must be one of {', '.join(REQUESTS)}")
        if file and action.at > scenario.duration:
            raise refuse(
                (*keys, "at"), f"is after the flight's {scenario.duration:g} s: raise duration"
            )
        if action.end_script:
            raise refuse(
                (*keys, "end_script"),
                "is an order of somebody who flies, not of a script: remove it",
            )
        if not 0.0 <= action.at < math.inf:
            raise refuse((*keys, "at"), "must be a time in seconds, 0 or later")
        if action.yaw_rate is not None and not math.isfinite(action.yaw_rate):
            raise refuse((*keys, "yaw_rate"), "must be a finite number of rad/s")
        if not 0.0 < action.height < math.inf:
            raise refuse((*keys, "height"), "must be a height above the ground in m")
        for key, blow in (("gust", action.gust), ("push", action.push)):
            if blow is not None and not 0.0 < blow.duration < math.inf:
                raise refuse((*keys, key, "duration"), "must be a positive time in seconds")
        if action.injection is not None:
            try:
                check_injection(action.injection, laws[index], scenario.rates)
            except WorkbenchError as error:
                raise refuse((*keys, "injection"), str(error)) from None
        if action.setpoint is not None:
            _check_setpoint(action.setpoint, laws[index], (*keys, "setpoint"), refuse)
        for name, value in action.set.items():
            where = file.where(*keys, "set", name) if file else ""
            if not is_servo_parameter(name):  # those depend on the vehicle, see `make_setup`
                laws[index].table.checked({name: value}, where)
    for keys, vector in _vectors(scenario):
        if len(vector) != 3 or not all(abs(number) <= MAX_VECTOR_COMPONENT for number in vector):
            raise refuse(
                keys, f"must be three finite numbers within ±{MAX_VECTOR_COMPONENT:g}, is {vector}"
            )
    for index, action in enumerate(scenario.script):
        _check_disturbances(action, ("script", index), file)
    if scenario.start.position is not None and scenario.start.position[2] < 0.0:
        raise refuse(("start", "position"), "is below the ground: its third number is the height")
    eight = scenario.figure_eight
    if eight is not None:
        if any(action.go_to is not None for action in scenario.script):
            raise refuse(("figure_eight",), "cannot be flown together with a go_to: leave one out")
        for size in ("length", "width", "period"):
            if not 0.0 < getattr(eight, size) < math.inf:
                raise refuse(("figure_eight", size), "must be a positive number")
        if eight.period < 0.5 or eight.laps * eight.period > MAX_PATH_DURATION_S:
            raise refuse(
                ("figure_eight", "period"),
                f"must be 0.5 s or more, all laps {MAX_PATH_DURATION_S:g} s at most",
            )
        if eight.laps < 1:
            raise refuse(("figure_eight", "laps"), "must be 1 or more")


def _check_setpoint(
    setpoint: AttitudeSetpoint,
    law: Controller,
    keys: Keys,
    refuse: Callable[[Keys, str], WorkbenchError],
) -> None:
    """Check that a law has setpoints, and that they are numbers."""
    for name, value in setpoint.given.items():
        row = find_attitude_axis(name)
        if not abs(value) <= MAX_SETPOINTS[row.unit]:
            raise refuse(
                (*keys, name), f"must be within ±{MAX_SETPOINTS[row.unit]:g} {row.unit}, is {value}"
            )
        try:
            row.check(law)
        except WorkbenchError as error:
            raise refuse((*keys, name), f"cannot be given: {error}") from None


def check_injection(injection: Injection, law: Controller, rates: Rates) -> None:
    """Check that an injection can be flown; one without a point ends another.

    Raises:
        WorkbenchError: that says what to give instead.
    """
    if not injection.point:
        return
    if injection.point not in law.points:
        raise unknown_name("loop point", injection.point, law.points)
    highest = math.pi / (law.point_dividers[injection.point] * rates.control_period)
    if not 0.0 < injection.size <= MAX_VECTOR_COMPONENT:
        raise WorkbenchError(
            f"the size injected is {injection.size:g}: give it a finite number above 0"
        )
    if not MIN_INJECTION_RAD_S <= injection.lowest < injection.highest <= highest:
        raise WorkbenchError(
            f"the injection reaches from {injection.lowest:g} to {injection.highest:g} rad/s: give "
            f"it a lowest frequency of {MIN_INJECTION_RAD_S:g} rad/s or more, and a highest one "
            "above it, "
            f"up to {highest:.4g} rad/s, half the rate of the law, or of its part that runs there"
        )
    if not 2 < injection.periods <= MAX_INJECTION_PERIODS:
        raise WorkbenchError(
            f"the injection has {injection.periods} periods: give it 3 to "
            f"{MAX_INJECTION_PERIODS}, as the "
            "first one is not measured"
        )


def _check_takers_over(scenario: Scenario, file: YamlFile) -> None:
    """Reject Python files that only a script names; the scenario's own was checked before."""
    for index, action in enumerate(scenario.script):
        named = action.controller
        if named is None or named == scenario.controller or is_shipped(named):
            continue
        law, where = split_label(named)[0], file.where("script", index, "controller")
        if "." not in law:  # neither a file nor a module
            raise WorkbenchError(f"{where}{unknown_name('controller', law, known_laws())}")
        if (file.path.parent / named).resolve() != Path(scenario.controller).resolve():
            raise WorkbenchError(
                f"{where}{named} is Python code that would run here: a script may name the "
                f"flight's own controller, and {', '.join(installed_laws())}"
            )
        scenario.script[index] = dataclasses.replace(action, controller=scenario.controller)


def _check_disturbances(action: Action, keys: Keys, file: YamlFile | None) -> None:
    """Check gusts and pushes against the limits of their parameters."""
    for blow, key, row in _DISTURBANCE_KEYS:
        config = getattr(action, blow)
        if config is not None:
            value = getattr(config, key)
            if key == "duration":
                values = {row: value}
            else:
                values = {f"{row}_{axis}": part for axis, part in zip("xyz", value, strict=True)}
            name = (*keys, blow, key)
            flight_table().checked(values, file.where(*name) if file else f"{dotted(name)}: ")


def _vectors(scenario: Scenario) -> list[tuple[Keys, list[float]]]:
    """Return every vector of a scenario with its keys."""
    start = scenario.start
    found: list[tuple[Keys, list[float] | None]] = [
        (("start", "position"), start.position),
        (("start", "roll_pitch_yaw"), start.roll_pitch_yaw),
        (("start", "velocity"), start.velocity),
        (("start", "angular_velocity"), start.angular_velocity),
    ]
    for index, action in enumerate(scenario.script):
        found.append((("script", index, "velocity"), action.velocity))
        found.append((("script", index, "go_to"), action.go_to))
        if action.gust is not None:
            found.append((("script", index, "gust", "velocity"), action.gust.velocity))
        if action.push is not None:
            found.append((("script", index, "push", "force"), action.push.force))
            found.append((("script", index, "push", "point"), action.push.point))
            found.append((("script", index, "push", "torque"), action.push.torque))
    if scenario.figure_eight:
        found.append((("figure_eight", "center"), scenario.figure_eight.center))
    return [(keys, vector) for keys, vector in found if vector is not None]
