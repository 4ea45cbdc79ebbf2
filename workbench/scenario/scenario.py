"""The scenario of a flight, as typed dataclasses that define the YAML schema."""

import dataclasses
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_files import write_atomically
from workbench.common.resources import find_file, find_model, find_world
from workbench.common.yaml_files import (
    Keys,
    YamlFile,
    as_record,
    check_schema,
    dotted,
    dump_changes,
    read_yaml,
    with_numbers,
)
from workbench.control.controller import (
    DEFAULT,
    SHIPPED,
    Controller,
    is_shipped,
    load_controller,
    with_estimator,
)
from workbench.estimation.settings import ESTIMATORS, TRUTH
from workbench.plant.variation import Variation
from workbench.scenario.parameters import ParameterTable, parameter_table

if TYPE_CHECKING:
    from workbench.estimation.estimators import Estimator
from workbench.scenario.sensors_config import SensorsConfig, check_sensors

CONTROL_PERIOD = 1 / 128
"""Default period of control updates [s]."""
REQUESTS = ("arm", "take_off", "hold", "land", "stop", "abort_landing")
START_MODES = ("off", "hovering")
FINEST_STEP = 1e-5
SLOWEST = {
    "physics_step": 0.01,
    "control_period": 0.05,
    "mode_period": 0.25,
    "record_period": 10.0,
}
"""Limits of the periods [s]."""
FARTHEST = 1e6
"""Largest component of a vector, in its unit."""
_BLOWS = (
    ("gust", "velocity", "gust"),
    ("gust", "duration", "gust_duration"),
    ("push", "force", "push"),
    ("push", "point", "push_at"),
    ("push", "torque", "push_torque"),
    ("push", "duration", "push_duration"),
)
"""A part of an action, its key, and the parameters that it sets."""
STEERED = 1e-5
"""Velocity from which on a position is no longer held [m/s]."""
SLOWEST_LINE = 0.02
"""Lowest frequency of an injection [rad/s]; its period is five minutes."""
MOST_PERIODS = 100
"""Largest number of periods of an injection."""
LONGEST_PATH = 3600.0
"""Longest duration of all laps of a figure of eight [s]."""


@dataclass
class VehicleConfig:
    """The vehicle and its gains.

    The name of a shipped model or the path of a description; arguments for its xacro file; folders
    of packages and models that it refers to, by name; the path of a sidecar, for a description
    without rotors; the path of a gain file; and the variation of the flying vehicle from all that.
    """

    model: str = "dh_drone"
    args: dict[str, str] = field(default_factory=dict)
    packages: dict[str, str] = field(default_factory=dict)
    rotors: str = ""
    gains: str = ""
    variation: Variation = field(default_factory=Variation)


@dataclass
class Rates:
    """Periods [s]; each is a multiple of the physics step, and exact in binary."""

    physics_step: float = 1 / 1024
    control_period: float = CONTROL_PERIOD
    mode_period: float = 1 / 8
    record_period: float = 1 / 128

    @property
    def control_steps(self) -> int:
        """Physics steps in a control period."""
        return round(self.control_period / self.physics_step)


@dataclass
class Start:
    """The start of a flight: off on the ground, or in the air with rotors at hover speed.

    Position of the base link [m] (by default on the ground, or in hover 1.5 m above it), roll,
    pitch, yaw [rad], velocity [m/s] and angular velocity [rad/s], both in W.
    """

    mode: str = "hovering"
    position: list[float] | None = None
    roll_pitch_yaw: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    angular_velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass
class Gust:
    """A gust that rises to a velocity in W [m/s] and falls again, within a duration [s]."""

    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    duration: float = 1.0


@dataclass
class Push:
    """A force in W [N] at a point of the body in B [m], and a torque in B [N·m], for a time [s]."""

    force: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    point: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    duration: float = 0.1
    torque: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass
class Injection:
    """A multisine added to a signal of the law, to measure the response of a loop.

    The name of the loop point ("" ends an injection), the rms amplitude in its unit, the lowest and
    the highest frequency [rad/s], and the number of periods, each of one wave of the lowest
    frequency.
    """

    point: str = ""
    size: float = 0.0
    lowest: float = 0.5
    highest: float = 50.0
    periods: int = 5

    def action(self, *, hold: bool) -> "Action":
        """Return the action that measures a loop in hover.

        Args:
            hold: whether the loop is one that holds a position. For all others the velocity is
                commanded, too small to matter, as in the models used to judge them.
        """
        return Action(velocity=[0.0 if hold else STEERED, 0.0, 0.0], yaw_rate=0.0, injection=self)


