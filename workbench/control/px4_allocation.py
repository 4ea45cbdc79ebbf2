"""Control allocation of PX4: normalised torque and thrust to what each motor is told.

The pseudo-inverse of the motors' effects is scaled so that roll and pitch share one full scale, and
yaw and thrust have one of their own. Then, for up to eight motors (sequential desaturation, without
and with air mode):

    u = thrust + roll + pitch                    of each motor
    u <- u - k thrust                            less thrust, where one is above 1
    u <- u + k roll, u <- u + k pitch            less roll and pitch, where that was not enough
    u <- u + yaw, then less yaw against limits with 0.15 more at the top, then less thrust

A step along a column c takes k = min (limit - u_i) / c_i + max (limit - u_i) / c_i over the motors
beyond a limit, and half of what is found anew after it. Entries of c below 0.2 count for nothing.
Air mode 1 may raise thrust for roll and pitch; 2 adds yaw before, and takes it back at the end.

Source: PX4-Autopilot, ControlAllocationSequentialDesaturation.cpp, ControlAllocationPseudoInverse.
"""

import math
from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable

MOST = 8
"""Motors there may be."""
LEAST_ENTRY = 0.2
"""A motor that a column moves by less than this does not decide how far."""
YAW_ROOM = 0.15
"""By which yaw may go beyond the full scale, before thrust gives way."""
COLUMNS = ("roll", "pitch", "yaw", "thrust")
EFFECTS = ("f", "x", "y", "z")
NAMES = tuple(f"{name}_{k + 1}" for name in (*COLUMNS, *EFFECTS) for k in range(MOST)) + ("count",)
"""Of what `allocation_numbers` returns."""


def mixing(rotors: Any) -> np.ndarray:
    """Return PX4's normalised columns (n, 4): roll, pitch and yaw in T, and thrust upwards.

    Args:
        rotors: see `guidance.KnownRotor`.

    Raises:
        ValueError: if there are more motors than eight, or they cannot turn the vehicle.
    """
    if len(rotors) > MOST:
        raise ValueError(f"PX4's allocation here is for {MOST} motors, and there are {len(rotors)}")
    effects = np.array([[each.m_x, each.m_y, each.m_z, each.force] for each in rotors]).T
    if np.linalg.matrix_rank(effects) < len(COLUMNS):
        raise ValueError("the rotors cannot make roll, pitch, yaw and thrust: check their places")
    mix = np.linalg.pinv(effects)
    largest = np.sqrt((mix[:, :2] ** 2).sum(axis=0) / (len(rotors) / 2.0)).max()
    mix[:, :2] /= largest
    mix[:, 2] /= np.abs(mix[:, 2]).max()
    mix[:, 3] /= np.abs(mix[:, 3]).mean()
    return mix


def allocation_numbers(rotors: Any) -> list[float]:
    """Return columns and effects of the motors, 0 where there is none, and how many there are."""
    mix = mixing(rotors)
    effects = np.array([[each.force, each.m_x, each.m_y, each.m_z] for each in rotors])
    padded = np.zeros((2 * len(COLUMNS), MOST))
    padded[:4, : len(rotors)], padded[4:, : len(rotors)] = mix.T, effects.T
    return [*padded.ravel().tolist(), float(len(rotors))]


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


def butterworth(cutoff: float, period: float) -> tuple[float, ...]:
    """Return b0, b1, b2, a1, a2 of PX4's low-pass of second order; it lets all through at 0 Hz."""
    if cutoff <= 0.0 or cutoff >= 0.5 / period:
        return 1.0, 0.0, 0.0, 0.0, 0.0
    ohm = math.tan(math.pi * cutoff * period)
    c = 1.0 + 2.0 * math.cos(math.pi / 4.0) * ohm + ohm * ohm
    b = ohm * ohm / c
    return (
        b,
        2.0 * b,
        b,
        2.0 * (ohm * ohm - 1.0) / c,
        (1.0 - 2.0 * math.cos(math.pi / 4.0) * ohm + ohm * ohm) / c,
    )
