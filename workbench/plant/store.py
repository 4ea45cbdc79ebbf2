"""A description to keep: one URDF that Drake reads, with its meshes beside it."""

import copy
import dataclasses
import re
from collections.abc import Iterator
from itertools import count
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.plant.description import Description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.model import DeclaredSensor, Link, LinkShape, Model
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Mesh
from workbench.plant.vehicle import BatteryPack

_TURNING = ("continuous", "revolute")


def stored_files(description: Description) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield the files of a description, by path within a folder of their own, URDF first.

    Rotors turn on continuous joints where they have mass, and stand as motor-model plugins;
    reading the URDF again gives the same vehicle.
    """
    meshes: dict[Path, PurePosixPath] = {}
    model = dataclasses.replace(
        description.model,
        links=tuple(_with_own_meshes(link, meshes) for link in description.model.links),
    )
    turning = turning_joints(model, description.rotors)
    robot = write_urdf(model, turning)
    robot.set("xmlns:drake", "http://drake.mit.edu")
    add_rotors(robot, model, description.base_link, description.rotors, turning)
    if description.battery:
        add_battery(robot, description.battery)
    add_sensors(robot, model.sensors)
    ET.indent(robot)
    text = f'<?xml version="1.0"?>\n{ET.tostring(robot, encoding="unicode")}\n'
    yield PurePosixPath(f"{safe_name(description.name)}.urdf"), text.encode()
    for path, stored in meshes.items():
        yield stored, path.read_bytes()


def safe_name(name: str) -> str:
    """Return a name that is one plain file name, whatever a description calls itself."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:80].strip("._") or "model"


def _with_own_meshes(link: Link, meshes: dict[Path, PurePosixPath]) -> Link:
    """Return a link whose meshes lie beside the URDF, and note which those are."""

    def moved(shape: LinkShape) -> LinkShape:
        mesh = shape.shape
        if not isinstance(mesh, Mesh) or mesh.path is None:
            return shape
        stored = meshes.setdefault(mesh.path, PurePosixPath("meshes") / safe_name(mesh.path.name))
        return dataclasses.replace(shape, shape=Mesh(str(stored), Path(stored)))

    return dataclasses.replace(
        link,
        visuals=tuple(map(moved, link.visuals)),
        collisions=tuple(map(moved, link.collisions)),
    )


def turning_joints(model: Model, rotors: tuple[Rotor, ...]) -> set[str]:
    """Return the rotors' joints that can be written as turning: Drake wants mass below those."""
    return {
        joint.name
        for rotor in rotors
        if (joint := model.joint(rotor.joint))
        and joint.kind in _TURNING
        and (link := model.link(joint.child))
        and link.inertial
    }


def add_rotors(
    robot: ET.Element, model: Model, base_link: str, rotors: tuple[Rotor, ...], turning: set[str]
) -> None:
    """Add a motor-model plugin for each rotor, and a link at the hub of those that do not turn."""
    for number, rotor in enumerate(rotors):
        joint, link, direction = rotor.joint, rotor.link, rotor.direction
        if joint in turning:
            declared = model.joint(joint)
            base = model.link(base_link)
            assert declared and base
            # Read again, the thrust is on the side of z, whichever way the rotor turns in flight.
            direction = direction if declared.axis_J[2] >= 0.0 else -direction
        else:
            link = _free_name(robot, f"{rotor.name}_hub")
            joint = _free_name(robot, f"{link}_joint")
            _add_hub(robot, base_link, rotor, joint, link)
        plugin = ET.SubElement(
            ET.SubElement(robot, "gazebo"),
            "plugin",
            filename="gz-sim-multicopter-motor-model-system",
            name="gz::sim::systems::MulticopterMotorModel",
        )
        for tag, value in (
            ("jointName", joint),
            ("linkName", link),
            ("turningDirection", "ccw" if direction > 0 else "cw"),
            ("timeConstantUp", rotor.time_constant_up),
            ("timeConstantDown", rotor.time_constant_down),
            ("maxRotVelocity", rotor.max_rot_velocity),
            ("motorConstant", rotor.motor_constant),
            ("momentConstant", rotor.moment_constant),
            ("motorNumber", number),
            ("rotorVelocitySlowdownSim", rotor.velocity_slowdown),
            ("rotorDragCoefficient", rotor.rotor_drag_coefficient),
            ("rollingMomentCoefficient", rotor.rolling_moment_coefficient),
            ("rotorInertia", rotor.inertia),
            ("inflowCoefficient", rotor.inflow_coefficient),
            ("groundEffectCoefficient", rotor.ground_effect_coefficient),
            ("propellerRadius", rotor.propeller_radius),
            ("linearMotorConstant", rotor.linear_motor_constant),
        ):
            ET.SubElement(plugin, tag).text = value if isinstance(value, str) else repr(value)


def add_battery(robot: ET.Element, battery: BatteryPack) -> None:
    """Add gz-sim's battery plugin, with the whole curve in a tag of ours."""
    full, empty = battery.open_circuit_voltage[-1][1], battery.open_circuit_voltage[0][1]
    plugin = ET.SubElement(
        ET.SubElement(robot, "gazebo"),
        "plugin",
        filename="gz-sim-linear-battery-plugin-system",
        name="gz::sim::systems::LinearBatteryPlugin",
    )
    for tag, value in (
        ("battery_name", "battery"),
        ("voltage", repr(full)),
        ("open_circuit_voltage_constant_coef", repr(full)),
        ("open_circuit_voltage_linear_coef", repr(empty - full)),
        ("openCircuitVoltage", _text(np.ravel(battery.open_circuit_voltage))),
        ("capacity", repr(battery.capacity / 3600.0)),
        ("resistance", repr(battery.resistance)),
    ):
        ET.SubElement(plugin, tag).text = value


def _free_name(robot: ET.Element, name: str) -> str:
    """Return a name that no link or joint has: this one, or with a number behind."""
    taken = {element.get("name") for tag in ("link", "joint") for element in robot.findall(tag)}
    names = (name if number == 1 else f"{name}_{number}" for number in count(1))
    return next(each for each in names if each not in taken)


def add_sensors(robot: ET.Element, sensors: tuple[DeclaredSensor, ...]) -> None:
    """Add the sensors' own elements, with their poses resolved."""
    for sensor in sensors:
        block = ET.SubElement(robot, "gazebo", reference=sensor.link)
        element = copy.deepcopy(sensor.element)
        for pose in element.findall("pose"):
            element.remove(pose)
        ET.SubElement(element, "pose").text = _pose(sensor.X_LS)
        block.append(element)


def _add_hub(robot: ET.Element, base_link: str, rotor: Rotor, joint: str, link: str) -> None:
    """Add a frame whose z is the rotor's axis."""
    R_BR = RotationMatrix.MakeFromOneVector(np.array(rotor.axis_B), axis_index=2)
    xyz, rpy = np.array(rotor.p_BR), RollPitchYaw(R_BR).vector()
    ET.SubElement(robot, "link", name=link)
    element = ET.SubElement(robot, "joint", name=joint, type="fixed")
    ET.SubElement(element, "origin", xyz=_text(xyz), rpy=_text(rpy))
    ET.SubElement(element, "parent", link=base_link)
    ET.SubElement(element, "child", link=link)


def _pose(X: RigidTransform) -> str:
    return f"{_text(X.translation())} {_text(RollPitchYaw(X.rotation()).vector())}"


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)
