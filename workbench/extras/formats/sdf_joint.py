"""Joints of SDF."""

import math
from dataclasses import replace

import numpy as np
from pydrake.math import RigidTransform

from workbench.extras.formats.sdf_node import (
    FRAME_SEMANTICS_VERSION,
    Node,
    known_names,
    sdf_number,
    sdf_triple,
)
from workbench.extras.formats.sdf_poses import (
    MODEL_FRAME_NAME,
    SDF_WORLD_FRAME,
    Poses,
    joint_end,
    joint_key,
)
from workbench.plant.formats.joint_limits import (
    NO_LIMIT,
    REFUSED_JOINT_KINDS,
    drive_limit,
    has_range,
    joint_limits,
    limit_number,
)
from workbench.plant.formats.sdf_pose import sdf_flag
from workbench.plant.formats.values import attribute_number, shortened_text
from workbench.plant.model import Freedom, Joint, Mimic
from workbench.plant.remarks import Remarks

_SDF_JOINT_KINDS = (
    "ball",
    "continuous",
    "fixed",
    "gearbox",
    "prismatic",
    "revolute",
    "revolute2",
    "screw",
    "universal",
)
_JOINTS_WITHOUT_AXIS = ("ball", "fixed")
_JOINTS_WITH_TWO_AXES = ("revolute2", "universal")
_LAST_MODEL_AXIS_VERSION = (1, 4)
"""The last version in which the axis of a joint is given in the model frame."""


def read_sdf_joint(joint: Node, poses: Poses, remarks: Remarks) -> Joint:
    """Return a joint between two links, or between the world and one.

    Args:
        joint: its element.
        poses: of the model.
        remarks: receives a remark on an axis that is missing.

    Raises:
        WorkbenchError: naming file and line, for an invalid one.
    """
    kind = joint.attribute("type")
    if kind not in _SDF_JOINT_KINDS:
        what = f"{joint.title} has the type '{shortened_text(kind)}'"
        raise joint.fault(f"{what}: {known_names(kind, _SDF_JOINT_KINDS)}")
    parent, child = (
        poses.link_of(poses.find(joint, joint_end(joint, end))) for end in ("parent", "child")
    )
    if parent == child:
        raise joint.fault(
            f"{joint.title} joins '{shortened_text(child)}' to itself: name two links"
        )
    if child == SDF_WORLD_FRAME:  # the same joint, as the world cannot be a child
        parent, child = child, parent
    X_MJ = poses.X_MF(joint_key(joint))
    if kind in REFUSED_JOINT_KINDS:
        raise joint.fault(f"{joint.title} is a {kind} joint, which does not fly: use another type")
    tags = () if kind in _JOINTS_WITHOUT_AXIS else ("axis",)
    if kind in _JOINTS_WITH_TWO_AXES:
        tags = ("axis", "axis2")
    for tag in tags:
        if not joint.child(tag):
            remarks.add("assumed", joint.file, joint.title, f"it has no <{tag}>; taken as z")
    axes = [joint.child(tag) for tag in tags]
    freedoms = [_freedom(kind, joint, axis, X_MJ, poses) for axis in axes]
    armature = _motor_inertia(joint)
    if armature and len(freedoms) == 1:
        freedoms = [replace(freedoms[0], armature=armature)]
    elif armature:
        text = "it acts in joints of one axis; not used"
        remarks.add("ignored", joint.file, f"<drake:rotor_inertia> of {joint.title}", text)
    mimics = [axis.child("mimic") for axis in axes if axis] + [joint.child("drake:mimic")]
    mimic = next(filter(None, mimics), None)
    if mimic and len(axes) != 1:
        what = f"element <mimic> of {joint.title}"
        remarks.add("ignored", joint.file, what, "only joints of one axis follow others; not used")
    return Joint(
        joint.full_name,
        kind,
        parent,
        child,
        X_MJ,
        freedoms[0].axis_J if freedoms else (0.0, 0.0, 1.0),
        (_ball(joint, remarks),) if kind == "ball" else tuple(filter(has_range, freedoms)),
        _mimic(mimic) if mimic and len(freedoms) == 1 and has_range(freedoms[0]) else None,
    )


