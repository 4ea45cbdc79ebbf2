"""Gazebo's motor-model plugins, as RotorS and gz-sim read them from a description."""

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import WorkbenchError

_PLUGIN_FILES = ("gazebo_motor_model", "multicopter-motor-model")
_DIRECTIONS = {"ccw": 1, "cw": -1}
_LARGEST = 1e6
"""No tag of a motor is as large as this in its unit."""


@dataclass(frozen=True)
class MotorModel:
    """The tags of one motor-model plugin that the dynamics use; units as in `Rotor`."""

    number: int
    joint: str
    link: str
    direction: int
    motor_constant: float
    moment_constant: float
    time_constant_up: float
    time_constant_down: float
    max_rot_velocity: float
    velocity_slowdown: float


def read_motor_models(path: Path, robot: ET.Element) -> tuple[MotorModel, ...]:
    """Return the motor models of a URDF's `<gazebo>` blocks, by motor number.

    Raises:
        WorkbenchError: if a tag is missing or no number, or names a joint or link not there.
    """
    plugins = [
        plugin
        for plugin in robot.findall("gazebo/plugin")
        if any(name in plugin.get("filename", "") for name in _PLUGIN_FILES)
    ]
    motors = sorted((_read(path, plugin) for plugin in plugins), key=lambda motor: motor.number)
    for motor, earlier in zip(motors, [None, *motors], strict=False):
        if earlier and motor.number == earlier.number:
            raise WorkbenchError(
                f"{path}: '{earlier.joint}' and '{motor.joint}' both have the motorNumber "
                f"{motor.number}: number the rotors from 0"
            )
        _check_name(path, robot, "joint", motor.joint)
        _check_name(path, robot, "link", motor.link)
        child = robot.find(f"joint[@name='{motor.joint}']/child")
        if child is None or child.get("link") != motor.link:
            raise WorkbenchError(
                f"{path}: a motor-model plugin names the link '{motor.link}', but its joint "
                f"'{motor.joint}' turns another one: name the joint's child link"
            )
    return tuple(motors)


def _check_name(path: Path, robot: ET.Element, tag: str, name: str) -> None:
    names = [element.get("name", "") for element in robot.findall(tag)]
    if name not in names:
        raise WorkbenchError(
            f"{path}: a motor-model plugin names the {tag} '{name}', which is not there: "
            f"{tag}s are {', '.join(names)}"
        )


def _read(path: Path, plugin: ET.Element) -> MotorModel:
    """Return one plugin's tags."""

    def text(tag: str) -> str:
        value = plugin.findtext(tag)
        if value is None:
            raise WorkbenchError(f"{path}: motor-model plugin without <{tag}>: add it")
        return value.strip()

    def positive(tag: str, value: str) -> float:
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not 0.0 < number < _LARGEST:
            raise WorkbenchError(
                f"{path}: motor-model plugin has <{tag}>{value}</{tag}>: give it a positive number"
            )
        return number

    place = text("motorNumber")
    if not place.isdecimal():
        raise WorkbenchError(
            f"{path}: motor-model plugin has the motorNumber '{place}': use 0, 1, 2, ..."
        )
    direction = text("turningDirection")
    if direction not in _DIRECTIONS:
        raise WorkbenchError(
            f"{path}: motor-model plugin has the turningDirection '{direction}': use cw or ccw"
        )
    return MotorModel(
        number=int(place),
        joint=text("jointName"),
        link=text("linkName"),
        direction=_DIRECTIONS[direction],
        motor_constant=positive("motorConstant", text("motorConstant")),
        moment_constant=positive("momentConstant", text("momentConstant")),
        time_constant_up=positive("timeConstantUp", text("timeConstantUp")),
        time_constant_down=positive("timeConstantDown", text("timeConstantDown")),
        max_rot_velocity=positive("maxRotVelocity", text("maxRotVelocity")),
        velocity_slowdown=positive(
            "rotorVelocitySlowdownSim", plugin.findtext("rotorVelocitySlowdownSim", "10").strip()
        ),
    )
