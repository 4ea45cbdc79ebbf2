"""Read URDF, with Gazebo's extensions in `<gazebo>` blocks."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.joint_limits import (
    REFUSED_JOINT_KINDS,
    drive_limit,
    has_range,
    joint_limits,
    limit_number,
    planar_freedoms,
)
from workbench.plant.formats.sdf_pose import sdf_pose
from workbench.plant.formats.urdf_joint_additions import with_joint_additions
from workbench.plant.formats.urdf_servo import read_servo
from workbench.plant.formats.urdf_shapes import read_colours, read_shapes
from workbench.plant.formats.urdf_words import ROS_DRIVE_TAGS, note_unknown_urdf
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    attribute_triple,
    listed_names,
    origin,
    positive_attribute,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import (
    FREE_FREEDOMS,
    FREE_JOINT_KIND,
    Cable,
    DeclaredSensor,
    Freedom,
    Inertial,
    Joint,
    Link,
    Mimic,
    Model,
    refuse_too_many,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

_LIMITED_JOINT_KINDS = ("revolute", "continuous", "prismatic")
_FLOWN_JOINT_KINDS = (*_LIMITED_JOINT_KINDS, "planar", "universal", "ball")


def read_urdf(path: Path, robot: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the model in a URDF.

    Args:
        path: the file, for messages and relative paths.
        robot: its root element, `<robot>`.
        finder: of packages and meshes.
        remarks: receives remarks on unused parts.

    Raises:
        WorkbenchError: naming file and element, for invalid content.
    """
    if robot.tag != "robot":
        raise WorkbenchError(
            f"{path}: the root element is <{robot.tag}>, a URDF has <robot>, an MJCF <mujoco>"
        )
    elements = _children_with_tag(robot, "link")
    collisions = sum(len(_children_with_tag(link, "collision")) for link in elements)
    visuals = sum(len(_children_with_tag(link, "visual")) for link in elements)
    refuse_too_many(path, len(elements), visuals + collisions, collisions)
    note_unknown_urdf(path, robot, remarks)
    joint_elements = [
        child
        for child in robot
        if isinstance(child, Element) and child.tag in ("joint", "drake:joint")
    ]
    _refuse_twins([*elements])
    _refuse_twins([*joint_elements])
    links = [_element_name(element) for element in elements]
    ends = [
        (_joint_end_link(j, "parent", links), _joint_end_link(j, "child", links))
        for j in joint_elements
    ]
    X_ML = link_poses(
        path,
        links,
        [(*pair, origin(j)) for pair, j in zip(ends, joint_elements, strict=True)],
    )
    colours = read_colours(robot)
    cables = tuple(_cable(each, links) for each in _children_with_tag(robot, "cable"))
    hung = {cable.child for cable in cables}
    joints = [
        _urdf_joint(element, *pair, X_ML[pair[1]], hung)
        for element, pair in zip(joint_elements, ends, strict=True)
    ]
    return Model(
        source=path,
        name=robot.get("name") or path.name.partition(".")[0],
        links=tuple(
            Link(
                name=name,
                X_ML=X_ML[name],
                inertial=_inertial(element),
                visuals=tuple(read_shapes(path, element, "visual", colours, finder, remarks)),
                collisions=tuple(read_shapes(path, element, "collision", colours, finder, remarks)),
            )
            for name, element in zip(links, elements, strict=True)
        ),
        joints=with_joint_additions(path, robot, joints, remarks),
        frames=(),
        sensors=tuple(_urdf_sensors(path, robot, links, remarks)),
        plugins=tuple(
            plugin
            for block in _children_with_tag(robot, "gazebo")
            for plugin in _children_with_tag(block, "plugin")
        ),
        properties=tuple(
            (key, value)
            for element in _children_with_tag(robot, "properties")
            for key, value in element.attrib.items()
        ),
        cables=cables,
        drives=tuple(
            element for tag in ROS_DRIVE_TAGS for element in _children_with_tag(robot, tag)
        ),
    )


def _children_with_tag(element: Element, tag: str) -> list[Element]:
    """Return the children with a tag."""
    return [child for child in element if isinstance(child, Element) and child.tag == tag]


def _element_name(element: Element) -> str:
    name = element.get("name", "")
    if not name:
        raise WorkbenchError(f"{element_location(element)}: <{element.tag}> without a name: add it")
    return name


def _short_element_name(element: Element) -> str:
    """Return the name of an element for a message."""
    return shortened_text(element.get("name", ""))


