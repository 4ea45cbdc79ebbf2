"""Equations of one rotor, and of the voltage that drives it; see `systems.rotors`.

They take floats and AutoDiffXd.
"""

from collections.abc import Sequence
from typing import Any

from workbench.dynamics.rotor_response import split_error
from workbench.plant.rotors import Rotor

MOST_GROUND_EFFECT = 4.0 / 15.0
"""Largest share of thrust by ground effect."""
LEAST_VOLTAGE = 0.1
"""Share of the full voltage below which sag is not compensated."""
TINY = 1e-30
"""Added to a radicand, because a root has no derivative at 0."""


def turning_shares(given: Sequence[Any]) -> list[Any]:
    """Return the shares of their thrust that rotors give while they turn."""
    return [share if share > 0.0 else 1.0 for share in given]


def static_thrusts(
    rotors: Sequence[Rotor], shares: Sequence[Any], speeds: Sequence[Any]
) -> list[Any]:
    """Return the thrusts of rotors at rest, far from the ground [N]."""
    return [
        share * rotor.motor_constant * w * (w + rotor.linear_speed)
        for rotor, share, w in zip(rotors, shares, speeds, strict=True)
    ]


def loaded_voltage(supply: Sequence[Any], statics: Sequence[Any]) -> Any:
    """Return the voltage under the load of static thrusts, over that of the full battery."""
    open_circuit, drop, *_ = supply
    voltage = open_circuit - drop * sum(T * (T + TINY) ** 0.5 for T in statics)
    return voltage if voltage > 0.0 else 0.0 * voltage


def within(command: Any, rotor: Rotor) -> Any:
    """Return a command limited to the speeds of a rotor [rad/s]."""
    if command < 0.0:
        return 0.0 * command
    return command if command < rotor.max_rot_velocity else rotor.max_rot_velocity


def speed_slope(rotor: Rotor, command: Any, speed: Any) -> Any:
    """Return dw/dt of a rotor on its way to a command [rad/s²]."""
    up, down = split_error(command - speed)
    return up / rotor.time_constant_up + down / rotor.time_constant_down


def hub_velocity(rotor: Rotor, w_B: Sequence[Any], v_B: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return the velocity of a hub, in B, from the motion of the body in B."""
    p_x, p_y, p_z = rotor.p_BR
    w_x, w_y, w_z = w_B
    v_x, v_y, v_z = v_B
    return v_x + w_y * p_z - w_z * p_y, v_y + w_z * p_x - w_x * p_z, v_z + w_x * p_y - w_y * p_x


def moving_thrust(
    rotor: Rotor,
    speed: Any,
    share: Any,
    static: Any,
    along: Any,
    R_WB: Sequence[Any],
    height: Any,
) -> Any:
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
    if rotor.inflow_coefficient:
        thrust = thrust - share * rotor.inflow_coefficient * speed * along
    if rotor.ground_effect_coefficient > 0.0:
        toward = R_WB[6:9]
        if sum(z * n for z, n in zip(toward, rotor.axis_B, strict=True)) > 0.0:
            hub = height + sum(z * p for z, p in zip(toward, rotor.p_BR, strict=True))
            near = rotor.ground_effect_coefficient * (rotor.propeller_radius / 4.0) ** 2
            least = near / MOST_GROUND_EFFECT
            thrust = thrust + static * (near / hub**2 if hub**2 > least else MOST_GROUND_EFFECT)
    return thrust
