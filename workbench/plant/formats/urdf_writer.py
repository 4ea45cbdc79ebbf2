"""Write a model as a URDF for Drake, and a description as files to store.

The model is one tree of links; meshes are referred to by path.
"""

import copy
import dataclasses
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree as ET

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.plant.description import Description
from workbench.plant.formats.joint_limits import NO_LIMIT
from workbench.plant.formats.urdf_servo import add_servo
from workbench.plant.gathered import body_roots, with_single_freedoms
from workbench.plant.model import (
    Cable,
    DeclaredSensor,
    Freedom,
    Inertial,
    Joint,
    Link,
    LinkShape,
    Model,
)
from workbench.plant.rotors import Rotor
from workbench.plant.sensors import free_name
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Mesh, Sphere
from workbench.plant.vehicle import BatteryPack

_TURNING_JOINT_KINDS = ("continuous", "revolute")


def write_urdf(model: Model, turning: Iterable[str] = ()) -> ET.Element:
    """Return a model as the `<robot>` element of a URDF.

    Args:
        model: one tree of links, with meshes that Drake can read.
        turning: names of joints to write as continuous; those that move are written with their
            freedoms, and all others as fixed.
    """
    loads = {joint.name for joint in model.joints if joint.is_free}
    joints = [joint.held() if joint.name in loads else joint for joint in model.joints]
    model = with_single_freedoms(dataclasses.replace(model, joints=tuple(joints)))
    names = {*turning, *(joint.name for joint in model.joints if joint.moves)}
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
        kind = joint.kind if joint.name in loads else _written_kind(joint, names)
        _add_joint(robot, joint, X_PC, kind)
    for cable in model.cables:
        _add_cable(robot, cable, model, frames)
    return robot


def _written_kind(joint: Joint, free: set[str]) -> str:
    """Return the kind of a joint in the file, given the names of those that move or turn."""
    if not joint.freedoms:
        return "continuous" if joint.name in free else "fixed"
    (freedom,) = joint.freedoms
    limited = math.isfinite(freedom.lower) or math.isfinite(freedom.upper)
    return "continuous" if freedom.kind == "revolute" and not limited else freedom.kind


def _add_link(robot: ET.Element, link: Link, X_FL: RigidTransform) -> None:
    """Add a link with a frame F that may differ from that in the description."""
    element = ET.SubElement(robot, "link", name=link.name)
    if link.inertial:
        _add_inertial(element, link.inertial, X_FL)
    for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        for name, shape in zip(_unique_names(shapes), shapes, strict=True):
            _add_shape(element, tag, name, shape, X_FL)


