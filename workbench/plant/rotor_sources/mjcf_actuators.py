"""Read rotors from MuJoCo's actuators: motors with a force and a moment at a site."""

import math

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import DeclaredActuator, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import GAZEBO, note_assumed, total_mass
from workbench.plant.rotor_sources.mount import body_pose, triple
from workbench.plant.rotor_sources.plugins import ASSUMED, THRUST_TO_WEIGHT
from workbench.plant.rotor_sources.tags import LARGEST, SMALLEST, refuse_crowd
from workbench.plant.rotors import Rotor

_ALONG = 1e-6
"""Share of the thrust above which a moment perpendicular to it gets a remark."""


def read_mjcf_actuators(model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return a rotor for each actuator with a force at a site, in file order.

    The control is a force: thrust is the first half of the gear times the control, and the moment
    about it the second half. MuJoCo has no rotor speeds, so the speed at the largest thrust is
    assumed; thrusts and moments do not depend on it. The filter of an actuator is a lag of thrust,
    which near hover equals that of speed.

    If an actuator has only a moment, the actuators are thrust and moments of the whole drone, as in
    MuJoCo menagerie's Crazyflie, and state nothing about rotors.

    Args:
        model: with the actuators.
        base_link: its frame is the body frame.
        remarks: receives remarks on assumptions.

    Raises:
        WorkbenchError: for a control without a positive limit, or an implausible force.
    """
    whole = [each for each in model.actuators if not np.linalg.norm(each.force_S) > 0.0]
    if whole:
        text = (
            f"'{shortened(whole[0].name)}' turns its site and does not push it: thrust and "
            "moments are of the whole drone, not of rotors; not used"
        )
        remarks.add("ignored", model.source, "actuators", text)
        return ()
    refuse_crowd(model.source, len(model.actuators))
    return tuple(_rotor(model, base_link, each, remarks) for each in model.actuators)


def _rotor(model: Model, base_link: str, actuator: DeclaredActuator, remarks: Remarks) -> Rotor:
    """Return the rotor of one actuator."""
    link = model.link(actuator.link)
    assert link
    element = f"actuator '{shortened(actuator.name)}'"
    force = float(np.linalg.norm(actuator.force_S))
    axis_S = np.array(actuator.force_S) / force
    moment = np.array(actuator.moment_S)
    about = float(moment @ axis_S)
    if np.linalg.norm(moment - about * axis_S) > _ALONG * force:
        text = "its moment is not along its thrust; the part across is not used"
        remarks.add("ignored", model.source, element, text)
    assumed = []
    speed = ASSUMED["max_rot_velocity"]
    if actuator.most is None:
        thrust = THRUST_TO_WEIGHT * total_mass(model) * GRAVITY / len(model.actuators)
        assumed.append(f"largest thrust {thrust:.3g} N, of all {THRUST_TO_WEIGHT:g} times weight")
    else:
        thrust = actuator.most * force
    if not SMALLEST <= thrust / speed**2 <= LARGEST:
        raise WorkbenchError(
            f"{model.source}: {element} gives at most {thrust:g} N: give it a ctrlrange with a "
            "positive end, and a gear that makes it a thrust in N"
        )
    assumed.append(f"{speed:g} rad/s at the largest thrust")
    up, down = GAZEBO["time_constant_up"], GAZEBO["time_constant_down"]
    if actuator.time_constant is None:
        assumed.append(f"time constants {up:g} s up and {down:g} s down, Gazebo's")
    else:
        up = down = actuator.time_constant
    note_assumed(assumed, "MuJoCo has none", model.source, element, remarks)
    X_BS = body_pose(model, base_link) @ link.X_ML @ actuator.X_LS
    return Rotor(
        name=actuator.name,
        joint="",
        link=link.name,
        p_BR=triple(X_BS.translation()),
        axis_B=triple(X_BS.rotation().multiply(axis_S)),
        direction=1 if about <= 0.0 else -1,
        motor_constant=thrust / speed**2,
        moment_constant=math.fabs(about) / force,
        time_constant_up=up,
        time_constant_down=down,
        max_rot_velocity=speed,
    )