@dataclass
class Action:
    """An action of the pilot at a time [s]; whatever is not given stays the same.

    A velocity in W [m/s], a yaw rate [rad/s], a point to go to [m], a request (arm, take_off, hold,
    land, stop, abort_landing) with its height [m], a gust, a push, an injection into the law, new
    values of live parameters, or a controller to take over (the name of a shipped one, or a file).
    `interpreted` has no effect: files of earlier versions have it.
    """

    at: float = 0.0
    velocity: list[float] | None = None
    yaw_rate: float | None = None
    go_to: list[float] | None = None
    request: str | None = None
    height: float = 1.5
    gust: Gust | None = None
    push: Push | None = None
    injection: Injection | None = None
    set: dict[str, float] = field(default_factory=dict)
    controller: str | None = None
    interpreted: bool = False

    @property
    def flies(self) -> bool:
        """Whether it sends the drone somewhere or changes its flight mode."""
        wishes = (self.velocity, self.yaw_rate, self.go_to, self.request)
        return any(wish is not None for wish in wishes)


@dataclass
class FigureEight:
    """A path in a figure of eight: its centre [m], size [m], time per lap [s] and number of laps.

    Without `feedforward` the law does not get the acceleration along it.
    """

    center: list[float] = field(default_factory=lambda: [0.0, 0.0, 1.5])
    length: float = 4.0
    width: float = 2.0
    period: float = 10.0
    laps: int = 2
    feedforward: bool = True


@dataclass
class Scenario:
    """All settings of a flight; equal scenarios yield flights equal to the bit.

    The controller is the name of a shipped one, or the path of a Python file, which is executed.
    The estimator provides the motion to the controller: one of `ESTIMATORS`, or such a file.
    """

    title: str = ""
    vehicle: VehicleConfig = field(default_factory=VehicleConfig)
    controller: str = DEFAULT
    estimator: str = TRUTH
    world: str = "empty"
    sensors: SensorsConfig = field(default_factory=SensorsConfig)
    rates: Rates = field(default_factory=Rates)
    start: Start = field(default_factory=Start)
    duration: float = 10.0
    script: list[Action] = field(default_factory=list)
    figure_eight: FigureEight | None = None


