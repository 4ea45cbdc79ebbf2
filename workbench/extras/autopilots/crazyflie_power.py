"""Power distribution of the Crazyflie firmware 2025.12: from torques to motor thrusts.

Thrusts are 65535ths of `thrust_max`; roll and pitch enter by half, yaw in full:

    m1 = thrust - roll/2 + pitch/2 - yaw   front right,  m2 = thrust - roll/2 - pitch/2 + yaw
    m3 = thrust + roll/2 - pitch/2 - yaw   back left,    m4 = thrust + roll/2 + pitch/2 + yaw

Battery compensation converts a thrust to the motor's voltage, thrust = a0 + a1 V + a2 V² + a3 V³,
and that to PWM = 65535 V / vbat. For larger motors the curve is scaled by thrust_max / 0.12 N. If a
PWM exceeds 65535, its excess is subtracted from all four; none is below 0.

Source: bitcraze/crazyflie-firmware, power_distribution_quadrotor.c, platform_defaults_cf2.h.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Vector3, Wrench
from workbench.control.guidance import Gains, KnownRotor
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import wrench_matrix
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

Quadruple = tuple[float, float, float, float]
"""A number for each motor."""

FULL_MOTOR_SIGNAL = 65535.0
"""Full scale of a motor."""
HOVER_MOTOR_SIGNAL = 36000.0
"""Motor signal of a hovering Crazyflie."""
MAX_CRAZYFLIE_MASS_KG = 0.1
"""A vehicle lighter than this uses the firmware's own values [kg]."""
MAX_CRAZYFLIE_THRUST_N = 0.12
"""Thrust of a Crazyflie's motor at full scale, for which the curve below is valid [N]."""
VOLTAGE_THRUST_CURVE = (
    -0.02476537915958403,
    0.06523793527519485,
    -0.026792504967750107,
    0.006776789303971145,
)
"""Coefficients of a motor's thrust over its voltage, propellers 2.1+ [N, N/V, N/V², N/V³]."""
VOLTAGE_NEWTON_STEPS = 16
"""Steps of Newton's method for the voltage of a thrust; the curve is monotonic."""
CRAZYFLIE_MOTORS = ((True, True), (False, True), (False, False), (True, False))
"""For each motor, m1 to m4: whether it is at the front, and whether it is on the right."""
MOTOR_EFFECTS = (
    *(f"m{motor}_{part}" for motor in (1, 2, 3, 4) for part in ("f", "x", "y", "z")),
    "turns",
)
"""Names of the numbers of `motor_effects`."""


def motor_effects(rotors: Sequence[KnownRotor]) -> list[float]:
    """Return the effects of each motor's thrust, see `KnownRotor`, and the turning direction of m1.

    `turns` is 1 if the motor at the front right turns counter-clockwise, as on the Crazyflie.

    Raises:
        ValueError: if there are not four rotors in X.
    """
    corners = {(rotor.m_y < 0.0, rotor.m_x < 0.0): rotor for rotor in rotors}
    if len(rotors) != 4 or len(corners) != 4:
        raise ValueError("the Crazyflie's power distribution is for four rotors in X")
    motors = [corners[place] for place in CRAZYFLIE_MOTORS]
    effects = [number for each in motors for number in (each.force, each.m_x, each.m_y, each.m_z)]
    return [*effects, 1.0 if motors[0].m_z < 0.0 else -1.0]


class LargerMotors(NamedTuple):
    """Motors of a vehicle's size, see `larger_motors`.

    Attributes:
        thrust_max: thrust of each at full scale [N].
        roll, pitch, yaw: angular acceleration for a torque of 1 in 65535ths [rad/s²].
    """

    thrust_max: float
    roll: float
    pitch: float
    yaw: float


def larger_motors(vehicle: Vehicle) -> LargerMotors | None:
    """Return motors with which a vehicle hovers like a Crazyflie, None for one of that size."""
    if vehicle.mass < MAX_CRAZYFLIE_MASS_KG:
        return None
    frame = thrust_frame(vehicle)
    levers = np.abs(wrench_matrix(frame.rotors, frame.p_ToTcm_T)[3:]).sum(axis=1)
    thrust_max = (
        vehicle.mass * GRAVITY / len(vehicle.rotors) * FULL_MOTOR_SIGNAL / HOVER_MOTOR_SIGNAL
    )
    x, y, z = thrust_max / FULL_MOTOR_SIGNAL * levers / np.diagonal(frame.inertia_T)
    return LargerMotors(thrust_max, 0.5 * x, 0.5 * y, z)


