"""Rotor lag: how a rotor's speed follows its command, as pure functions of scalars.

The speed w follows the command u with dw/dt = (u - w) / time constant, faster up than down, as
in Gazebo's motor model; thrust is motor_constant w (w + linear_speed), see `plant.rotors`. The
two time constants are blended near u = w, because a linear model of hover needs one rate: with the
error e = u - w,

    dw/dt = e s / up + e (1 - s) / down,  s = (1 + (e² / (e² + BLEND²))^(3/2) sign e) / 2

At e = 0 the rate is the mean of both, to third order. At an error of ten times `BLEND`, less than a
percent of it follows the other time constant.
"""

import math
from collections.abc import Sequence

from workbench.common.jitable import Scalar, register_jitable
from workbench.plant.rotors import Rotor

BLEND = 3.0
"""Less than half a percent of usual hover speeds [rad/s]."""
CONSTANTS = 7
"""Length of `rotor_constants`."""


def rotor_constants(rotor: Rotor, step: float) -> list[float]:
    """Return the constants of a rotor's lag over a physics step [s], for `step_rotor`.

    They are the largest speed [rad/s]; then, each for errors up and down, exp(-t / time constant)
    at the step's middle, the same at its end, and one over the time constant [1/s].
    """
    both = (rotor.time_constant_up, rotor.time_constant_down)
    return [
        rotor.max_rot_velocity,
        *(math.exp(-0.5 * step / constant) for constant in both),
        *(math.exp(-step / constant) for constant in both),
        *(1.0 / constant for constant in both),
    ]


@register_jitable(forceinline=True)
def split_error(error: Scalar) -> tuple[Scalar, Scalar]:
    """Return the parts of an error with the time constants up and down."""
    side = error / (error * error + BLEND * BLEND) ** 0.5
    up = 0.5 * error * (1.0 + side * side * side)
    return up, error - up


@register_jitable
def speed_command(thrust: Scalar, motor_constant: Scalar, half: Scalar, motors: Scalar) -> Scalar:
    """Return the speed [rad/s] for a thrust [N].

    It is the non-negative root of motor_constant w (w + 2 half) = thrust.

    Args:
        thrust: wanted [N].
        motor_constant: see `plant.rotors.Rotor` [N·s²].
        half: of the rotor's `linear_speed` [rad/s].
        motors: 0 is off, see `Guidance`.
    """
    return motors * ((half * half + thrust / motor_constant) ** 0.5 - half)


@register_jitable(forceinline=True)
def within(command: Scalar, limit: float) -> Scalar:
    """Return a commanded speed clipped to a rotor's range, 0 to its limit [rad/s]."""
    if command > limit:
        command = limit
    if command < 0.0:
        command = 0.0
    return command


@register_jitable(forceinline=True)
def speed_slope(command: Scalar, speed: Scalar, constants: Sequence[float]) -> Scalar:
    """Return dw/dt of a rotor [rad/s²], see `rotor_constants`."""
    up, down = split_error(command - speed)
    return constants[5] * up + constants[6] * down


@register_jitable(forceinline=True)
def step_rotor(
    command: Scalar, speed: Scalar, constants: Sequence[float]
) -> tuple[Scalar, Scalar, Scalar]:
    """Return speed and its slope in the middle of a step, and speed at its end.

    Each part of the error decays in closed form. Richardson extrapolation from one whole step and
    two half steps, with a new split in the middle, makes the end second order.

    Args:
        command: constant over the step, see `within` [rad/s].
        speed: at the beginning [rad/s].
        constants: see `rotor_constants`.

    Returns:
        Speed [rad/s], slope [rad/s²], speed [rad/s].
    """
    _, middle_up, middle_down, end_up, end_down, rate_up, rate_down = constants
    up, down = split_error(command - speed)
    middle = command - up * middle_up - down * middle_down
    whole = command - up * end_up - down * end_down
    up, down = split_error(command - middle)
    halves = command - up * middle_up - down * middle_down
    return middle, up * rate_up + down * rate_down, 2.0 * halves - whole