def _motor_inertia(joint: Node) -> float:
    """Return the reflected inertia of a motor, as in Drake: gear ratio² times rotor inertia."""
    return sdf_number(joint, "drake:gear_ratio", 1.0) ** 2 * sdf_number(
        joint, "drake:rotor_inertia", 0.0
    )


def _ball(joint: Node, remarks: Remarks) -> Freedom:
    """Return the freedom of a ball joint, with the damping and friction of its `<axis>`."""
    axis = joint.child("axis")
    dynamics = axis.child("dynamics") if axis else None
    stated = {
        tag: sdf_number(dynamics, tag, 0.0) if dynamics else 0.0 for tag in ("damping", "friction")
    }
    for tag, value in stated.items():
        if value < 0.0:
            text = f"<{tag}>{value:g}</{tag}> of a ball joint; taken as 0"
            remarks.add("repaired", joint.file, joint.title, text)
            stated[tag] = 0.0
    return Freedom("ball", damping=stated["damping"], friction=stated["friction"])


def _freedom(
    kind: str, joint: Node, axis: Node | None, X_MJ: RigidTransform, poses: Poses
) -> Freedom:
    """Return the freedom of an `<axis>` or `<axis2>`; without one, a turn about z."""
    if not axis:
        return Freedom("prismatic" if kind == "prismatic" else "revolute")
    limit, dynamics = axis.child("limit"), axis.child("dynamics")
    stated = (
        limit_number(axis.element, limit.text_of(name) if limit else "", default)
        for name, default in (("lower", -NO_LIMIT), ("upper", NO_LIMIT))
    )
    lower, upper = joint_limits(*stated)
    if kind == "continuous":
        lower, upper = -math.inf, math.inf
    damping, friction, rest, stiffness = (
        sdf_number(dynamics, tag, 0.0) if dynamics else 0.0
        for tag in ("damping", "friction", "spring_reference", "spring_stiffness")
    )
    effort, speed = (
        drive_limit(axis.element, limit.text_of(tag)) if limit else math.inf
        for tag in ("effort", "velocity")
    )
    return Freedom(
        "prismatic" if kind == "prismatic" else "revolute",
        _axis(joint, axis, X_MJ, poses),
        (0.0, 0.0, 0.0),
        lower,
        upper,
        damping,
        friction,
        stiffness,
        rest,
        effort=effort,
        speed=speed,
    )


def _mimic(node: Node) -> Mimic:
    """Return what an axis follows: multiplier times (position less the reference), and offset.

    In Drake's own `<drake:mimic>` multiplier and offset are attributes.
    """
    if node.element.tag == "drake:mimic":
        return Mimic(
            node.attribute("joint"),
            attribute_number(node.element, "multiplier", "1"),
            attribute_number(node.element, "offset", "0"),
        )
    multiplier = sdf_number(node, "multiplier", 1.0)
    offset = sdf_number(node, "offset", 0.0) - multiplier * sdf_number(node, "reference", 0.0)
    axis = 1 if node.attribute("axis") == "axis2" else 0
    return Mimic(node.attribute("joint"), multiplier, offset, axis)


def _axis(
    joint: Node, axis: Node, X_MJ: RigidTransform, poses: Poses
) -> tuple[float, float, float]:
    """Return the unit vector of an axis of a joint in the joint frame."""
    xyz = np.array(sdf_triple(axis, "xyz", (0.0, 0.0, 1.0)))
    length = float(np.linalg.norm(xyz))
    if length < 1e-9:
        raise axis.fault(f"{joint.title} has an axis without length: give it a direction")
    node = axis.child("xyz") or axis
    frame = node.attribute("expressed_in")
    if not frame and _is_in_model(axis):
        frame = MODEL_FRAME_NAME
    if frame:
        R_MF = poses.X_MF(poses.find(node, frame)).rotation()
        xyz = X_MJ.rotation().inverse() @ R_MF @ xyz
    x, y, z = (xyz / length).tolist()
    return (x, y, z)


def _is_in_model(axis: Node) -> bool:
    """Return whether the axis is given in the model frame, as in old files."""
    if axis.version >= FRAME_SEMANTICS_VERSION:
        return False
    word = axis.child("use_parent_model_frame")
    return axis.version <= _LAST_MODEL_AXIS_VERSION or (
        word is not None and sdf_flag(word.element, word.text)
    )
