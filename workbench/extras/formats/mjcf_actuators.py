"""Read rotors from MuJoCo's actuators: motors with a force and a moment at a site."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import float_triple
from workbench.plant.formats.values import listed_names, shortened_text
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import DeclaredActuator, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import GAZEBO_DEFAULTS, note_assumed, total_mass
from workbench.plant.rotor_sources.mount import body_pose
from workbench.plant.rotor_sources.plugins import ASSUMED_CONSTANTS, ASSUMED_THRUST_TO_WEIGHT
from workbench.plant.rotor_sources.tags import (
    MAX_MOTOR_CONSTANT,
    MIN_MOTOR_CONSTANT,
    refuse_too_many_rotors,
)
from workbench.plant.rotors import Rotor

_MIN_ROTOR_SHIFT_M = 1e-6
"""Moment perpendicular to the thrust, over it, above which the place of a rotor is moved [m]."""
_LEVEL_ROTOR_TOLERANCE = 1e-6
"""Largest share of a thrust downwards that a level rotor may have."""
_SAME_POINT_M = 1e-6
"""Largest distance between sites at one point [m]."""
_MIN_ROTORS = 4
"""Number of rotors of a drone."""
_CENTRE_DISTANCE_SHARE = 0.1
"""Distance from the middle of the rotors below which a thrust is that of the whole drone, over the
distance of the farthest rotor."""


def read_mjcf_actuators(model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return a rotor for each actuator that pushes a site, in MuJoCo's order.

    Gain times control plus bias is a force: thrust is the first half of the gear times it, and the
    moment about it the second half. MuJoCo has no rotor speeds, so the speed at the largest thrust
    is assumed; thrusts and moments do not depend on it. The filter of an actuator is a lag of
    thrust, which near hover equals that of speed.

    Actuators that together are the thrust and moments of the whole drone, as in MuJoCo menagerie's
    Crazyflie, are no rotors.

    Args:
        model: with the actuators.
        base_link: its frame is the body frame.
        remarks: receives remarks on assumptions.

    Raises:
        WorkbenchError: for an actuator that only pushes down, or an implausible force.
    """
    placed = [_placed_actuator(model, base_link, each) for each in model.actuators]
    whole = _whole_drone_actuators(placed)
    if whole:
        names = listed_names([each.actuator.name for each in whole])
        text = f"{names}: thrust and moments of the whole drone, not of rotors; not used"
        remarks.add("ignored", model.source, "actuators", text)
    rotors = [each for each in placed if each not in whole]
    refuse_too_many_rotors(model.source, len(rotors))
    return tuple(_rotor_of_actuator(model, each, len(rotors), remarks) for each in rotors)


@dataclass(frozen=True, eq=False)
class _PlacedActuator:
    """An actuator with its site and, over gain times control plus bias, its wrench on the body."""

    actuator: DeclaredActuator
    p_B: np.ndarray
    force_B: np.ndarray
    moment_B: np.ndarray


def _placed_actuator(model: Model, base_link: str, actuator: DeclaredActuator) -> _PlacedActuator:
    link = model.link(actuator.link)
    assert link
    X_BS = body_pose(model, base_link) @ link.X_ML @ actuator.X_LS
    R = X_BS.rotation()
    force, moment = (R.multiply(np.array(v)) for v in (actuator.force_S, actuator.moment_S))
    return _PlacedActuator(actuator, X_BS.translation(), force, moment)


def _whole_drone_actuators(placed: Sequence[_PlacedActuator]) -> list[_PlacedActuator]:
    """Return the actuators that are no rotors.

    They are all at a point at which one only turns, or where forces have several directions; and
    a force without a moment, between others that have one.
    """
    whole = []
    for each in placed:
        here = [other for other in placed if np.linalg.norm(other.p_B - each.p_B) < _SAME_POINT_M]
        turns = any(not np.any(other.force_B) for other in here)
        across = any(np.any(np.cross(other.force_B, each.force_B)) for other in here)
        if turns or across or _is_of_the_middle(each, placed):
            whole.append(each)
    return whole


def _is_of_the_middle(each: _PlacedActuator, placed: Sequence[_PlacedActuator]) -> bool:
    """Return whether a force has no moment, and four or more others that have one are around it."""
    others = [o for o in placed if np.any(o.force_B) and np.any(o.moment_B)]
    if np.any(each.moment_B) or len(others) < _MIN_ROTORS:
        return False
    middle = np.mean([other.p_B for other in others], axis=0)
    reach = max(float(np.linalg.norm((other.p_B - middle)[:2])) for other in others)
    return float(np.linalg.norm((each.p_B - middle)[:2])) < _CENTRE_DISTANCE_SHARE * reach


def _rotor_of_actuator(
    model: Model, placed: _PlacedActuator, count: int, remarks: Remarks
) -> Rotor:
    """Return the rotor of one actuator."""
    actuator = placed.actuator
    element = f"actuator '{shortened_text(actuator.name)}'"
    force = float(np.linalg.norm(placed.force_B))
    axis = placed.force_B / force
    about = float(placed.moment_B @ axis) / force
    across = placed.moment_B / force - about * axis
    p_B = placed.p_B
    if np.linalg.norm(across) > _MIN_ROTOR_SHIFT_M:
        p_B = p_B + np.cross(axis, across)
        text = "its moment is not along its thrust; its place is moved to where thrust has both"
        remarks.add("assumed", model.source, element, text)
    least, most = actuator.least, actuator.most
    if most <= 0.0 or (
        least < 0.0 and axis[2] < -_LEVEL_ROTOR_TOLERANCE
    ):  # its other end is the one that lifts
        axis, least, most = -axis, -most, -least
    if axis[2] < -_LEVEL_ROTOR_TOLERANCE:
        raise WorkbenchError(
            f"{model.source}: {element} only pushes down: give it a ctrlrange with a positive end, "
            "or turn its site"
        )
    assumed = []
    speed = ASSUMED_CONSTANTS["max_rot_velocity"]
    if math.isinf(most):
        thrust = ASSUMED_THRUST_TO_WEIGHT * total_mass(model) * GRAVITY / count
        assumed.append(
            f"largest thrust {thrust:.3g} N, of all {ASSUMED_THRUST_TO_WEIGHT:g} times weight"
        )
    else:
        thrust = most * force
    if not MIN_MOTOR_CONSTANT <= thrust / speed**2 <= MAX_MOTOR_CONSTANT:
        raise WorkbenchError(
            f"{model.source}: {element} gives at most {thrust:g} N: give it a ctrlrange with a "
            "positive end, and a gear that makes it a thrust in N"
        )
    if least > 0.0:
        assumed.append(f"thrusts down to 0 in place of {least * force:.3g} N")
    assumed.append(f"{speed:g} rad/s at the largest thrust")
    up, down = GAZEBO_DEFAULTS["time_constant_up"], GAZEBO_DEFAULTS["time_constant_down"]
    if actuator.time_constant is None:
        assumed.append(f"time constants {up:g} s up and {down:g} s down, Gazebo's")
    else:
        up = down = actuator.time_constant
    note_assumed(assumed, "MuJoCo has none", model.source, element, remarks)
    return Rotor(
        name=actuator.name,
        joint="",
        link=actuator.link,
        p_BR=float_triple(p_B),
        axis_B=float_triple(axis),
        direction=1 if about <= 0.0 else -1,
        motor_constant=thrust / speed**2,
        moment_constant=math.fabs(about),
        time_constant_up=up,
        time_constant_down=down,
        max_rot_velocity=speed,
    )
