"""Write a model as a URDF for Drake, and a description as files to store.

The model is one tree of links; meshes are referred to by path.
"""

import copy
import dataclasses
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.plant.description import Description
from workbench.plant.model import MOVING, DeclaredSensor, Inertial, Joint, Link, LinkShape, Model
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere
from workbench.plant.vehicle import BatteryPack

_TURNING = ("continuous", "revolute")


def write_urdf(model: Model, turning: Iterable[str] = ()) -> ET.Element:
    """Return a model as the `<robot>` element of a URDF.

    Args:
        model: one tree of links, with meshes that Drake can read.
        turning: names of joints to write as continuous; those of `MOVING` kinds are written as they
            are, and all others as fixed.
    """
    names = {*turning, *(joint.name for joint in model.joints if joint.kind in MOVING)}
    robot = ET.Element("robot", name=model.name)
    # If a joint turns about another point than the origin of its link, move the link frame there.
    frames = {
        link.name: joint.X_MJ
        if (joint := model.joint_of(link.name)) and joint.name in names
        else link.X_ML
        for link in model.links
    }
    for link in model.links:
        _add_link(robot, link, frames[link.name].inverse() @ link.X_ML)
    for joint in model.joints:
        X_PC = frames[joint.parent].inverse() @ frames[joint.child]
        _add_joint(robot, joint, X_PC, _written_kind(joint, names))
    return robot


def _written_kind(joint: Joint, free: set[str]) -> str:
    """Return the kind of a joint in the file, given the names of those that move or turn."""
    if joint.kind in MOVING:
        return joint.kind
    return "continuous" if joint.name in free else "fixed"


def _add_link(robot: ET.Element, link: Link, X_FL: RigidTransform) -> None:
    """Add a link with a frame F that may differ from that in the description."""
    element = ET.SubElement(robot, "link", name=link.name)
    if link.inertial:
        _add_inertial(element, link.inertial, X_FL)
    for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        for name, shape in zip(_different(shapes), shapes, strict=True):
            _add_shape(element, tag, name, shape, X_FL)


