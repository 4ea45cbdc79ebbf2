"""PX4's control allocation, from normalised torque and thrust.

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

from collections.abc import Sequence

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.control.guidance import KnownRotor
from workbench.control.law_parts import between
from workbench.extras.autopilots.mixers import (
    MAX_MIXER_MOTORS,
    EachMotor,
    MixerColumns,
    Turns,
    check_motors,
    per_motor,
)

MIN_LIMITING_ENTRY = 0.2
"""A motor that a column moves by less than this does not limit a step."""
YAW_HEADROOM = 0.15
"""How far yaw may exceed the full scale before thrust is reduced."""
MIN_COLUMN_ENTRY, MIN_INVERSE_ENTRY = 1e-3, 6.5e-3
"""A smaller entry of a column counts as zero, and so does one of the pseudo-inverse; PX4's limit of
the latter is for thrusts in units of CA_ROTOR_CT, 6.5 by default."""
MIN_LEFT_TORQUE_SQUARED = 1e-6
"""Squared unallocated torque below which it counts as zero."""


def px4_mixing(rotors: Sequence[KnownRotor]) -> tuple[np.ndarray, list[float]]:
    """Return PX4's normalised columns (n, 4): roll, pitch and yaw in T, and thrust upwards.

    They are the pseudo-inverse over scales. The scales of the torques, `TORQUE_SCALE_NAMES`, are
    returned, too.

    Args:
        rotors: see `guidance.KnownRotor`.

    Raises:
        ValueError: if there are more than eight motors, or they cannot turn the vehicle.
    """
    effects = np.array([[each.m_x, each.m_y, each.m_z, each.force] for each in rotors])
    check_motors(effects, "PX4's allocation")
    mix = np.linalg.pinv(effects.T)
    pairs = (np.abs(mix[:, :2]) > MIN_INVERSE_ENTRY).sum(axis=0) / 2.0
    largest = float(np.sqrt((mix[:, :2] ** 2).sum(axis=0) / pairs).max())
    # in PX4 yaw is positive downwards, and its largest signed entry decides the scale
    scales = [largest, largest, -float(mix[:, 2].min())]
    mix /= [*scales, np.abs(mix[:, 3]).mean()]
    return np.where(np.abs(mix) < MIN_COLUMN_ENTRY, 0.0, mix), scales


@register_jitable(forceinline=True)
def desaturation_step(u: EachMotor, column: Numbers, most: float) -> float:
    """Return the step along a column that brings outputs within 0 .. most, see above."""
    least_k, most_k = 0.0 * u[0], 0.0 * u[0]
    for i in range(MAX_MIXER_MOTORS):
        c = column[i]
        if c < MIN_LIMITING_ENTRY and c > -MIN_LIMITING_ENTRY:
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
def _added(i: int, u: EachMotor, column: Numbers, k: float) -> float:
    """Return the output of motor i moved by k along a column."""
    return u[i] + k * column[i]


@register_jitable(forceinline=True)
def _limited(i: int, u: EachMotor) -> float:
    """Return the output of motor i limited to 0 .. 1."""
    return between(u[i], 0.0, 1.0)


moved_outputs, _limited_outputs = per_motor(_added), per_motor(_limited)


@register_jitable(forceinline=True)
def desaturated(u: EachMotor, column: Numbers, most: float) -> EachMotor:
    """Return outputs moved towards their limits along a column, in two steps."""
    u = moved_outputs(u, column, desaturation_step(u, column, most))
    return moved_outputs(u, column, 0.5 * desaturation_step(u, column, most))


@register_jitable(forceinline=True)
def with_less_thrust(u: EachMotor, column: Numbers) -> EachMotor:
    """Return outputs with less thrust if one is above its limit; never with more."""
    k = desaturation_step(u, column, 1.0)
    if k > 0.0:
        return u
    u = moved_outputs(u, column, k)
    return moved_outputs(u, column, 0.5 * desaturation_step(u, column, 1.0))


@register_jitable(forceinline=True)
def px4_allocated(wanted: Turns, mode: float, columns: MixerColumns) -> EachMotor:
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
    u = moved_outputs(
        moved_outputs(moved_outputs(u, by_thrust, thrust), by_roll, roll), by_pitch, pitch
    )
    if mode > 1.5:
        u = desaturated(moved_outputs(u, by_yaw, yaw), by_thrust, 1.0)
        u = desaturated(u, by_yaw, 1.0)
    else:
        if mode > 0.5:
            u = desaturated(u, by_thrust, 1.0)
        else:
            u = with_less_thrust(u, by_thrust)
            u = desaturated(u, by_roll, 1.0)
            u = desaturated(u, by_pitch, 1.0)
        u = desaturated(moved_outputs(u, by_yaw, yaw), by_yaw, 1.0 + YAW_HEADROOM)
        u = with_less_thrust(u, by_thrust)
    return _limited_outputs(u)


@register_jitable(forceinline=True)
def px4_unallocated_torque(
    u: EachMotor, torque: Vector3, scales: Vector3, by: MixerColumns
) -> Vector3:
    """Return the unallocated torques (3): commanded ones minus those of the motors' outputs.

    They are zero if PX4 ignores them as too small.

    Args:
        u: outputs of eight motors.
        torque: commanded roll, pitch and yaw.
        scales: see `TORQUE_SCALE_NAMES`.
        by: see `effects_per_thrust`.
    """
    _, by_x, by_y, by_z = by
    x, y, z = torque
    for i in range(MAX_MIXER_MOTORS):
        x = x - scales[0] * by_x[i] * u[i]
        y = y - scales[1] * by_y[i] * u[i]
        z = z - scales[2] * by_z[i] * u[i]
    if x * x + y * y + z * z < MIN_LEFT_TORQUE_SQUARED:
        return 0.0 * x, 0.0 * y, 0.0 * z
    return x, y, z