def load_scenario(path: Path | str, controller: str = "", estimator: str = "") -> Scenario:
    """Read and check a scenario file.

    Args:
        path: the file.
        controller: replaces the one that the file names: the name of a shipped one, or the path of
            a file. A Python file that only the scenario names is not executed.
        estimator: the same for the estimator.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    path = Path(path)
    file = read_yaml(path)
    check_schema(file, Scenario)
    scenario: Scenario = as_record(with_numbers(file, Scenario).data, Scenario)
    scenario.controller = chosen_controller(file, scenario.controller, controller)
    scenario.estimator = _chosen(
        file, "estimator", scenario.estimator, estimator, scenario.estimator in ESTIMATORS
    )
    check_scenario(scenario, file)
    find_files(scenario.vehicle, file)
    find_scenario_world(scenario, file)
    return scenario


def chosen_controller(file: YamlFile, named: str, given: str, trusted: Path | None = None) -> str:
    """Return the controller that flies.

    Args:
        file: the one that names it.
        named: name in the file.
        given: name from the caller, "" for none.
        trusted: a folder of files that may be executed if the file names them; None for none.

    Raises:
        WorkbenchError: if only the file names a controller that is not shipped: reading a scenario
            would execute its code.
    """
    return _chosen(file, "controller", named, given, is_shipped(named), trusted)


def _chosen(
    file: YamlFile, key: str, named: str, given: str, shipped: bool, trusted: Path | None = None
) -> str:
    """Return the controller or the estimator that flies.

    Args:
        file: the one that names it.
        key: of the name in the file, and name of the option.
        named: name in the file.
        given: name from the caller, "" for none.
        shipped: whether the one in the file is a shipped one.
        trusted: see `chosen_controller`.

    Raises:
        WorkbenchError: see `chosen_controller`.
    """
    if given or shipped:
        return given or named
    if "." not in named:
        return named  # not Python: the search for it lists the known names
    beside = file.path.parent / named
    path = beside if beside.is_file() else named
    if trusted and beside.resolve().is_relative_to(trusted.resolve()):
        return str(beside)
    raise WorkbenchError(
        f"{file.where(key)}{named} is Python code that would run here: if you trust it, name it "
        f"yourself, as --{key} {path}"
    )


def save_scenario(scenario: Scenario, path: Path) -> None:
    """Write the differences from the default scenario to a YAML file.

    Raises:
        WorkbenchError: if it cannot be written; an existing file then stays unchanged.
    """
    write_atomically(path, dump_changes(scenario))


def without_arrays(scenario: Scenario) -> Scenario:
    """Return a scenario with almost no recording, so that days of flight fit into memory."""
    step = scenario.rates.physics_step
    sparse = step * math.floor(SLOWEST["record_period"] / step)
    return dataclasses.replace(
        scenario,
        rates=dataclasses.replace(scenario.rates, record_period=sparse),
        sensors=dataclasses.replace(scenario.sensors, keep=False),
    )


def check_scenario(scenario: Scenario, file: YamlFile | None = None) -> None:
    """Check that a scenario can be flown.

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
        flown_estimator(scenario)
    except WorkbenchError as error:
        raise WorkbenchError(f"{stated('estimator')}{error}") from None
    try:
        tables = flown_tables(scenario)
    except WorkbenchError as error:
        raise WorkbenchError(f"{stated('controller')}{error}") from None
    step = scenario.rates.physics_step
    if not step >= FINEST_STEP:
        raise refuse(("rates", "physics_step"), f"must be {FINEST_STEP:g} s or more")
    for rate in dataclasses.fields(Rates):
        if getattr(scenario.rates, rate.name) > SLOWEST[rate.name]:
            raise refuse(("rates", rate.name), f"must be at most {SLOWEST[rate.name]:g} s")
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
                (*keys, "at"), f"is after the flight's {scenario.duration:g} s: fly longer"
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
                check_injection(action.injection, tables[index].controller, scenario.rates)
            except WorkbenchError as error:
                raise refuse((*keys, "injection"), str(error)) from None
        for name, value in action.set.items():
            where = file.where(*keys, "set", name) if file else ""
            tables[index].checked({name: value}, where)
    for keys, vector in _vectors(scenario):
        if len(vector) != 3 or not all(abs(number) <= FARTHEST for number in vector):
            raise refuse(keys, f"must be three finite numbers within ±{FARTHEST:g}, is {vector}")
    for index, action in enumerate(scenario.script):
        _check_blows(action, ("script", index), file)
    if scenario.start.position is not None and scenario.start.position[2] < 0.0:
        raise refuse(("start", "position"), "is below the ground: its third number is the height")
    eight = scenario.figure_eight
    if eight is not None:
        if any(action.go_to is not None for action in scenario.script):
            raise refuse(("figure_eight",), "cannot be flown together with a go_to: leave one out")
        for size in ("length", "width", "period"):
            if not 0.0 < getattr(eight, size) < math.inf:
                raise refuse(("figure_eight", size), "must be a positive number")
        if eight.period < 0.5 or eight.laps * eight.period > LONGEST_PATH:
            raise refuse(
                ("figure_eight", "period"),
                f"must be 0.5 s or more, all laps {LONGEST_PATH:g} s at most",
            )
        if eight.laps < 1:
            raise refuse(("figure_eight", "laps"), "must be 1 or more")


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
    if not 0.0 < injection.size <= FARTHEST:
        raise WorkbenchError(
            f"the size injected is {injection.size:g}: give it a finite number above 0"
        )
    if not SLOWEST_LINE <= injection.lowest < injection.highest <= highest:
        raise WorkbenchError(
            f"the injection reaches from {injection.lowest:g} to {injection.highest:g} rad/s: give "
            f"it a lowest frequency of {SLOWEST_LINE:g} rad/s or more, and a highest one above it, "
            f"up to {highest:.4g} rad/s, half the rate of the law, or of its part that runs there"
        )
    if not 2 < injection.periods <= MOST_PERIODS:
        raise WorkbenchError(
            f"the injection has {injection.periods} periods: give it 3 to {MOST_PERIODS}, as the "
            "first one is not measured"
        )