def _refuse_twins(elements: list[Element]) -> None:
    """Reject two links or joints with one name."""
    seen: dict[str, Element] = {}
    for element in elements:
        name = _element_name(element)
        if name in seen:
            raise WorkbenchError(
                f"{element_location(element)}: there are two {element.tag}s named "
                f"'{shortened_text(name)}': rename one"
            )
        seen[name] = element


def _joint_end_link(joint: Element, end: str, links: list[str]) -> str:
    """Return the parent or child link of a joint."""
    element = joint.find(end)
    link = "" if element is None else element.get("link", "")
    if link not in links:
        raise WorkbenchError(
            f"{element_location(joint)}: {joint.tag} '{_short_element_name(joint)}' has the {end} "
            "link "
            f"'{shortened_text(link)}', "
            f"which does not exist: links are {listed_names(links)}"
        )
    return link


def _inertial(link: Element) -> Inertial | None:
    """Return mass and inertia of a link."""
    element = link.find("inertial")
    if not isinstance(element, Element):
        return None
    mass, inertia = element.find("mass"), element.find("inertia")
    if not isinstance(mass, Element):
        raise WorkbenchError(
            f"{element_location(element)}: link '{_short_element_name(link)}' has an <inertial> "
            "without <mass>: add it"
        )
    if not isinstance(inertia, Element):
        inertia = Element("inertia")
    xx, yy, zz, xy, xz, yz = (
        attribute_number(inertia, name, "0") for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    return Inertial(
        mass=attribute_number(mass, "value"),
        X_LI=origin(element),
        moments=(xx, yy, zz),
        products=(xy, xz, yz),
    )


def _cable(element: Element, links: list[str]) -> Cable:
    """Return a cable, an element of ours."""
    ends = []
    for tag in ("parent", "child"):
        link, end = _joint_end_link(element, tag, links), element.find(tag)
        assert isinstance(end, Element)
        ends.append((link, attribute_triple(end, "xyz", "0 0 0")))
    (parent, p_parent), (child, p_child) = ends
    if parent == child:
        raise WorkbenchError(
            f"{element_location(element)}: both ends of the cable "
            f"'{_short_element_name(element)}' are at the link '{shortened_text(parent)}': give "
            "it two links"
        )
    return Cable(
        _element_name(element),
        parent,
        p_parent,
        child,
        p_child,
        positive_attribute(element, "length"),
        *(max(attribute_number(element, name, "0"), 0.0) for name in ("stiffness", "damping")),
    )


def _urdf_joint(
    element: Element, parent: str, child: str, X_MJ: RigidTransform, hung: set[str]
) -> Joint:
    """Return a joint; its frame is that of the child link, and `hung` are links on cables."""
    axis = element.find("axis")
    x, y, z = (
        attribute_triple(axis, "xyz", "1 0 0") if isinstance(axis, Element) else (1.0, 0.0, 0.0)
    )
    length = float(np.linalg.norm((x, y, z)))
    if length < 1e-9 and element.get("type") == "fixed":  # a fixed joint has no axis
        x, y, z, length = 0.0, 0.0, 1.0, 1.0
    if length < 1e-9:
        raise WorkbenchError(
            f"{element_location(element)}: joint '{_short_element_name(element)}' has the axis 0 "
            "0 0: give it a direction"
        )
    axis_J = (x / length, y / length, z / length)
    kind = element.get("type", "")
    if kind not in (*_FLOWN_JOINT_KINDS, "fixed", FREE_JOINT_KIND):
        what = f"is a {kind} joint, which does not fly"
        if kind not in REFUSED_JOINT_KINDS:
            what = f"has the type '{shortened_text(kind)}', which URDF does not have"
        raise WorkbenchError(
            f"{element_location(element)}: joint '{_short_element_name(element)}' {what}: use "
            f"{', '.join(_FLOWN_JOINT_KINDS)} or fixed"
        )
    mimic = element.find("mimic")
    return Joint(
        name=_element_name(element),
        kind=kind,
        parent=parent,
        child=child,
        X_MJ=X_MJ,
        axis_J=axis_J,
        freedoms=FREE_FREEDOMS
        if kind == FREE_JOINT_KIND and child in hung
        else _urdf_freedoms(element, kind, axis_J),
        mimic=Mimic(
            mimic.get("joint", ""),
            attribute_number(mimic, "multiplier", "1"),
            attribute_number(mimic, "offset", "0"),
        )
        if isinstance(mimic, Element) and kind in _LIMITED_JOINT_KINDS
        else None,
    )


def _urdf_freedoms(
    joint: Element, kind: str, axis_J: tuple[float, float, float]
) -> tuple[Freedom, ...]:
    """Return the freedoms of a joint; a planar joint has its axis across the plane."""
    dynamics = joint.find("dynamics")
    if kind == "planar":
        return _planar_freedoms(dynamics, axis_J)
    damping, friction, stiffness, rest, armature = (
        attribute_number(dynamics, name, "0") if isinstance(dynamics, Element) else 0.0
        for name in ("damping", "friction", "stiffness", "rest", "armature")
    )
    if kind not in (*_LIMITED_JOINT_KINDS, "universal", "ball"):
        return ()
    lower, upper = -math.inf, math.inf
    limit = joint.find("limit")
    if isinstance(limit, Element) and kind != "continuous":
        free = kind == "universal" and {"lower", "upper"}.isdisjoint(limit.attrib)
        stated = [limit_number(limit, limit.get(name, ""), 0.0) for name in ("lower", "upper")]
        lower, upper = (-math.inf, math.inf) if free else joint_limits(*stated)
        if kind == "ball":  # `upper` alone limits it, if it is stated
            is_limited = "upper" in limit.attrib and upper < math.inf
            lower, upper = (0.0, upper) if is_limited else (-math.inf, math.inf)
    effort, speed = (
        drive_limit(limit, limit.get(name, "")) if isinstance(limit, Element) else math.inf
        for name in ("effort", "velocity")
    )
    found = Freedom(
        kind if kind in ("prismatic", "ball") else "revolute",
        axis_J,
        (0.0, 0.0, 0.0),
        lower,
        upper,
        damping,
        friction,
        stiffness,
        rest,
        armature,
        effort=effort,
        speed=speed,
        servo=read_servo(joint) if kind in _LIMITED_JOINT_KINDS else None,
    )
    if kind == "universal":  # Drake's, about x and y
        axes = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
        return tuple(replace(found, axis_J=axis) for axis in axes if has_range(found))
    return (found,) if has_range(found) else ()


def _planar_freedoms(dynamics: object, axis_J: tuple[float, float, float]) -> tuple[Freedom, ...]:
    """Return the freedoms of a planar joint, with one damping for all, or three as in Drake."""
    dampings: tuple[float, ...] = (0.0,)
    if isinstance(dynamics, Element):
        dampings = attribute_numbers(dynamics, "damping", "0")
        if len(dampings) not in (1, 3):
            raise WorkbenchError(
                f"{element_location(dynamics)}: <dynamics damping> of a planar joint: give it one "
                "number, or three, of the two translations and the turn"
            )
    freedoms = planar_freedoms(axis_J)
    dampings = dampings * (3 // len(dampings))
    return tuple(
        replace(each, damping=damping) for each, damping in zip(freedoms, dampings, strict=True)
    )


def _urdf_sensors(
    path: Path, robot: Element, links: list[str], remarks: Remarks
) -> Iterator[DeclaredSensor]:
    """Yield the sensors of `<gazebo reference>` blocks."""
    for block in _children_with_tag(robot, "gazebo"):
        link = block.get("reference", "")
        for sensor in _children_with_tag(block, "sensor"):
            if link in links:
                X_LS = sdf_pose(next(iter(_children_with_tag(sensor, "pose")), None))
                yield DeclaredSensor(link, X_LS, sensor)
            else:
                remarks.add(
                    "ignored",
                    path,
                    f"sensor '{sensor.get('name', '')}'",
                    f"its <gazebo> block refers to '{link}', which is not a link",
                )


def link_poses(
    path: Path, links: list[str], joints: list[tuple[str, str, RigidTransform]]
) -> dict[str, RigidTransform]:
    """Return the pose of each link in the frame of its root link.

    Args:
        path: for messages.
        links: names.
        joints: parent, child, and the child's pose in the parent.

    Raises:
        WorkbenchError: if a link is the child of two joints, or joints form a circle.
    """
    above: dict[str, tuple[str, RigidTransform]] = {}
    for parent, child, X_PC in joints:
        if child in above:
            raise WorkbenchError(
                f"{path}: link '{shortened_text(child)}' is the child of two joints: a URDF is a "
                "tree, "
                "so leave one out"
            )
        above[child] = (parent, X_PC)
    poses = {name: RigidTransform() for name in links if name not in above}
    for name in links:
        way = [name]
        while way[-1] not in poses:
            way.append(above[way[-1]][0])
            if len(way) > len(links):
                raise WorkbenchError(
                    f"{path}: the joints above link '{shortened_text(name)}' form a loop: one "
                    "link must "
                    "not be the child of a joint"
                )
        for child in reversed(way[:-1]):
            parent, X_PC = above[child]
            poses[child] = poses[parent] @ X_PC
    return poses
