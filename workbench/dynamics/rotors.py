"""Equations of one rotor, and of the voltage that drives it; see `systems.rotors`.

They take floats, AutoDiffXd, and what numba makes of them. A rotor is a `plant.rotors.Rotor`, or
a `RotorConstants` with the same names in compiled flights.
"""

from collections.abc import Sequence
from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers
from workbench.dynamics.rigid_body import Vector3, cross
from workbench.dynamics.rotor_response import split_error
from workbench.plant.rotors import Rotor

MAX_GROUND_EFFECT_SHARE = 4.0 / 15.0
"""Largest share of thrust by ground effect."""
MIN_SAG_VOLTAGE_SHARE = 0.1
"""Share of the full voltage below which sag is not compensated."""
RADICAND_OFFSET = 1e-30
"""Added to a radicand, because a root has no derivative at 0."""


class RotorConstants(NamedTuple):
    """The constants of a rotor that its equations use; `plant.rotors.Rotor` has their units."""

    p_BR: Numbers
    axis_B: Numbers
    direction: float
    max_rot_velocity: float
    motor_constant: float
    linear_speed: float
    moment_constant: float
    inertia: float
    time_constant_up: float
    time_constant_down: float
    rotor_drag_coefficient: float
    rolling_moment_coefficient: float
    inflow_coefficient: float
    ground_effect_coefficient: float
    propeller_radius: float


TurningRotor = Rotor | RotorConstants


@register_jitable(forceinline=True)
def turning_share(given: float) -> float:
    """Return the share of its thrust that a rotor gives while it turns.

    A stopped rotor, with a share of 0, has its full thrust while it runs down.
    """
    return given if given > 0.0 else 1.0


@register_jitable(forceinline=True)
def static_thrust(rotor: TurningRotor, share: float, speed: float) -> float:
    """Return the thrust of a rotor at rest, far from the ground [N]."""
    return share * rotor.motor_constant * speed * (speed + rotor.linear_speed)


def static_thrusts(
    rotors: Sequence[Rotor], shares: Sequence[float], speeds: Sequence[float]
) -> list[float]:
    """Return the thrusts of rotors at rest, far from the ground (n) [N]."""
    return [static_thrust(*each) for each in zip(rotors, shares, speeds, strict=True)]


@register_jitable(forceinline=True)
def power_share(thrust: float) -> float:
    """Return a static thrust [N] to the 3/2: it is proportional to a rotor's power [N^3/2]."""
    return thrust * (thrust + RADICAND_OFFSET) ** 0.5


@register_jitable(forceinline=True)
def loaded_voltage(open_circuit: float, drop: float, power: float) -> float:
    """Return the voltage under load, over that of the full battery without load.

    Args:
        open_circuit: voltage without load.
        drop: of it per power [N^-3/2].
        power: sum of `power_share` [N^3/2].
    """
    voltage = open_circuit - drop * power
    return voltage if voltage > 0.0 else 0.0 * voltage


@register_jitable(forceinline=True)
def compensated_share(
    voltage: float, open_circuit: float, compensation: float, known: float
) -> float:
    """Return by what commands are divided to make up for a share of the sag.

    Args:
        voltage: under load, see `loaded_voltage`.
        open_circuit: voltage without load.
        compensation: share of the sag that is compensated.
        known: voltage without load that the compensation assumes.
    """
    share = 1.0 + compensation * (voltage + (known - open_circuit) - 1.0)
    return share if share > MIN_SAG_VOLTAGE_SHARE else MIN_SAG_VOLTAGE_SHARE


@register_jitable(forceinline=True)
def within_speed_limits(command: float, rotor: TurningRotor) -> float:
    """Return a command limited to the speeds of a rotor [rad/s]."""
    command = command if command > 0.0 else 0.0 * command
    return command if command < rotor.max_rot_velocity else rotor.max_rot_velocity


@register_jitable(forceinline=True)
def speed_slope(rotor: TurningRotor, command: float, speed: float) -> float:
    """Return dw/dt of a rotor on its way to a command [rad/s²]."""
    up, down = split_error(command - speed)
    return up / rotor.time_constant_up + down / rotor.time_constant_down


