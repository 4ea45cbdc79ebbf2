"""How a rotor answers its command: pure functions of scalars, as the control law is.

The speed w follows the command u with dw/dt = (u - w) / time constant, faster up than down, as
Gazebo's motor model has it; thrust is motor_constant w². Where u = w and the two time constants
meet, the rate is their mean: they blend over about `BLEND`, so that linear models of hover exist,
and hold for steps of a hundredth of the usual ones.
"""

import math
from collections.abc import Sequence
from typing import Any

from numba.extending import register_jitable

from workbench.plant.rotors import Rotor

Scalar = Any
"""float, AutoDiffXd, a symbolic Expression, or what numba makes of it."""

BLEND = 3.0
"""Less than half a percent of usual hover speeds [rad/s]."""


def rotor_period(rotor: Rotor, period: float) -> list[float]:
    """Return the constants of a rotor's answer over a control period [s], for `step_rotor`.

    They are motor constant and largest speed; exp(-t / time constant) at the period's end, up
    and down; its mean over the period, up and down; the mean of its square, up and down; and
    the mean of the product of the two.
    """
    up = period / rotor.time_constant_up
    down = period / rotor.time_constant_down
    return [
        rotor.motor_constant,
        rotor.max_rot_velocity,
        math.exp(-up),
        math.exp(-down),
        _mean(up),
        _mean(down),
        _mean(2.0 * up),
        _mean(2.0 * down),
        _mean(up + down),
    ]


@register_jitable
def split_error(error: Scalar) -> tuple[Scalar, Scalar]:
    """Return max(error, 0) and min(error, 0) to within `BLEND` / 2, smooth, with the same sum."""
    root = (error * error + BLEND * BLEND) ** 0.5 - BLEND
    return (error + root) / 2.0, (error - root) / 2.0


@register_jitable
def speed_command(thrust: Scalar, motor_constant: Scalar, motors: Scalar) -> Scalar:
    """Return the speed [rad/s] that makes a thrust [N]; `motors` 0 is off, see `Guidance`."""
    return motors * (thrust / motor_constant) ** 0.5


@register_jitable
def drive_rotor(
    command: Scalar, speed: Scalar, share: Scalar, constants: Sequence[float]
) -> tuple[Scalar, Scalar, Scalar]:
    """Return mean thrust [N] over a period, speed at its end, and the command kept to [rad/s].

    Args:
        command: wanted speed [rad/s].
        speed: at the beginning [rad/s].
        share: of its thrust that the rotor gives; one that stops, with 0, gives all of it while it
            runs down.
        constants: see `rotor_period`.
    """
    limit = constants[1]
    if command > limit:
        command = limit
    if command < 0.0:
        command = 0.0
    thrust, speed = step_rotor(command, speed, constants)
    if share > 0.0:
        thrust = share * thrust
    return thrust, speed, command


@register_jitable
def step_rotor(command: Scalar, speed: Scalar, constants: Sequence[float]) -> tuple[Scalar, Scalar]:
    """Return the mean thrust [N] over a period with its command held, and the speed at its end.

    Under a held command the speed has a closed form, along which this steps; the thrust is its
    mean over the period, so that the impulse is exact.

    Args:
        command: wanted speed, within the rotor's limits [rad/s].
        speed: at the beginning [rad/s].
        constants: see `rotor_period`.
    """
    k, _, end_up, end_down, mean_up, mean_down, up_up, down_down, up_down = constants
    up, down = split_error(command - speed)
    end = command - up * end_up - down * end_down
    square = command * command - 2.0 * command * (up * mean_up + down * mean_down)
    square = square + up * up * up_up + down * down * down_down + 2.0 * up * down * up_down
    return k * square, end


def _mean(decay: float) -> float:
    """Return the mean of exp(-x) for x from 0 to `decay`."""
    return -math.expm1(-decay) / decay