def _add_inertial(link: ET.Element, inertial: Inertial, X_FL: RigidTransform) -> None:
    element = ET.SubElement(link, "inertial")
    _add_origin(element, X_FL @ inertial.X_LI)
    ET.SubElement(element, "mass", value=repr(inertial.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = (*inertial.moments, *inertial.products)
    ET.SubElement(element, "inertia", dict(zip(names, map(repr, values), strict=True)))


def _unique_names(shapes: Sequence[LinkShape]) -> list[str]:
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
        ET.SubElement(material, "color", rgba=_values_text(shape.rgba))
    if tag == "collision" and isinstance(shape.shape, Mesh):
        ET.SubElement(geometry[0], "drake:declare_convex")


def _geometry(shape: GeometryShape) -> ET.Element:
    match shape:
        case Box(size):
            return ET.Element("box", size=_values_text(size))
        case Sphere(radius):
            return ET.Element("sphere", radius=repr(radius))
        case Cylinder(radius, length):
            return ET.Element("cylinder", radius=repr(radius), length=repr(length))
        case Capsule(radius, length):
            return ET.Element("capsule", radius=repr(radius), length=repr(length))
        case Ellipsoid((a, b, c)):
            return ET.Element("drake:ellipsoid", a=repr(a), b=repr(b), c=repr(c))
        case Mesh(uri=uri, path=path):
            if path:
                uri = path.as_uri() if path.is_absolute() else path.as_posix()
            return ET.Element("mesh", filename=uri)


def _add_joint(robot: ET.Element, joint: Joint, X_PC: RigidTransform, kind: str) -> None:
    tag = "drake:joint" if kind == "ball" else "joint"  # which URDF does not have
    element = ET.SubElement(robot, tag, name=joint.name, type=kind)
    _add_origin(element, X_PC)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    if kind not in ("fixed", "ball"):
        ET.SubElement(element, "axis", xyz=_values_text(joint.axis_J))
    for freedom in joint.freedoms:
        _add_freedom(element, freedom)
    if joint.mimic:
        words = {"joint": joint.mimic.joint, "multiplier": repr(joint.mimic.multiplier)}
        ET.SubElement(element, "mimic", words, offset=repr(joint.mimic.offset))


def _add_freedom(joint: ET.Element, freedom: Freedom) -> None:
    """Add limits and dynamics; a spring and the armature are our own attributes."""
    limits = freedom.lower, freedom.upper
    if any(map(math.isfinite, limits)):
        lower, upper = (min(max(each, -NO_LIMIT), NO_LIMIT) for each in limits)
        ET.SubElement(joint, "limit", lower=repr(lower), upper=repr(upper), effort="-1")
    names = ("damping", "friction", "stiffness", "rest", "armature")
    values = {name: repr(getattr(freedom, name)) for name in names if getattr(freedom, name)}
    if values:
        ET.SubElement(joint, "dynamics", values)
    if freedom.servo:
        add_servo(joint, freedom.servo)


def _add_cable(
    robot: ET.Element, cable: Cable, model: Model, frames: Mapping[str, RigidTransform]
) -> None:
    """Add a cable, an element of our own, with its ends in the written frames of links."""
    numbers = {"length": cable.length, "stiffness": cable.stiffness, "damping": cable.damping}
    stated = {name: repr(value) for name, value in numbers.items() if value}
    element = ET.SubElement(robot, "cable", {"name": cable.name, **stated})
    for tag, name, p in (
        ("parent", cable.parent, cable.p_parent),
        ("child", cable.child, cable.p_child),
    ):
        link = model.link(name)
        assert link
        place = (frames[name].inverse() @ link.X_ML).multiply(np.array(p))
        ET.SubElement(element, tag, link=name, xyz=_values_text(place))


def _add_origin(element: ET.Element, X: RigidTransform) -> None:
    rpy = RollPitchYaw(X.rotation()).vector()
    ET.SubElement(element, "origin", xyz=_values_text(X.translation()), rpy=_values_text(rpy))


def _values_text(values: Iterable[float]) -> str:
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
    add_rotor_plugins(robot, model, description.base_link, description.rotors, turning)
    if description.battery:
        add_battery_plugin(robot, description.battery)
    add_sensor_elements(robot, model.sensors)
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
        and joint.kind in _TURNING_JOINT_KINDS
        and (link := model.link(joint.child))
        and link.inertial
    }


def add_rotor_plugins(
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
            _add_hub(robot, model, base_link, rotor, joint, link)
        values = (
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
        )
        _add_plugin(robot, "multicopter-motor-model", "MulticopterMotorModel", values)


def add_battery_plugin(robot: ET.Element, battery: BatteryPack) -> None:
    """Add gz-sim's battery plugin, with the whole curve in our own element."""
    full, empty = battery.open_circuit_voltage[-1][1], battery.open_circuit_voltage[0][1]
    values = (
        ("battery_name", "battery"),
        ("voltage", full),
        ("open_circuit_voltage_constant_coef", full),
        ("open_circuit_voltage_linear_coef", empty - full),
        ("openCircuitVoltage", _values_text(np.ravel(battery.open_circuit_voltage))),
        ("capacity", battery.capacity / 3600.0),
        ("resistance", battery.resistance),
        ("hoverDuration", battery.hover_duration),
        ("sagCompensation", battery.sag_compensation),
    )
    _add_plugin(robot, "linear-battery-plugin", "LinearBatteryPlugin", values)


def _add_plugin(
    robot: ET.Element, file: str, name: str, values: Iterable[tuple[str, str | float | None]]
) -> None:
    """Add a plugin of gz-sim with its values; None is left out."""
    words = {"filename": f"gz-sim-{file}-system", "name": f"gz::sim::systems::{name}"}
    plugin = ET.SubElement(ET.SubElement(robot, "gazebo"), "plugin", words)
    for tag, value in values:
        if value is not None:
            ET.SubElement(plugin, tag).text = value if isinstance(value, str) else repr(value)


def _free_name(robot: ET.Element, name: str) -> str:
    """Return a name that no link or joint has: this one, or with a number."""
    taken = {element.get("name", "") for tag in ("link", "joint") for element in robot.findall(tag)}
    return free_name(taken, name)


def add_sensor_elements(robot: ET.Element, sensors: tuple[DeclaredSensor, ...]) -> None:
    """Add the elements of sensors, with resolved poses."""
    for sensor in sensors:
        block = ET.SubElement(robot, "gazebo", reference=sensor.link)
        element = copy.deepcopy(sensor.element)
        for pose in element.findall("pose"):
            element.remove(pose)
        ET.SubElement(element, "pose").text = _pose_text(sensor.X_LS)
        block.append(element)


def _add_hub(
    robot: ET.Element, model: Model, base_link: str, rotor: Rotor, joint: str, link: str
) -> None:
    """Add a link whose z is the axis of a rotor, to the link that moves it or to the base link."""
    base, carrier = model.link(base_link), model.link(rotor.link)
    R_BR = RotationMatrix.MakeFromOneVector(np.array(rotor.axis_B), axis_index=2)
    X_PR = RigidTransform(R_BR, np.array(rotor.p_BR))
    if base and carrier and body_roots(model, base_link)[rotor.link] != base_link:
        X_PR, base_link = carrier.X_ML.InvertAndCompose(base.X_ML @ X_PR), carrier.name
    xyz, rpy = X_PR.translation(), RollPitchYaw(X_PR.rotation()).vector()
    ET.SubElement(robot, "link", name=link)
    element = ET.SubElement(robot, "joint", name=joint, type="fixed")
    ET.SubElement(element, "origin", xyz=_values_text(xyz), rpy=_values_text(rpy))
    ET.SubElement(element, "parent", link=base_link)
    ET.SubElement(element, "child", link=link)


def _pose_text(X: RigidTransform) -> str:
    return f"{_values_text(X.translation())} {_values_text(RollPitchYaw(X.rotation()).vector())}"
