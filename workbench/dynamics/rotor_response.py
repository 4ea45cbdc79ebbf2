"""Rotor lag: how a rotor's speed follows its command, as pure functions of scalars.

The speed w follows the command c with dw/dt = (c - w) / time constant, faster up than down, as
in Gazebo's motor model; thrust is motor_constant w (w + linear_speed), see `plant.rotors`. The
two time constants are blended near c = w, because a linear model of hover needs one rate: with the
error e = c - w,

    dw/dt = e s / up + e (1 - s) / down,  s = (1 + (e² / (e² + BLEND²))^(3/2) sign e) / 2

At e = 0 the rate is the mean of both, to third order. At an error of ten times `BLEND_SPEED_RAD_S`,
less than a percent of it follows the other time constant.
"""

from workbench.common.jitable import register_jitable

BLEND_SPEED_RAD_S = 3.0
"""Less than half a percent of usual hover speeds [rad/s]."""


@register_jitable(forceinline=True)
def split_error(error: float) -> tuple[float, float]:
    """Return the parts of an error with the time constants up and down."""
    side = error / (error * error + BLEND_SPEED_RAD_S * BLEND_SPEED_RAD_S) ** 0.5
    up = 0.5 * error * (1.0 + side * side * side)
    return up, error - up


@register_jitable
def speed_command(thrust: float, motor_constant: float, half: float, motors: float) -> float:
    """Return the speed [rad/s] for a thrust [N].

    It is the non-negative root of motor_constant w (w + 2 half) = thrust.

    Args:
        thrust: wanted [N].
        motor_constant: see `plant.rotors.Rotor` [N·s²].
        half: of the rotor's `linear_speed` [rad/s].
        motors: 0 is off, see `Guidance`.
    """
    return motors * ((half * half + thrust / motor_constant) ** 0.5 - half)