@register_jitable(forceinline=True)
def voltage_for_thrust(thrust: float) -> float:
    """Return the voltage of a motor for a thrust [N]."""
    a_0, a_1, a_2, a_3 = VOLTAGE_THRUST_CURVE
    v = 2.0 + 0.0 * thrust
    for _ in range(VOLTAGE_NEWTON_STEPS):
        slope = a_1 + v * (2.0 * a_2 + 3.0 * a_3 * v)
        v = v - (a_0 + v * (a_1 + v * (a_2 + v * a_3)) - thrust) / slope
    return v


@register_jitable(forceinline=True)
def thrust_at_voltage(volts: float) -> float:
    """Return the thrust of a motor at a voltage, at least 0 [N]."""
    a_0, a_1, a_2, a_3 = VOLTAGE_THRUST_CURVE
    thrust = a_0 + volts * (a_1 + volts * (a_2 + volts * a_3))
    return thrust if thrust > 0.0 else 0.0 * thrust


@register_jitable(forceinline=True)
def power_distribution(thrust: float, torque: Vector3, g: Gains, vbat: float) -> Wrench:
    """Return the wrench of the capped motors in T, F [N] and m [N·m].

    Args:
        thrust: of each motor, 65535 for g.thrust_max.
        torque: roll, pitch (nose up) and yaw, in the same unit.
        g: has thrust_max [N] and `MOTOR_EFFECTS`.
        vbat: voltage of the battery [V].
    """
    half_x, half_y, turn = 0.5 * torque[0], 0.5 * torque[1], g.turns * torque[2]
    motors = (
        thrust - half_x + half_y - turn,
        thrust - half_x - half_y + turn,
        thrust + half_x - half_y - turn,
        thrust + half_x + half_y + turn,
    )
    m1, m2, m3, m4 = capped_thrusts(motors, g.thrust_max, vbat)
    return (
        g.m1_f * m1 + g.m2_f * m2 + g.m3_f * m3 + g.m4_f * m4,
        g.m1_x * m1 + g.m2_x * m2 + g.m3_x * m3 + g.m4_x * m4,
        g.m1_y * m1 + g.m2_y * m2 + g.m3_y * m3 + g.m4_y * m4,
        g.m1_z * m1 + g.m2_z * m2 + g.m3_z * m3 + g.m4_z * m4,
    )


@register_jitable(forceinline=True)
def capped_thrusts(motors: Quadruple, thrust_max: float, vbat: float) -> Quadruple:
    """Return the thrusts [N] of four motors whose PWM has been capped.

    Args:
        motors: wanted, 65535 for `thrust_max`.
        thrust_max: [N].
        vbat: voltage of the battery [V].
    """
    m1, m2, m3, m4 = motors
    share, scale, size = (
        MAX_CRAZYFLIE_THRUST_N / FULL_MOTOR_SIGNAL,
        FULL_MOTOR_SIGNAL / vbat,
        thrust_max / MAX_CRAZYFLIE_THRUST_N,
    )
    pwm_1 = scale * voltage_for_thrust(m1 * share)
    pwm_2 = scale * voltage_for_thrust(m2 * share)
    pwm_3 = scale * voltage_for_thrust(m3 * share)
    pwm_4 = scale * voltage_for_thrust(m4 * share)
    most = pwm_1 if pwm_1 > pwm_2 else pwm_2
    most = most if most > pwm_3 else pwm_3
    most = most if most > pwm_4 else pwm_4
    excess = most - FULL_MOTOR_SIGNAL if most > FULL_MOTOR_SIGNAL else 0.0 * most
    return (
        size * thrust_at_pwm(pwm_1 - excess, scale),
        size * thrust_at_pwm(pwm_2 - excess, scale),
        size * thrust_at_pwm(pwm_3 - excess, scale),
        size * thrust_at_pwm(pwm_4 - excess, scale),
    )


@register_jitable(forceinline=True)
def thrust_at_pwm(pwm: float, scale: float) -> float:
    """Return the thrust of a Crazyflie's motor at a PWM [N]; `scale` is PWM per volt."""
    return thrust_at_voltage(pwm / scale if pwm > 0.0 else 0.0 * pwm)
