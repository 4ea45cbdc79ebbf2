"""Mixer of Betaflight: from PID sums and throttle to motor signals.

The shares of roll, pitch and yaw are the motors' moments, scaled to a largest value of 1; for four
motors in X they are Betaflight's QUADX. With the clipped PID sums over 1000,

    s_i = roll roll_i + pitch pitch_i + yaw yaw_i,   low = min(0, s_i),   high = max(0, s_i)
    k   = 1 / max(1, high - low)      air mode off and throttle below 0.5: times 0.5 + throttle
    u_i = k s_i + throttle, between -k low and 1 - k high                      (legacy mixer)
    u_i <- u_i (1 + e (1 - u_i)²)                                              e = thrust_linear
    motor = idle + (1 - idle) u_i                                              of its full signal

The throttle t is first divided by 1 + (e - e² / 2) (1 - t)².

Source: Betaflight 4.6.0 development snapshot, mixer.c, mixer_init.c, pid.c.
"""

from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.control.motor_columns import MOST, moment_shares


def mixing(rotors: Any) -> np.ndarray:
    """Return Betaflight's shares (n, 4): roll, pitch and yaw in T, and throttle.

    Args:
        rotors: see `guidance.KnownRotor`.

    Raises:
        ValueError: if there are more motors than eight, or they cannot turn the vehicle.
    """
    return moment_shares(rotors, 1.0, "Betaflight's mixer")


@register_jitable(forceinline=True)
def mixed(wanted: Any, airmode: Any, linear: Any, shares: Any) -> Any:
    """Return what eight motors are told, 0 .. 1 above idle.

    Args:
        wanted: roll, pitch, yaw and throttle, in shares of full scale.
        airmode: above 0.5 it is on.
        linear: `thrust_linear` over 100.
        shares: of roll, pitch, yaw and throttle, eight numbers each.
    """
    roll, pitch, yaw, throttle = wanted
    by_roll, by_pitch, by_yaw, _ = shares
    away = 1.0 - throttle
    throttle = throttle / (1.0 + (linear - 0.5 * linear * linear) * away * away)
    low, high = 0.0 * roll, 0.0 * roll
    for i in range(MOST):
        s = roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i]
        low = s if s < low else low
        high = s if s > high else high
    k = 1.0 + 0.0 * roll
    if airmode < 0.5 and throttle < 0.5:
        k = k * (0.5 + throttle)
    if high - low > 1.0:
        k = k / (high - low)
    if throttle > 1.0 - k * high:
        throttle = 1.0 - k * high
    if throttle < -k * low:
        throttle = -k * low
    turns = (k * roll, k * pitch, k * yaw, throttle)
    return (
        _output(0, turns, linear, shares),
        _output(1, turns, linear, shares),
        _output(2, turns, linear, shares),
        _output(3, turns, linear, shares),
        _output(4, turns, linear, shares),
        _output(5, turns, linear, shares),
        _output(6, turns, linear, shares),
        _output(7, turns, linear, shares),
    )


@register_jitable(forceinline=True)
def _output(i: Any, turns: Any, linear: Any, shares: Any) -> Any:
    """Return what motor i is told above idle, of scaled roll, pitch, yaw and of throttle."""
    roll, pitch, yaw, throttle = turns
    by_roll, by_pitch, by_yaw, by_throttle = shares
    u = roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i] + throttle * by_throttle[i]
    u = u * (1.0 + linear * (1.0 - u) * (1.0 - u))
    if u < 0.0:
        return 0.0 * u
    if u > 1.0:
        return 1.0 + 0.0 * u
    return u
