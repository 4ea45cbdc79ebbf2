"""The inertia of a rotor about its axis: stated, or that of the links that turn with it."""

import math
from pathlib import Path

import numpy as np

from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotors import propeller_diameter
from workbench.plant.tree import links_below

_TURNING = ("continuous", "revolute")
_WIDEST = 0.75
"""Radius of gyration over the radius of a propeller: a rod's is 0.58, nobody loads the tips, and
the radius that follows from the thrust is right to a fifth."""
_NARROWEST = 0.04
"""Likewise: of a motor's bell alone it is 0.1."""


def spin_inertia(
    model: Model,
    joint: Joint,
    *,
    motor_constant: float,
    slowdown: float,
    file: Path,
    remarks: Remarks,
) -> float:
    """Return the inertia about a joint's axis of all links that turn with it [kg·m²].

    It is 0 for a joint that does not turn: what hangs on it may be a motor and its mount.

    RotorS and PX4 let rotors turn slower in the simulation and write their inertia as many times
    larger, so that the angular momentum is right (`rotor_velocity_slowdown_sim` in RotorS'
    multirotor_base.xacro). Where a propeller of that mass and size cannot have what is written,
    and can have it over that factor, the latter is taken.

    Args:
        model: to which the joint belongs.
        joint: the rotor's.
        motor_constant: of the rotor, which tells its size [N·s²].
        slowdown: how many times slower the description lets the joint turn, 1 for not at all.
        file: for remarks.
        remarks: where it is noted if the factor is taken out, or what is written is implausible.
    """
    if joint.kind not in _TURNING:
        return 0.0
    names = links_below(model, joint.child)
    mass, inertia = 0.0, 0.0
    for link in model.links:
        if link.name in names and link.inertial:
            mass += link.inertial.mass
            inertia += _about(joint, link)
    if not (mass > 0.0 and 0.0 < inertia < math.inf):  # a frame, or it is refused later
        return 0.0
    squared = mass * (propeller_diameter(motor_constant) / 2.0) ** 2
    least, widest = _NARROWEST**2 * squared, _WIDEST**2 * squared
    element = f"rotor inertia of '{joint.name}'"
    if slowdown > 1.0 and inertia > widest >= inertia / slowdown:
        text = (
            f"{inertia:.3g} kg m² about its axis, which no propeller of {mass:.3g} kg has; taken "
            f"as written {slowdown:g} times too large for the slower turning in Gazebo "
            f"(rotorVelocitySlowdownSim), so {inertia / slowdown:.3g} kg m²"
        )
        remarks.add("repaired", file, element, text)
        return inertia / slowdown
    if not least <= inertia <= widest:
        text = (
            f"{inertia:.3g} kg m² about its axis, and a propeller of its thrust and of {mass:.3g} "
            f"kg has {least:.1g} to {widest:.1g}: is it a placeholder? It is taken as written"
        )
        remarks.add("assumed", file, element, text)
    return inertia


def _about(joint: Joint, link: Link) -> float:
    """Return the inertia of a link about a joint's axis [kg·m²]."""
    assert link.inertial
    X_MI = link.X_ML @ link.inertial.X_LI
    axis_M = joint.X_MJ.rotation().matrix() @ np.array(joint.axis_J)
    axis_I = X_MI.rotation().matrix().T @ axis_M
    xx, yy, zz = link.inertial.moments
    xy, xz, yz = link.inertial.products
    own = axis_I @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axis_I
    arm = np.cross(X_MI.translation() - joint.X_MJ.translation(), axis_M)
    return float(own + link.inertial.mass * arm @ arm)
