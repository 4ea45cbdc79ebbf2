"""The constants of Gazebo's motor model, and their values if a description omits them."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import XmlBlock
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mount import Mount
from workbench.plant.rotors import Rotor, propeller_diameter
from workbench.plant.tree import links_below

_DEFAULTED_TAGS = {
    "moment_constant": "momentConstant",
    "time_constant_up": "timeConstantUp",
    "time_constant_down": "timeConstantDown",
    "max_rot_velocity": "maxRotVelocity",
    "velocity_slowdown": "rotorVelocitySlowdownSim",
}
"""Tags of constants with a default in Gazebo, by field of `Rotor`."""
_OPTIONAL_TAGS = {
    "rotor_drag_coefficient": "rotorDragCoefficient",
    "rolling_moment_coefficient": "rollingMomentCoefficient",
    "inertia": "rotorInertia",
    "inflow_coefficient": "inflowCoefficient",
    "ground_effect_coefficient": "groundEffectCoefficient",
    "propeller_radius": "propellerRadius",
    "linear_motor_constant": "linearMotorConstant",
}
"""Tags of constants that are 0 if omitted; the inertia is then that of the rotor's link."""
OPTIONAL_ROTOR_FIELDS = tuple(_OPTIONAL_TAGS)
"""Fields of `Rotor` that are 0 if not stated, with `inertia`, which is that of the rotor's link."""
MOTOR_CONSTANT_TAGS = ("motorConstant", *_DEFAULTED_TAGS.values(), *_OPTIONAL_TAGS.values())
"""Names of the tags used."""
_SPINNING_JOINT_KINDS = ("continuous", "revolute")
_MAX_GYRATION_SHARE = 0.75
"""Largest radius of gyration over the radius of a propeller. A rod has 0.58, tips are light, and
the radius computed from the thrust is accurate to a fifth."""
_MIN_GYRATION_SHARE = 0.04
"""The smallest one; the bell of a motor alone has 0.1."""


# kDefault... in rotors_gazebo_plugins' gazebo_motor_model.h and common.h (the slowdown), the same
# in PX4's gazebo_motor_model.h and as members in gz-sim's MulticopterMotorModel.cc.
GAZEBO_DEFAULTS = {
    "moment_constant": 0.016,
    "time_constant_up": 1.0 / 80.0,
    "time_constant_down": 1.0 / 40.0,
    "max_rot_velocity": 838.0,
    "velocity_slowdown": 10.0,
}
"""Defaults by field of `Rotor`."""


def read_constants(
    tags: XmlBlock, otherwise: Mapping[str, float], source: str, element: str, remarks: Remarks
) -> dict[str, float]:
    """Return the constants in a plugin by field of `Rotor`, with defaults for omitted ones.

    The inertia is only included if it is stated.

    Args:
        tags: of the plugin.
        otherwise: the defaults.
        source: of the defaults, for the remark.
        element: for the remark.
        remarks: receives a remark on omitted constants.

    Raises:
        WorkbenchError: for a constant that is not positive, or a negative coefficient.
    """
    found, missing = dict(otherwise), []
    for name, tag in _DEFAULTED_TAGS.items():
        if tags.has(tag):
            found[name] = tags.positive(tag)
        elif name != "velocity_slowdown":  # used for the picture only
            missing.append(f"{tag} {otherwise[name]:g}")
    for name, tag in _OPTIONAL_TAGS.items():
        # 0 if omitted: Gazebo's default drag of 1e-4 is too much for a small drone
        if tags.has(tag):
            found[name] = tags.non_negative(tag, 0.0)
    note_assumed(missing, source, tags.file, element, remarks)
    return found


def note_assumed(
    missing: list[str], source: str, file: Path, element: str, remarks: Remarks
) -> None:
    """Add a remark on omitted constants, each given by name and assumed value."""
    if missing:
        remarks.add("assumed", file, element, f"{', '.join(missing)}: not given, {source}")


