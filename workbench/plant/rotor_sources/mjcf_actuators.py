"""Read rotors from MuJoCo's actuators: motors with a force and a moment at a site."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import listed, shortened
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import DeclaredActuator, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import GAZEBO, note_assumed, total_mass
from workbench.plant.rotor_sources.mount import body_pose, triple
from workbench.plant.rotor_sources.plugins import ASSUMED, THRUST_TO_WEIGHT
from workbench.plant.rotor_sources.tags import LARGEST, SMALLEST, refuse_crowd
from workbench.plant.rotors import Rotor

_ALONG = 1e-6
"""Moment perpendicular to the thrust, over it, above which the place of a rotor is moved [m]."""
_LEVEL = 1e-6
"""Largest share of a thrust downwards that a level rotor may have."""
_ONE_POINT = 1e-6
"""Largest distance between sites at one point [m]."""
_FEWEST = 4
"""Number of rotors of a drone."""
_NEAR_MIDDLE = 0.1
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
    placed = [_placed(model, base_link, each) for each in model.actuators]
    whole = _of_the_whole(placed)
    if whole:
        names = listed([each.actuator.name for each in whole])
        text = f"{names}: thrust and moments of the whole drone, not of rotors; not used"
        remarks.add("ignored", model.source, "actuators", text)
    rotors = [each for each in placed if each not in whole]
    refuse_crowd(model.source, len(rotors))
    return tuple(_rotor(model, each, len(rotors), remarks) for each in rotors)


@dataclass(frozen=True, eq=False)
class _Placed:
    """An actuator with its site and, over gain times control plus bias, its wrench on the body."""

    actuator: DeclaredActuator
    p_B: np.ndarray
    force_B: np.ndarray
    moment_B: np.ndarray


def _placed(model: Model, base_link: str, actuator: DeclaredActuator) -> _Placed:
    link = model.link(actuator.link)
    assert link
    X_BS = body_pose(model, base_link) @ link.X_ML @ actuator.X_LS
    R = X_BS.rotation()
    force, moment = (R.multiply(np.array(v)) for v in (actuator.force_S, actuator.moment_S))
    return _Placed(actuator, X_BS.translation(), force, moment)


def _of_the_whole(placed: Sequence[_Placed]) -> list[_Placed]:
    """Return the actuators that are no rotors.

    They are all at a point at which one only turns, or where forces have several directions; and
    a force without a moment, between others that have one.
    """
    whole = []
    for each in placed:
        here = [other for other in placed if np.linalg.norm(other.p_B - each.p_B) < _ONE_POINT]
        turns = any(not np.any(other.force_B) for other in here)
        across = any(np.any(np.cross(other.force_B, each.force_B)) for other in here)
        if turns or across or _is_of_the_middle(each, placed):
            whole.append(each)
    return whole


def _is_of_the_middle(each: _Placed, placed: Sequence[_Placed]) -> bool:
    """Return whether a force has no moment, and four or more others that have one are around it."""
    others = [o for o in placed if np.any(o.force_B) and np.any(o.moment_B)]
    if np.any(each.moment_B) or len(others) < _FEWEST:
        return False
    middle = np.mean([other.p_B for other in others], axis=0)
    reach = max(float(np.linalg.norm((other.p_B - middle)[:2])) for other in others)
    return float(np.linalg.norm((each.p_B - middle)[:2])) < _NEAR_MIDDLE * reach


def _rotor(model: Model, placed: _Placed, count: int, remarks: Remarks) -> Rotor:
    """Return the rotor of one actuator."""
    actuator = placed.actuator
    element = f"actuator '{shortened(actuator.name)}'"
    force = float(np.linalg.norm(placed.force_B))
    axis = placed.force_B / force
    about = float(placed.moment_B @ axis) / force
    across = placed.moment_B / force - about * axis
    p_B = placed.p_B
    if np.linalg.norm(across) > _ALONG:
        p_B = p_B + np.cross(axis, across)
        text = "its moment is not along its thrust; its place is moved to where thrust has both"
        remarks.add("assumed", model.source, element, text)
    least, most = actuator.least, actuator.most
    if most <= 0.0 or (least < 0.0 and axis[2] < -_LEVEL):  # its other end is the one that lifts
        axis, least, most = -axis, -most, -least
    if axis[2] < -_LEVEL:
        raise WorkbenchError(
            f"{model.source}: {element} only pushes down: give it a ctrlrange with a positive end, "
            "or turn its site"
        )
    assumed = []
    speed = ASSUMED["max_rot_velocity"]
    if math.isinf(most):
        thrust = THRUST_TO_WEIGHT * total_mass(model) * GRAVITY / count
        assumed.append(f"largest thrust {thrust:.3g} N, of all {THRUST_TO_WEIGHT:g} times weight")
    else:
        thrust = most * force
    if not SMALLEST <= thrust / speed**2 <= LARGEST:
        raise WorkbenchError(
            f"{model.source}: {element} gives at most {thrust:g} N: give it a ctrlrange with a "
            "positive end, and a gear that makes it a thrust in N"
        )
    if least > 0.0:
        assumed.append(f"thrusts down to 0 in place of {least * force:.3g} N")
    assumed.append(f"{speed:g} rad/s at the largest thrust")
    up, down = GAZEBO["time_constant_up"], GAZEBO["time_constant_down"]
    if actuator.time_constant is None:
        assumed.append(f"time constants {up:g} s up and {down:g} s down, Gazebo's")
    else:
        up = down = actuator.time_constant
    note_assumed(assumed, "MuJoCo has none", model.source, element, remarks)
    return Rotor(
        name=actuator.name,
        joint="",
        link=actuator.link,
        p_BR=triple(p_B),
        axis_B=triple(axis),
        direction=1 if about <= 0.0 else -1,
        motor_constant=thrust / speed**2,
        moment_constant=math.fabs(about),
        time_constant_up=up,
        time_constant_down=down,
        max_rot_velocity=speed,
    )