def _check_takers_over(scenario: Scenario, file: YamlFile) -> None:
    """Reject Python files that only a script names; the scenario's own was checked before."""
    for index, action in enumerate(scenario.script):
        named = action.controller
        if named is None or named == scenario.controller or is_shipped(named):
            continue
        if (file.path.parent / named).resolve() != Path(scenario.controller).resolve():
            raise WorkbenchError(
                f"{file.where('script', index, 'controller')}{named} is Python code that would run "
                f"here: a script may name the flight's own controller, and {', '.join(SHIPPED)}"
            )
        action.controller = scenario.controller


def flown_estimator(scenario: Scenario) -> "Estimator | None":
    """Return the user's own estimator in a scenario, None for a shipped one.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    if scenario.estimator in ESTIMATORS:
        return None
    from workbench.estimation.estimators import find_estimator  # most flights do not need it

    return find_estimator(scenario.estimator)


def flown_controller(scenario: Scenario, controller: str = "") -> Controller:
    """Return the controller of a scenario, with the user's own estimator if any.

    Args:
        scenario: the one flown.
        controller: replaces that of the scenario.

    Raises:
        WorkbenchError: if one of them cannot be read.
    """
    law = load_controller(controller or scenario.controller)
    return with_estimator(law, flown_estimator(scenario))


def at_own_period(scenario: Scenario) -> Scenario:
    """Return a scenario with the control period of its controller.

    This only replaces the default: a scenario that states another period keeps it.

    Raises:
        WorkbenchError: if the controller cannot be read, or its period is not a multiple of the
            physics step.
    """
    period = load_controller(scenario.controller).period
    if period is None or scenario.rates.control_period != CONTROL_PERIOD:
        return scenario
    step = scenario.rates.physics_step
    if not (period / step).is_integer():
        raise WorkbenchError(
            f"the controller {scenario.controller} is made for updates every {period:g} s, which "
            f"is not a multiple of the physics step {step:g} s: set physics_step to a part of it"
        )
    rates = dataclasses.replace(scenario.rates, control_period=period)
    return dataclasses.replace(scenario, rates=rates)


def flown_tables(scenario: Scenario) -> list[ParameterTable]:
    """Return the parameter table for each action of a script, which may change the controller.

    Raises:
        WorkbenchError: if a controller cannot be read.
    """
    table = parameter_table(flown_controller(scenario))
    found = [table] * len(scenario.script)
    for index in sorted(range(len(found)), key=lambda index: scenario.script[index].at):
        controller = scenario.script[index].controller
        if controller is not None:
            table = parameter_table(flown_controller(scenario, controller))
        found[index] = table
    return found


def _check_blows(action: Action, keys: Keys, file: YamlFile | None) -> None:
    """Check gusts and pushes against the limits of their parameters."""
    for blow, key, row in _BLOWS:
        config = getattr(action, blow)
        if config is not None:
            value = getattr(config, key)
            if key == "duration":
                values = {row: value}
            else:
                values = {f"{row}_{axis}": part for axis, part in zip("xyz", value, strict=True)}
            name = (*keys, blow, key)
            parameter_table().checked(values, file.where(*name) if file else f"{dotted(name)}: ")


def find_files(vehicle: VehicleConfig, file: YamlFile) -> None:
    """Resolve the files of a scenario relative to its own file, and reject missing ones."""
    for name, folder in vehicle.packages.items():
        vehicle.packages[name] = str((file.path.parent / folder).resolve())
    for key, find in (("model", find_model), ("rotors", find_file), ("gains", find_file)):
        name = getattr(vehicle, key)
        beside = file.path.parent / name
        try:
            if name and (beside.is_file() or (key == "model" and beside.is_dir())):
                setattr(vehicle, key, str(beside.resolve()))
            elif name:
                find(name)
        except (WorkbenchError, OSError) as error:
            raise WorkbenchError(f"{file.where('vehicle', key)}{error}") from None


def find_scenario_world(scenario: Scenario, file: YamlFile) -> None:
    """Resolve the world of a scenario relative to its file, and reject a missing one."""
    beside = file.path.parent / scenario.world
    try:
        if beside.is_file():
            scenario.world = str(beside.resolve())
        else:
            find_world(scenario.world)
    except (WorkbenchError, OSError) as error:
        raise WorkbenchError(f"{file.where('world')}{error}") from None


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
