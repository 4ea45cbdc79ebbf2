"""Betaflight's mixer, from PID sums and throttle.

The shares of roll, pitch and yaw are the motors' moments, scaled to a largest value of 1; for four
motors in X they are Betaflight's QUADX. With the clipped PID sums over 1000,

    s_i = roll roll_i + pitch pitch_i + yaw yaw_i,   low = min(0, s_i),   high = max(0, s_i)
    k   = 1 / max(1, high - low)      air mode off and throttle below 0.5: times 0.5 + throttle
    u_i = k s_i + throttle, between -k low and 1 - k high                      (legacy mixer)
    u_i <- thrust linearisation of u_i, with e = thrust_linear
    motor = idle + (1 - idle) u_i                                              of its full signal

The linearisation depends on the version; the throttle t is changed by its inverse first:

    up to 4.2         u <- (u / e + b²)^½ - b,  b = (1 - e) / (2 e);    t <- t (1 - e (1 - t))
    4.3 to 2025.12    u <- u (1 + e (1 - u)²);               t <- t / (1 + (e - e² / 2) (1 - t)²)
    since 2026.6      u <- u (1 + e (1 - u) (1 + e (1 - 2 u)));         t <- t (1 - e (1 - t))

Source: Betaflight 4.2.11 to 2026.6.1, mixer.c, mixer_init.c, pid.c.
"""

from workbench.common.jitable import register_jitable
from workbench.control.law_parts import between
from workbench.extras.autopilots.mixers import (
    MAX_MIXER_MOTORS,
    EachMotor,
    MixerColumns,
    Turns,
    per_motor,
)


@register_jitable(forceinline=True)
def _betaflight_output(
    i: int, turns: Turns, linear: tuple[float, float], shares: MixerColumns
) -> float:
    """Return the output of motor i above idle, for scaled roll, pitch, yaw and throttle."""
    roll, pitch, yaw, throttle = turns
    by_roll, by_pitch, by_yaw, by_throttle = shares
    u = roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i] + throttle * by_throttle[i]
    e, form = linear
    if form < 0.5 and e > 0.0 and u > 0.0:
        b = 0.5 * (1.0 - e) / e
        return between((u / e + b * b) ** 0.5 - b, 0.0, 1.0)
    away = 1.0 - u
    bend = 1.0 + e * (away - u) if form > 1.5 else away
    return between(u * (1.0 + e * away * bend), 0.0, 1.0)


_betaflight_outputs = per_motor(_betaflight_output)


@register_jitable(forceinline=True)
def betaflight_mixed(
    wanted: Turns, airmode: float, linear: tuple[float, float], shares: MixerColumns
) -> EachMotor:
    """Return the outputs of eight motors above idle, 0 .. 1.

    Args:
        wanted: roll, pitch, yaw and throttle, in shares of full scale.
        airmode: on if above 0.5.
        linear: `thrust_linear` over 100, and the form of its equations above, 0, 1 or 2.
        shares: of roll, pitch, yaw and throttle, eight numbers each.
    """
    roll, pitch, yaw, throttle = wanted
    by_roll, by_pitch, by_yaw, _ = shares
    e, form = linear
    away = 1.0 - throttle
    if form > 0.5 and form < 1.5:
        throttle = throttle / (1.0 + (e - 0.5 * e * e) * away * away)
    else:
        throttle = throttle * (1.0 - e * away)
    low, high = 0.0 * roll, 0.0 * roll
    for i in range(MAX_MIXER_MOTORS):
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
    return _betaflight_outputs(turns, linear, shares)
