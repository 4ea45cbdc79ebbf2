"""Position and axis of a rotor on the body, and the sense of rotation of its joint."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import Vector3, float_triple
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotors import Rotor

_MIN_TILT_RAD = math.radians(1.0)
_MAX_AXIS_TILT_RAD = math.radians(80.0)
"""Largest angle between the axis of a joint and the z axis of its link for an axis of thrust."""

_MAX_SPIN_TILT_RAD = math.radians(8.0)
"""Largest angle between the axes of a rotor and of the joint in which it spins."""
_MAX_SPIN_OFFSET_M = 0.01
"""Largest distance of a hub from that axis [m]."""


@dataclass(frozen=True)
class Mount:
    """Position and axis of a rotor on the body B.

    Attributes:
        p_BR: position of the hub [m].
        axis_B: unit vector of thrust.
        sense: sign of a positive rotation of the joint about `axis_B`: 1 or -1.
    """

    p_BR: Vector3
    axis_B: Vector3
    sense: int


def body_pose(model: Model, base_link: str) -> RigidTransform:
    """Return the pose of the model frame M in the body frame B.

    Raises:
        WorkbenchError: if the base link does not exist.
    """
    base = model.link(base_link)
    if base is None:
        raise WorkbenchError(f"{model.source}: there is no link '{base_link}'")
    return base.X_ML.inverse()


def mount_on_joint(
    model: Model, base_link: str, joint: Joint, link: Link, file: Path, remarks: Remarks
) -> Mount:
    """Return the mount of a rotor with a joint.

    The hub is the origin of the joint. Thrust is along the axis of the joint, on the side of the
    link's z axis, along which Gazebo applies thrust. If the two axes differ, the tilted one counts,
    as a tilt is intentional. An axis perpendicular to the link's z (such as URDF's default x) is
    not an axis of thrust. A fixed joint has no axis: see `mount_on_link`.

    Args:
        model: with joint and link.
        base_link: its frame is B.
        joint: its child is the link of the rotor.
        link: that child.
        file: for remarks.
        remarks: receives a remark if the axis is opposite to the thrust, or not along link z.
    """
    if joint.kind == "fixed":
        return mount_on_link(model, base_link, link)
    X_BJ = body_pose(model, base_link) @ joint.X_MJ
    axis_B = X_BJ.rotation().multiply(np.array(joint.axis_J))
    axis_B = axis_B / np.linalg.norm(axis_B)
    z_B = (body_pose(model, base_link) @ link.X_ML).rotation().matrix()[:, 2]
    cosine = float(axis_B @ z_B)
    sense = -1 if cosine < 0.0 else 1
    element = f"joint '{joint.name}'"
    if sense < 0:
        text = "its axis points against its link's z, the thrust; turning about it counts reversed"
        remarks.add("repaired", file, element, text)
    angle = math.acos(min(1.0, abs(cosine)))
    thrust_B = sense * axis_B
    if angle > _MIN_TILT_RAD:
        way = "the axis"
        if angle > _MAX_AXIS_TILT_RAD or (_leans(z_B) and not _leans(axis_B)):
            thrust_B, way = z_B, "z, as in Gazebo"
        text = f"its axis is {math.degrees(angle):.0f}° off its link's z; the thrust is along {way}"
        remarks.add("assumed", file, element, text)
    return Mount(float_triple(X_BJ.translation()), float_triple(thrust_B), sense)


def _leans(axis_B: np.ndarray) -> bool:
    """Return whether an axis is tilted from the body's z axis, up or down."""
    return math.acos(min(1.0, abs(float(axis_B[2])))) > _MIN_TILT_RAD


def mount_on_link(model: Model, base_link: str, link: Link) -> Mount:
    """Return the mount of a rotor along z of a link, at its centre of mass or else its origin."""
    X_BL = body_pose(model, base_link) @ link.X_ML
    p_LR = link.inertial.X_LI.translation() if link.inertial else np.zeros(3)
    return Mount(float_triple(X_BL.multiply(p_LR)), float_triple(X_BL.rotation().matrix()[:, 2]), 1)


def spin_joints(model: Model, base_link: str, rotors: Sequence[Rotor]) -> set[str]:
    """Return the names of the joints in which rotors spin.

    Besides those that rotors name, these are joints without limits about the axis of a rotor, as
    of a rotor that is given by its position alone.
    """
    found = {rotor.joint for rotor in rotors}
    X_BM = body_pose(model, base_link)
    for joint in model.joints:
        if len(joint.freedoms) != 1 or joint.freedoms[0].kind != "revolute":
            continue
        if math.isfinite(joint.freedoms[0].lower) and math.isfinite(joint.freedoms[0].upper):
            continue
        X_BJ = X_BM @ joint.X_MJ
        axis = X_BJ.rotation().multiply(np.array(joint.axis_J))
        for rotor in rotors:
            arm = np.array(rotor.p_BR) - X_BJ.translation()
            along = abs(float(axis @ np.array(rotor.axis_B))) > math.cos(_MAX_SPIN_TILT_RAD)
            if along and np.linalg.norm(np.cross(axis, arm)) < _MAX_SPIN_OFFSET_M:
                found.add(joint.name)
    return found
