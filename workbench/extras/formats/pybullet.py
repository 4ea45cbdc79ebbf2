"""Read rotors from gym-pybullet-drones' `<properties>` tag and propN_link links."""

import math
import re

from workbench.common.errors import WorkbenchError
from workbench.common.quantity import RPM_IN_RAD_S
from workbench.plant.formats.values import shortened_text
from workbench.plant.model import Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import GAZEBO_DEFAULTS, note_assumed, total_mass
from workbench.plant.rotor_sources.mount import mount_on_link
from workbench.plant.rotor_sources.tags import (
    MAX_MOTOR_CONSTANT,
    MIN_MOTOR_CONSTANT,
    refuse_too_many_rotors,
)
from workbench.plant.rotors import Rotor

PYBULLET_GRAVITY_M_S2 = 9.8
"""Gravity in gym-pybullet-drones [m/s²], which its thrust2weight refers to."""
_PROPELLER_LINK_PATTERN = re.compile(r"(?:.*(?:::|/))?prop([0-9]{1,4})_link", re.DOTALL)
_PYBULLET_PROPERTIES = ("kf", "km", "thrust2weight", "gnd_eff_coeff", "prop_radius", "drag_coeff_z")
_REASON_PROPERTY_UNUSED = {
    "arm": "the places of the propellers' links count",
    "max_speed_kmh": "the workbench does not enforce it",
    "drag_coeff_xy": "rotors have the drag that a sidecar gives them",
    "dw_coeff_1": "no flight has downwash",
    "dw_coeff_2": "no flight has downwash",
    "dw_coeff_3": "no flight has downwash",
}
"""Reasons why properties are not used."""
_REVERSED_MODEL = "racer"
"""Their only model with opposite turning directions (RACE in `BaseAviary._physics`)."""


def is_pybullet(model: Model) -> bool:
    """Return whether a model has gym-pybullet-drones' thrust or torque coefficient."""
    return any(key in ("kf", "km") for key, _ in model.properties)


def read_pybullet(model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return the rotors of gym-pybullet-drones' properties, by the number in their link names.

    Thrust is kf n² and torque km n² with n in RPM. At the largest speed, all rotors together lift
    thrust2weight times the weight (`BaseAviary`: MAX_RPM, `_physics`; forces act at the centres of
    mass of the links along their z). The torque on the body about z is -t0 + t1 - t2 + t3: even
    rotors turn counter-clockwise.

    Args:
        model: with the properties.
        base_link: its frame is the body frame.
        remarks: receives remarks on assumptions.

    Raises:
        WorkbenchError: for a missing or invalid coefficient.
    """
    links = _propellers(model)
    if not links:
        text = "they describe rotors, but there is no prop0_link; not used"
        remarks.add("ignored", model.source, "properties", text)
        return ()
    refuse_too_many_rotors(model.source, len(links))
    for key, written in model.properties:
        if key not in _PYBULLET_PROPERTIES:
            text = f"{_REASON_PROPERTY_UNUSED.get(key, 'not known here')}; not used"
            what = f"{shortened_text(key)}={shortened_text(written)} of properties"
            remarks.add("ignored", model.source, what, text)
    kf, km = _coefficient(model, "kf"), _coefficient(model, "km")
    motor_constant = kf / RPM_IN_RAD_S**2
    moment_constant = km / kf
    weight = total_mass(model) * PYBULLET_GRAVITY_M_S2
    max_rpm = math.sqrt(_coefficient(model, "thrust2weight") * weight / (len(links) * kf))
    max_rot_velocity = max_rpm * RPM_IN_RAD_S
    for value in (motor_constant, moment_constant, max_rot_velocity):
        if not MIN_MOTOR_CONSTANT <= value <= MAX_MOTOR_CONSTANT:
            raise WorkbenchError(
                f"{model.source}: properties kf {kf:g} and km {km:g} do not fit a rotor: give "
                "thrust [N] and torque [N m] for one turn a minute"
            )
    # The package has no rotor lag. RotorS' values are used by published Gazebo models of the
    # Crazyflie (CrazyS; Bitcraze's own model has Gazebo's defaults). The motors of a real one are
    # slower: 0.07 s (Eschmann et al. 2024, RotorPy).
    up, down = GAZEBO_DEFAULTS["time_constant_up"], GAZEBO_DEFAULTS["time_constant_down"]
    missing = [f"time constants {up:g} s up and {down:g} s down"]
    note_assumed(missing, "Gazebo's defaults", model.source, "properties", remarks)
    inflow, ground, radius = (
        _optional_property(model, name, remarks)
        for name in ("drag_coeff_z", "gnd_eff_coeff", "prop_radius")
    )
    first = -1 if model.name == _REVERSED_MODEL else 1
    rotors = []
    for index, link in enumerate(links):
        mount = mount_on_link(model, base_link, link)
        joint = model.joint_of(link.name)
        rotors.append(
            Rotor(
                name=joint.name if joint else link.name,
                joint=joint.name if joint else "",
                link=link.name,
                p_BR=mount.p_BR,
                axis_B=mount.axis_B,
                direction=-first if index % 2 else first,
                motor_constant=motor_constant,
                moment_constant=moment_constant,
                time_constant_up=up,
                time_constant_down=down,
                max_rot_velocity=max_rot_velocity,
                inflow_coefficient=inflow,
                ground_effect_coefficient=ground,
                propeller_radius=radius,
            )
        )
    return tuple(rotors)


def _propellers(model: Model) -> list[Link]:
    """Return the links of propellers, by number."""
    found = [
        (int(match[1]), link)
        for link in model.links
        if (match := _PROPELLER_LINK_PATTERN.fullmatch(link.name))
    ]
    return [link for _, link in sorted(found, key=lambda pair: pair[0])]


def _coefficient(model: Model, name: str) -> float:
    """Return a positive number in the properties."""
    text = dict(model.properties).get(name)
    if text is None:
        raise WorkbenchError(f"{model.source}: <properties> without {name}: add it")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not MIN_MOTOR_CONSTANT <= value <= MAX_MOTOR_CONSTANT:
        raise WorkbenchError(
            f"{model.source}: <properties {name}='{shortened_text(text)}'>: give it a positive "
            "number"
        )
    return value


def _optional_property(model: Model, name: str, remarks: Remarks) -> float:
    """Return an optional number in the properties, 0 if it is missing or invalid."""
    text = dict(model.properties).get(name, "0")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if 0.0 <= value <= MAX_MOTOR_CONSTANT:
        return value
    what = f"{name}={shortened_text(text)} of properties"
    remarks.add("ignored", model.source, what, "no number of 0 or more; not used")
    return 0.0
