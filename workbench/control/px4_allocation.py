"""Control allocation of PX4: from normalised torque and thrust to motor signals.

The pseudo-inverse of the motors' effects is scaled so that roll and pitch share one full scale;
yaw and thrust have their own. Then, for up to eight motors (sequential desaturation, without
and with air mode):

    u = thrust + roll + pitch                    of each motor
    u <- u - k thrust                            less thrust, if a motor is above 1
    u <- u + k roll, u <- u + k pitch            less roll and pitch, if that was not enough
    u <- u + yaw, then less yaw against limits with 0.15 more at the top, then less thrust

A step along a column c takes k = min (limit - u_i) / c_i + max (limit - u_i) / c_i over the motors
beyond a limit, then half of the k computed again. Entries of c below 0.2 are ignored.
Air mode 1 may raise thrust for roll and pitch; 2 also adds yaw first, and reduces it at the end.

Source: PX4-Autopilot, ControlAllocationSequentialDesaturation.cpp, ControlAllocationPseudoInverse.
"""

from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.control.motor_columns import MOST, check_motors

LEAST_ENTRY = 0.2
"""A motor that a column moves by less than this does not limit a step."""
YAW_ROOM = 0.15
"""How far yaw may exceed the full scale before thrust is reduced."""
SMALL_ENTRY, SMALL_EFFECT = 1e-3, 6.5e-3
"""Below the first an entry of a column counts as none; the second is that of the pseudo-inverse,
which PX4 has for thrusts of CA_ROTOR_CT, 6.5 by default."""
ACHIEVED = 1e-6
"""Squared unallocated torque below which it counts as zero."""
SCALES = ("roll_scale", "pitch_scale", "yaw_scale")
"""Of torque in a column's unit over moment that a thrust of 1 at each motor makes [1/m]."""


def mixing(rotors: Any) -> tuple[np.ndarray, list[float]]:
    """Return PX4's normalised columns (n, 4): roll, pitch and yaw in T, and thrust upwards.

    They are the pseudo-inverse over scales, of which those of the torques, `SCALES`, are returned,
    too.

    Args:
        rotors: see `guidance.KnownRotor`.

    Raises:
        ValueError: if there are more motors than eight, or they cannot turn the vehicle.
    """
    effects = np.array([[each.m_x, each.m_y, each.m_z, each.force] for each in rotors])
    check_motors(effects, "PX4's allocation")
    mix = np.linalg.pinv(effects.T)
    pairs = (np.abs(mix[:, :2]) > SMALL_EFFECT).sum(axis=0) / 2.0
    largest = float(np.sqrt((mix[:, :2] ** 2).sum(axis=0) / pairs).max())
    # in PX4 yaw is positive downwards, and its largest signed entry decides the scale
    scales = [largest, largest, -float(mix[:, 2].min())]
    mix /= [*scales, np.abs(mix[:, 3]).mean()]
    return np.where(np.abs(mix) < SMALL_ENTRY, 0.0, mix), scales


@register_jitable(forceinline=True)
def desaturating(u: Any, column: Any, most: Any) -> Any:
    """Return how far to go along a column so that outputs are within 0 .. most, see above."""
    least_k, most_k = 0.0 * u[0], 0.0 * u[0]
    for i in range(MOST):
        c = column[i]
        if c < LEAST_ENTRY and c > -LEAST_ENTRY:
            continue
        if u[i] < 0.0:
            k = -u[i] / c
            least_k = k if k < least_k else least_k
            most_k = k if k > most_k else most_k
        if u[i] > most:
            k = (most - u[i]) / c
            least_k = k if k < least_k else least_k
            most_k = k if k > most_k else most_k
    return least_k + most_k


@register_jitable(forceinline=True)
def added(u: Any, column: Any, k: Any) -> Any:
    """Return outputs moved along a column."""
    return (
        u[0] + k * column[0],
        u[1] + k * column[1],
        u[2] + k * column[2],
        u[3] + k * column[3],
        u[4] + k * column[4],
        u[5] + k * column[5],
        u[6] + k * column[6],
        u[7] + k * column[7],
    )


@register_jitable(forceinline=True)
def desaturated(u: Any, column: Any, most: Any) -> Any:
    """Return outputs brought towards their limits along a column, in two steps."""
    u = added(u, column, desaturating(u, column, most))
    return added(u, column, 0.5 * desaturating(u, column, most))


@register_jitable(forceinline=True)
def lowered(u: Any, column: Any) -> Any:
    """Return outputs with less thrust, where one is above its limit; never with more."""
    k = desaturating(u, column, 1.0)
    if k > 0.0:
        return u
    u = added(u, column, k)
    return added(u, column, 0.5 * desaturating(u, column, 1.0))


@register_jitable(forceinline=True)
def allocated(wanted: Any, mode: Any, columns: Any) -> Any:
    """Return the outputs of eight motors, 0 .. 1.

    Args:
        wanted: roll, pitch, yaw and thrust, normalised; thrust upwards.
        mode: `MC_AIRMODE`, 0, 1 or 2.
        columns: of roll, pitch, yaw and thrust, eight numbers each.
    """
    roll, pitch, yaw, thrust = wanted
    by_roll, by_pitch, by_yaw, by_thrust = columns
    none = 0.0 * thrust
    u = (none, none, none, none, none, none, none, none)
    u = added(added(added(u, by_thrust, thrust), by_roll, roll), by_pitch, pitch)
    if mode > 1.5:
        u = desaturated(added(u, by_yaw, yaw), by_thrust, 1.0)
        u = desaturated(u, by_yaw, 1.0)
    else:
        if mode > 0.5:
            u = desaturated(u, by_thrust, 1.0)
        else:
            u = lowered(u, by_thrust)
            u = desaturated(u, by_roll, 1.0)
            u = desaturated(u, by_pitch, 1.0)
        u = desaturated(added(u, by_yaw, yaw), by_yaw, 1.0 + YAW_ROOM)
        u = lowered(u, by_thrust)
    return (
        _within(u[0]),
        _within(u[1]),
        _within(u[2]),
        _within(u[3]),
        _within(u[4]),
        _within(u[5]),
        _within(u[6]),
        _within(u[7]),
    )


@register_jitable(forceinline=True)
def _within(u: Any) -> Any:
    if u < 0.0:
        return 0.0 * u
    if u > 1.0:
        return 1.0 + 0.0 * u
    return u


@register_jitable(forceinline=True)
def left_over(u: Any, torque: Any, scales: Any, by: Any) -> Any:
    """Return the unallocated torques (3): commanded ones minus those of the motors' outputs.

    They are zero if they are so small that PX4 ignores them.

    Args:
        u: outputs of eight motors.
        torque: commanded roll, pitch and yaw.
        scales: see `SCALES`.
        by: see `motor_columns.effects`.
    """
    _, by_x, by_y, by_z = by
    x, y, z = torque
    for i in range(MOST):
        x = x - scales[0] * by_x[i] * u[i]
        y = y - scales[1] * by_y[i] * u[i]
        z = z - scales[2] * by_z[i] * u[i]
    if x * x + y * y + z * z < ACHIEVED:
        return 0.0 * x, 0.0 * y, 0.0 * z
    return x, y, z
