"""Rotors of a YAML file beside a description, for descriptions that carry none."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import spin_inertia
from workbench.plant.rotor_sources.mount import Mount, Triple, body_pose, mount_on_joint, triple
from workbench.plant.rotor_sources.names import find_joint, find_link
from workbench.plant.rotor_sources.sidecar_file import Entry, Place, load_sidecar
from workbench.plant.rotor_sources.tags import LARGEST, SMALLEST, TURNS
from workbench.plant.rotors import Rotor


def read_sidecar(path: Path, model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return the rotors of a sidecar, in its order.

    Args:
        path: the YAML file; `sidecar_file` has its schema.
        model: whose links and joints it names.
        base_link: whose frame is the body frame, and where rotors without a link sit.
        remarks: where to note what was read differently.

    Raises:
        WorkbenchError: with file and line, for what is missing, unknown or cannot be.
    """
    rotors: list[Rotor] = []
    for place, entry in load_sidecar(path):
        rotor = _rotor(place, entry, model, base_link, remarks)
        if any(rotor.name == other.name for other in rotors):
            raise WorkbenchError(f"{place.where()}: two rotors are '{rotor.name}': rename one")
        rotors.append(rotor)
    return tuple(rotors)


def _rotor(place: Place, entry: Entry, model: Model, base_link: str, remarks: Remarks) -> Rotor:
    """Return one rotor."""
    joint, link = _joint_and_link(place, entry, model, base_link)
    turn = TURNS.get(entry.direction or "")
    if turn is None:
        raise place.fault("direction", "must be cw or ccw")
    if joint:
        mount = mount_on_joint(model, base_link, joint, link, place.file.path, remarks)
    else:
        mount = _free_mount(place, entry, model, base_link, link)
    motor_constant = _positive(place, "motor_constant", entry.motor_constant)
    if entry.inertia is not None:
        inertia = _not_negative(place, "inertia", entry.inertia)
    elif joint:
        inertia = spin_inertia(
            model,
            joint,
            motor_constant=motor_constant,
            slowdown=1.0,
            file=place.file.path,
            remarks=remarks,
        )
    else:
        inertia = 0.0
    return Rotor(
        name=entry.name or (joint.name if joint else f"rotor_{place.index}"),
        joint=joint.name if joint else "",
        link=link.name,
        p_BR=mount.p_BR,
        axis_B=mount.axis_B,
        direction=turn * mount.sense,
        motor_constant=motor_constant,
        moment_constant=_positive(place, "moment_constant", entry.moment_constant),
        time_constant_up=_positive(place, "time_constant_up", entry.time_constant_up),
        time_constant_down=_positive(place, "time_constant_down", entry.time_constant_down),
        max_rot_velocity=_positive(place, "max_rot_velocity", entry.max_rot_velocity),
        rotor_drag_coefficient=_not_negative(
            place, "rotor_drag_coefficient", entry.rotor_drag_coefficient
        ),
        rolling_moment_coefficient=_not_negative(
            place, "rolling_moment_coefficient", entry.rolling_moment_coefficient
        ),
        inertia=inertia,
        inflow_coefficient=_not_negative(place, "inflow_coefficient", entry.inflow_coefficient),
        ground_effect_coefficient=_not_negative(
            place, "ground_effect_coefficient", entry.ground_effect_coefficient
        ),
        propeller_radius=_not_negative(place, "propeller_radius", entry.propeller_radius),
        linear_motor_constant=_not_negative(
            place, "linear_motor_constant", entry.linear_motor_constant
        ),
    )


def _joint_and_link(
    place: Place, entry: Entry, model: Model, base_link: str
) -> tuple[Joint | None, Link]:
    """Return the joint that a rotor names, if it does, and the link that it sits on."""
    if entry.joint is None:
        name = base_link if entry.link is None else entry.link
        return None, find_link(model, name, place.where("link"))
    joint = find_joint(model, entry.joint, place.where("joint"))
    for key, value in (("position", entry.position), ("axis", entry.axis)):
        if value is not None:
            raise place.fault(key, f"stands beside the joint '{joint.name}': leave out one")
    link = find_link(model, joint.child, place.where("joint"))
    if entry.link is not None and entry.link != link.name:
        raise place.fault("link", f"should be '{link.name}', which '{joint.name}' turns")
    return joint, link


def _free_mount(place: Place, entry: Entry, model: Model, base_link: str, link: Link) -> Mount:
    """Return the mount of a rotor that is given by position and axis in a link's frame."""
    X_BL = body_pose(model, base_link) @ link.X_ML
    p_LR = _vector(place, "position", entry.position)
    axis_L = _vector(place, "axis", (0.0, 0.0, 1.0) if entry.axis is None else entry.axis)
    length = math.hypot(*axis_L)
    if length < 1e-9:
        raise place.fault("axis", "has no length: give it a direction")
    axis_B = X_BL.rotation().multiply(np.array(axis_L) / length)
    return Mount(triple(X_BL.multiply(np.array(p_LR))), triple(axis_B), 1)


def _vector(place: Place, key: str, value: Sequence[float] | None) -> Triple:
    if value is None:
        raise place.fault(key, "is missing: give it, or a joint")
    if len(value) != 3 or not all(abs(number) <= LARGEST for number in value):
        raise place.fault(key, "should be three numbers: x, y, z")
    x, y, z = (float(number) for number in value)
    return (x, y, z)


def _positive(place: Place, key: str, value: float | None) -> float:
    if value is None:
        raise place.fault(key, "is missing: give it here or under 'defaults:'")
    if not SMALLEST <= value <= LARGEST:
        raise place.fault(key, "should be a positive number")
    return float(value)


def _not_negative(place: Place, key: str, value: float) -> float:
    if not 0.0 <= value <= LARGEST:
        raise place.fault(key, "should be a positive number, or 0")
    return float(value)