def make_rotor(
    model: Model,
    joint: Joint,
    mount: Mount,
    direction: int,
    motor_constant: float,
    constants: Mapping[str, float],
    tags: XmlBlock,
    remarks: Remarks,
) -> Rotor:
    """Return the rotor of a plugin, with the inertia of its link if none is stated.

    Args:
        model: that declares the plugin.
        joint: of the rotor; its child turns with it.
        mount: position and axis of the rotor.
        direction: +1 turns counter-clockwise seen from the tip of the axis, -1 clockwise.
        motor_constant: thrust over squared speed [N·s²].
        constants: the others.
        tags: of the plugin.
        remarks: receives remarks on assumptions.
    """
    if "inertia" not in constants:
        inertia = spin_inertia(
            model,
            joint,
            motor_constant=motor_constant,
            slowdown=constants["velocity_slowdown"],
            file=tags.file,
            remarks=remarks,
        )
        constants = {**constants, "inertia": inertia}
    return Rotor(
        name=joint.name,
        joint=joint.name,
        link=joint.child,
        p_BR=mount.p_BR,
        axis_B=mount.axis_B,
        direction=direction,
        motor_constant=motor_constant,
        **constants,
    )


def spin_inertia(
    model: Model,
    joint: Joint,
    *,
    motor_constant: float,
    slowdown: float,
    file: Path,
    remarks: Remarks,
) -> float:
    """Return the inertia about the axis of a joint of all links that turn with it [kg·m²].

    It is 0 for a joint that does not turn, as its links may be a motor and its mount.

    RotorS and PX4 let rotors turn slower in the simulation, and state an inertia larger by the same
    factor, so that the angular momentum is correct (`rotor_velocity_slowdown_sim` in RotorS'
    multirotor_base.xacro). If the stated inertia is impossible for a propeller of this mass and
    size, but possible when divided by that factor, it is divided.

    Args:
        model: with the joint.
        joint: of the rotor.
        motor_constant: of the rotor, which determines its size [N·s²].
        slowdown: factor by which the joint turns slower in the description, 1 for none.
        file: for remarks.
        remarks: receives a remark if the inertia is divided or implausible.
    """
    if joint.kind not in _SPINNING_JOINT_KINDS:
        return 0.0
    names = links_below(model, joint.child)
    mass, inertia = 0.0, 0.0
    for link in model.links:
        if link.name in names and link.inertial:
            mass += link.inertial.mass
            inertia += _link_inertia_about(joint, link)
    if not (mass > 0.0 and 0.0 < inertia < math.inf):  # a frame, or rejected later
        return 0.0
    squared = mass * (propeller_diameter(motor_constant) / 2.0) ** 2
    least, widest = _MIN_GYRATION_SHARE**2 * squared, _MAX_GYRATION_SHARE**2 * squared
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


def _link_inertia_about(joint: Joint, link: Link) -> float:
    """Return the inertia of a link about the axis of a joint [kg·m²]."""
    assert link.inertial
    X_MI = link.X_ML @ link.inertial.X_LI
    axis_M = joint.X_MJ.rotation().matrix() @ np.array(joint.axis_J)
    axis_I = X_MI.rotation().matrix().T @ axis_M
    own = axis_I @ link.inertial.matrix @ axis_I
    arm = np.cross(X_MI.translation() - joint.X_MJ.translation(), axis_M)
    return float(own + link.inertial.mass * arm @ arm)


def total_mass(model: Model) -> float:
    """Return the mass of all links [kg].

    Raises:
        WorkbenchError: if there is none.
    """
    mass = sum(link.inertial.mass for link in model.links if link.inertial)
    if not mass > 0.0:
        raise WorkbenchError(
            f"{model.source}: no link has a mass, and the rotors' constants depend on it: give the "
            "base link an inertial with a mass"
        )
    return mass
