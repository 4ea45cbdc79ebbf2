"""What a control law knows of its vehicle."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.control.guidance import KnownBody, KnownRotor, KnownVehicle
from workbench.plant.drag import drag_area, drag_rates
from workbench.plant.payload import NO_PAYLOAD, Payload, controller_model
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

CENTERED_MASS_M = 1e-3
"""A centre of mass this near the base link's origin counts as being there [m]."""


class LawConstants(NamedTuple):
    """The vehicle as the law knows it: lists for Python; compiled flights have a record like it.

    Inertia, allocation and effects are for T, the frame of upright hover, see `plant.thrust_frame`.

    Attributes:
        mass: of vehicle and known payload [kg].
        inertia: xx, xy, xz, yy, yz, zz [kg·m²].
        q_BT: orientation of T in B, w x y z.
        p_BoBcm_B: position of the centre of mass in B [m].
        drag: see `plant.drag.DragRates`.
        allocation: n rows of 4, from a wrench to thrusts; m more with tilts, to angles.
        effects: likewise, wrench per thrust and per angle.
        idle_thrusts: n [N]; with tilts m more, their least angles [rad].
        max_thrusts: n [N]; with tilts m more, their largest angles [rad].
        motor_constants: n [N·s²].
        half_linear_speeds: n halves of the rotors' `linear_speed` [rad/s].
        spin_up_time: lead of spin-up torque over drag torque in yaw [s].
        rotor_lag: time constant of the slowest rotor at hover [s].
        payload: known mass of the payload, included in the mass [kg].
    """

    mass: float
    inertia: Sequence[float]
    q_BT: Sequence[float]
    p_BoBcm_B: Sequence[float]
    drag: Sequence[float]
    allocation: Sequence[Sequence[float]]
    effects: Sequence[Sequence[float]]
    idle_thrusts: Sequence[float]
    max_thrusts: Sequence[float]
    motor_constants: Sequence[float]
    half_linear_speeds: Sequence[float]
    spin_up_time: float
    rotor_lag: float
    payload: float


def law_constants(vehicle: Vehicle, payload: Payload = NO_PAYLOAD) -> LawConstants:
    """Return a vehicle's constants, as the law knows them.

    Args:
        vehicle: without a payload.
        payload: that the law assumes, with its known mass.

    Raises:
        WorkbenchError: if no rotor speeds can hold both in hover.
    """
    area = drag_area(vehicle.mass)
    vehicle = controller_model(vehicle, payload)
    frame = thrust_frame(vehicle)
    inertia = frame.inertia_T
    lever = (
        vehicle.p_BoBcm_B if math.hypot(*vehicle.p_BoBcm_B) > CENTERED_MASS_M else (0.0, 0.0, 0.0)
    )
    max_thrusts = [rotor.max_thrust for rotor in vehicle.rotors]
    return LawConstants(
        mass=vehicle.mass,
        inertia=[*inertia[0].tolist(), *inertia[1, 1:].tolist(), float(inertia[2, 2])],
        q_BT=frame.q_BT,
        p_BoBcm_B=list(lever),
        drag=list(drag_rates(vehicle, area)),
        allocation=frame.allocation.tolist(),
        effects=frame.effects.T.tolist(),
        idle_thrusts=[*frame.idle_thrusts.tolist(), *(tilt.lower for tilt in frame.tilts)],
        max_thrusts=[*max_thrusts, *(tilt.upper for tilt in frame.tilts)],
        motor_constants=[rotor.motor_constant for rotor in vehicle.rotors],
        half_linear_speeds=[0.5 * rotor.linear_speed for rotor in vehicle.rotors],
        spin_up_time=frame.spin_up_time,
        rotor_lag=vehicle.rotor_lag,
        payload=payload.known_payload_mass,
    )


@register_jitable(forceinline=True)
def known_body(constants: LawConstants) -> KnownBody:
    """Return the body as a law's `update` gets it."""
    return KnownBody(
        constants.mass,
        constants.inertia,
        constants.drag[2],
        constants.rotor_lag,
        constants.spin_up_time,
        constants.payload,
    )


def known_vehicle(constants: LawConstants) -> KnownVehicle:
    """Return the vehicle as a law's `design` gets it."""
    n = len(constants.motor_constants)
    numbers = zip(
        constants.effects[:n],
        constants.idle_thrusts[:n],
        constants.max_thrusts[:n],
        constants.motor_constants,
        constants.half_linear_speeds,
        strict=True,
    )
    rotors = tuple(
        KnownRotor(f, m_x, m_y, m_z, idle, most, constant, 2.0 * half)
        for (f, m_x, m_y, m_z), idle, most, constant, half in numbers
    )
    return KnownVehicle(*known_body(constants), rotors)