def _add_inertial(link: ET.Element, inertial: Inertial, X_FL: RigidTransform) -> None:
    element = ET.SubElement(link, "inertial")
    _add_origin(element, X_FL @ inertial.X_LI)
    ET.SubElement(element, "mass", value=repr(inertial.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = (*inertial.moments, *inertial.products)
    ET.SubElement(element, "inertia", dict(zip(names, map(repr, values), strict=True)))


def _different(shapes: Sequence[LinkShape]) -> list[str]:
    """Return names of shapes, with numbers if one occurs twice; Drake requires unique names."""
    names = [shape.name for shape in shapes]
    if len(set(names)) == len(names):
        return names
    return [f"{name}_{index}" for index, name in enumerate(names)]


def _add_shape(
    link: ET.Element, tag: str, name: str, shape: LinkShape, X_FL: RigidTransform
) -> None:
    element = ET.SubElement(link, tag, name=name)
    _add_origin(element, X_FL @ shape.X_LS)
    geometry = ET.SubElement(element, "geometry")
    geometry.append(_geometry(shape.shape))
    if shape.rgba:
        name = "rgba_" + "_".join(f"{round(255 * value):02x}" for value in shape.rgba)
        material = ET.SubElement(element, "material", name=name)
        ET.SubElement(material, "color", rgba=_text(shape.rgba))
    if tag == "collision" and isinstance(shape.shape, Mesh):
        ET.SubElement(geometry[0], "drake:declare_convex")


def _geometry(shape: Shape) -> ET.Element:
    match shape:
        case Box(size):
            return ET.Element("box", size=_text(size))
        case Sphere(radius):
            return ET.Element("sphere", radius=repr(radius))
        case Cylinder(radius, length):
            return ET.Element("cylinder", radius=repr(radius), length=repr(length))
        case Capsule(radius, length):
            return ET.Element("capsule", radius=repr(radius), length=repr(length))
        case Ellipsoid((a, b, c)):
            return ET.Element("drake:ellipsoid", a=repr(a), b=repr(b), c=repr(c))
        case Mesh(uri=uri, path=path):
            return ET.Element("mesh", filename=_uri(path) if path else uri)


def _add_joint(robot: ET.Element, joint: Joint, X_PC: RigidTransform, kind: str) -> None:
    tag = "drake:joint" if kind in MOVING else "joint"  # which URDF does not have
    element = ET.SubElement(robot, tag, name=joint.name, type=kind)
    _add_origin(element, X_PC)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    if kind not in ("fixed", *MOVING):
        ET.SubElement(element, "axis", xyz=_text(joint.axis_J))


def _add_origin(element: ET.Element, X: RigidTransform) -> None:
    rpy = RollPitchYaw(X.rotation()).vector()
    ET.SubElement(element, "origin", xyz=_text(X.translation()), rpy=_text(rpy))


def _uri(path: Path) -> str:
    """Return an absolute path as a file URI, a relative one unchanged."""
    return path.as_uri() if path.is_absolute() else path.as_posix()


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def stored_files(description: Description) -> Iterator[tuple[PurePosixPath, bytes]]:
    """Yield the files of a description by relative path, URDF first.

    Rotors with mass turn on continuous joints. All rotors are written as motor-model plugins.
    Reading the URDF yields the same vehicle.
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
    """Return a valid file name for the name of a description or file."""
    return re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:80].strip("._") or "model"


def _with_own_meshes(link: Link, meshes: dict[Path, PurePosixPath]) -> Link:
    """Return a link with meshes next to the URDF, and add them to `meshes`."""

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
    """Return the joints of rotors to write as turning: Drake requires mass below those."""
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
    """Add a motor-model plugin for each rotor, and a hub link for those without a turning joint."""
    for number, rotor in enumerate(rotors):
        joint, link, direction = rotor.joint, rotor.link, rotor.direction
        if joint in turning:
            declared = model.joint(joint)
            base = model.link(base_link)
            assert declared and base
            # When read, thrust is on the side of z, whichever way the rotor turns in flight.
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
    """Add gz-sim's battery plugin, with the whole curve in our own element."""
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
        ("hoverDuration", _or_none(battery.hover_duration)),
        ("sagCompensation", _or_none(battery.sag_compensation)),
    ):
        if value is not None:
            ET.SubElement(plugin, tag).text = value


def _or_none(number: float | None) -> str | None:
    return None if number is None else repr(number)


def _free_name(robot: ET.Element, name: str) -> str:
    """Return a name that no link or joint has: this one, or with a number."""
    taken = {element.get("name") for tag in ("link", "joint") for element in robot.findall(tag)}
    names = (name if number == 1 else f"{name}_{number}" for number in count(1))
    return next(each for each in names if each not in taken)


def add_sensors(robot: ET.Element, sensors: tuple[DeclaredSensor, ...]) -> None:
    """Add the elements of sensors, with resolved poses."""
    for sensor in sensors:
        block = ET.SubElement(robot, "gazebo", reference=sensor.link)
        element = copy.deepcopy(sensor.element)
        for pose in element.findall("pose"):
            element.remove(pose)
        ET.SubElement(element, "pose").text = _pose(sensor.X_LS)
        block.append(element)


def _add_hub(robot: ET.Element, base_link: str, rotor: Rotor, joint: str, link: str) -> None:
    """Add a link whose z is the axis of a rotor."""
    R_BR = RotationMatrix.MakeFromOneVector(np.array(rotor.axis_B), axis_index=2)
    xyz, rpy = np.array(rotor.p_BR), RollPitchYaw(R_BR).vector()
    ET.SubElement(robot, "link", name=link)
    element = ET.SubElement(robot, "joint", name=joint, type="fixed")
    ET.SubElement(element, "origin", xyz=_text(xyz), rpy=_text(rpy))
    ET.SubElement(element, "parent", link=base_link)
    ET.SubElement(element, "child", link=link)


def _pose(X: RigidTransform) -> str:
    return f"{_text(X.translation())} {_text(RollPitchYaw(X.rotation()).vector())}"
