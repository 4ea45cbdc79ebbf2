"""The scenario: what is built and flown, as typed dataclasses that are the YAML's schema."""

import dataclasses
import math
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from workbench.errors import WorkbenchError, unknown_name
from workbench.yaml_files import YamlFile, read_yaml

REQUESTS = ("arm", "take_off", "land", "stop")
START_MODES = ("off", "hovering")


@dataclass
class VehicleConfig:
    """Which drone: a shipped model's name or a path, xacro arguments, and a gain file's path."""

    model: str = "dh_drone"
    args: dict[str, str] = field(default_factory=dict)
    gains: str = ""


@dataclass
class Rates:
    """Periods [s]; each a multiple of the physics step, and exact in binary."""

    physics_step: float = 1 / 1024
    control_period: float = 1 / 128
    mode_period: float = 1 / 16
    record_period: float = 1 / 128


@dataclass
class Start:
    """How the flight begins: off on the ground, or in the air with rotors at hover speed.

    Position of the base link [m] (without one: standing on the ground, or hovering 1.5 m above
    it), roll, pitch, yaw [rad], velocity [m/s] and angular velocity [rad/s], both in W.
    """

    mode: str = "hovering"
    position: list[float] | None = None
    roll_pitch_yaw: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    angular_velocity: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])


@dataclass
class Action:
    """Something the pilot does at a time [s]; what is not given stays as it is.

    A velocity in W [m/s], a yaw rate [rad/s], a point to go to [m], a request (arm, take_off,
    land, stop) with its height [m], or new values of live parameters.
    """

    at: float = 0.0
    velocity: list[float] | None = None
    yaw_rate: float | None = None
    go_to: list[float] | None = None
    request: str | None = None
    height: float = 1.5
    set: dict[str, float] = field(default_factory=dict)


@dataclass
class FigureEight:
    """A path: a figure of eight around a centre [m], its size [m], time a lap [s], laps."""

    center: list[float] = field(default_factory=lambda: [0.0, 0.0, 1.5])
    length: float = 4.0
    width: float = 2.0
    period: float = 10.0
    laps: int = 2


@dataclass
class Scenario:
    """Everything that a flight is built from; equal scenarios give equal flights, to the bit."""

    title: str = ""
    vehicle: VehicleConfig = field(default_factory=VehicleConfig)
    rates: Rates = field(default_factory=Rates)
    start: Start = field(default_factory=Start)
    duration: float = 10.0
    script: list[Action] = field(default_factory=list)
    figure_eight: FigureEight | None = None


def load_scenario(path: Path) -> Scenario:
    """Read and check a scenario file.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    file = read_yaml(path)
    _refuse_unknown_keys(file, file.data, Scenario, ())
    try:
        scenario = yaml_load_typed(schema=Scenario, data=file.text, defaults=Scenario())
    except (RuntimeError, TypeError, ValueError) as error:
        raise WorkbenchError(f"{path}: {' '.join(str(error).split())}") from error
    check_scenario(scenario, file)
    return scenario


def save_scenario(scenario: Scenario, path: Path) -> None:
    """Write what differs from the default scenario to a YAML file."""
    yaml_dump_typed(scenario, filename=str(path), defaults=Scenario())


def check_scenario(scenario: Scenario, file: YamlFile | None = None) -> None:
    """Refuse numbers that cannot be flown.

    Raises:
        WorkbenchError: naming the key, and file and line where a file is given.
    """

    def refuse(keys: tuple[str | int, ...], reason: str) -> WorkbenchError:
        where = file.where(*keys) if file else ""
        return WorkbenchError(f"{where}{'.'.join(map(str, keys))} {reason}")

    if not 0.0 < scenario.duration < math.inf:
        raise refuse(("duration",), "must be a positive time in seconds")
    if scenario.start.mode not in START_MODES:
        raise refuse(("start", "mode"), f"must be one of {', '.join(START_MODES)}")
    step = scenario.rates.physics_step
    if not 0.0 < step <= 0.01:
        raise refuse(("rates", "physics_step"), "must be above 0 and at most 0.01 s")
    for rate in dataclasses.fields(Rates):
        steps = getattr(scenario.rates, rate.name) / step
        if steps < 1.0 or not float(steps).is_integer():
            raise refuse(("rates", rate.name), f"must be a multiple of the physics step {step:g} s")
    for index, action in enumerate(scenario.script):
        keys: tuple[str | int, ...] = ("script", index)
        if action.request is not None and action.request not in REQUESTS:
            raise refuse((*keys, "request"), f"must be one of {', '.join(REQUESTS)}")
        if not action.at >= 0.0:
            raise refuse((*keys, "at"), "must be a time in seconds, 0 or later")
    for keys, vector in _vectors(scenario):
        if len(vector) != 3 or not all(map(math.isfinite, vector)):
            raise refuse(keys, f"must be three finite numbers, is {vector}")


def _vectors(scenario: Scenario) -> list[tuple[tuple[str | int, ...], list[float]]]:
    """Return every vector of a scenario with its keys."""
    start = scenario.start
    found: list[tuple[tuple[str | int, ...], list[float] | None]] = [
        (("start", "position"), start.position),
        (("start", "roll_pitch_yaw"), start.roll_pitch_yaw),
        (("start", "velocity"), start.velocity),
        (("start", "angular_velocity"), start.angular_velocity),
    ]
    for index, action in enumerate(scenario.script):
        found.append((("script", index, "velocity"), action.velocity))
        found.append((("script", index, "go_to"), action.go_to))
    if scenario.figure_eight:
        found.append((("figure_eight", "center"), scenario.figure_eight.center))
    return [(keys, vector) for keys, vector in found if vector is not None]


def _refuse_unknown_keys(
    file: YamlFile, data: Any, schema: Any, keys: tuple[str | int, ...]
) -> None:
    """Walk data and schema together and refuse a key that the schema does not have."""
    for option in typing.get_args(schema) or (schema,):
        if isinstance(data, list):
            for index, item in enumerate(data):
                _refuse_unknown_keys(file, item, option, (*keys, index))
        elif dataclasses.is_dataclass(option) and isinstance(data, dict):
            known = {f.name: f.type for f in dataclasses.fields(option)}
            for key, value in data.items():
                if key not in known:
                    where = file.where(*keys, key)
                    raise WorkbenchError(f"{where}{unknown_name('key', str(key), known)}")
                _refuse_unknown_keys(file, value, known[key], (*keys, key))