@register_jitable(forceinline=True)
def hub_velocity(rotor: TurningRotor, w_B: Numbers, v_B: Numbers) -> Vector3:
    """Return the velocity of a hub, in B, from the motion of the body in B."""
    v_x, v_y, v_z = v_B
    s_x, s_y, s_z = cross(w_B, rotor.p_BR)
    return v_x + s_x, v_y + s_y, v_z + s_z


@register_jitable(forceinline=True)
def moving_thrust(
    rotor: TurningRotor,
    speed: float,
    share: float,
    static: float,
    along: float,
    R_WB: Numbers,
    height: float,
) -> float:
    """Return the thrust of a rotor near the ground and in moving air [N].

    Args:
        rotor: which.
        speed: its speed [rad/s].
        share: of its thrust that it gives.
        static: its static thrust [N].
        along: velocity of its hub in the air along its axis [m/s].
        R_WB: attitude of the body, row by row (9).
        height: of the body's origin above the ground [m].
    """
    thrust = static
    if rotor.inflow_coefficient != 0.0:
        thrust = thrust - share * rotor.inflow_coefficient * speed * along
    if rotor.ground_effect_coefficient > 0.0:
        p_x, p_y, p_z = rotor.p_BR
        n_x, n_y, n_z = rotor.axis_B
        if R_WB[6] * n_x + R_WB[7] * n_y + R_WB[8] * n_z > 0.0:
            hub = height + R_WB[6] * p_x + R_WB[7] * p_y + R_WB[8] * p_z
            near = rotor.ground_effect_coefficient * (0.25 * rotor.propeller_radius) ** 2
            square = hub * hub
            far = square > near / MAX_GROUND_EFFECT_SHARE
            thrust = thrust + static * (near / square if far else MAX_GROUND_EFFECT_SHARE)
    return thrust


@register_jitable(forceinline=True)
def rotor_load(
    rotor: TurningRotor,
    speed: float,
    slope: float,
    share: float,
    static: float,
    w_B: Numbers,
    v_B: Numbers,
    R_WB: Numbers,
    height: float,
) -> tuple[Vector3, Vector3, Vector3]:
    """Return force [N], moment about the body's origin [N·m] and angular momentum, in B.

    The moment does not include the gyroscopic one, -w_WB x angular momentum [N·m·s].

    Args:
        rotor: which.
        speed: its speed [rad/s].
        slope: of its speed [rad/s²].
        share: of its thrust that it gives.
        static: its static thrust [N].
        w_B: angular velocity of the body in B (3) [rad/s].
        v_B: velocity of its origin in the air, in B (3) [m/s].
        R_WB: its attitude, row by row (9).
        height: of its origin above the ground [m].
    """
    p_x, p_y, p_z = rotor.p_BR
    n_x, n_y, n_z = rotor.axis_B
    v_x, v_y, v_z = hub_velocity(rotor, w_B, v_B)
    u = v_x * n_x + v_y * n_y + v_z * n_z
    thrust = moving_thrust(rotor, speed, share, static, u, R_WB, height)
    turned, size = speed * rotor.direction * rotor.inertia, abs(speed)
    torque = rotor.direction * (rotor.moment_constant * static + rotor.inertia * slope)
    drag = size * rotor.rotor_drag_coefficient
    roll = size * rotor.rolling_moment_coefficient
    # thrust is along the axis, drag opposes the rest of the velocity
    thrust, torque = thrust + drag * u, torque - roll * u
    f_x = thrust * n_x - drag * v_x
    f_y = thrust * n_y - drag * v_y
    f_z = thrust * n_z - drag * v_z
    moment = (
        p_y * f_z - p_z * f_y - torque * n_x - roll * v_x,
        p_z * f_x - p_x * f_z - torque * n_y - roll * v_y,
        p_x * f_y - p_y * f_x - torque * n_z - roll * v_z,
    )
    return (f_x, f_y, f_z), moment, (turned * n_x, turned * n_y, turned * n_z)
