"""Mixer and thrust linearisation of ArduPilot: from torques and throttle to motor signals.

The factors of roll, pitch and yaw are the motors' moments, scaled to a largest value of 0.5; x_i is
that of motor i:

    s_i   = roll roll_i + pitch pitch_i                        of each motor
    yaw   within max(MOT_YAW_HEADROOM / 1000, least room_i / |yaw_i|), where room_i is the distance
            of min(0.5, most) + s_i from 0 or 1, in the direction that yaw moves the motor
    s_i   <- k (s_i + yaw yaw_i),   low = min s_i,   high = max s_i
            k = min(1, 1 / (high - low), -most / low where most + low < 0)
    u_i   = s_i - low + t           t: throttle + low, limited to 0 .. 1 - high + low; 0 if k < 1

`most` limits the average throttle for the attitude: ATC_THR_MIX_MAX of the way from the throttle
to that of hover. The integral of a torque that is cut may then only shrink.
A thrust share u becomes a share of the motor's full signal by

    SPIN_MIN + (SPIN_MAX - SPIN_MIN) r,   r = (e - 1 + ((1 - e)² + 4 e u)^½) / (2 e)

with MOT_THST_EXPO for e.

Source: ArduPilot, AP_MotorsMatrix.cpp (output_armed_stabilizing), AP_Motors_Thrust_Linearization.
"""

from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.control.motor_columns import MOST, moment_shares

LARGEST = 0.5
"""Factor of the motor that turns the vehicle most."""
ROUNDING = 1e-12
"""Tolerance at the ends: yaw that is limited to end there may exceed them by rounding."""
LINEAR = 1e-6
"""A smaller expo is none."""


def mixing(rotors: Any) -> np.ndarray:
    """Return ArduPilot's factors (n, 4): roll, pitch and yaw in T, and throttle.

    Args:
        rotors: see `guidance.KnownRotor`.

    Raises:
        ValueError: if there are more motors than eight, or they cannot turn the vehicle.
    """
    return moment_shares(rotors, LARGEST, "ArduPilot's mixer")


@register_jitable(forceinline=True)
def mixed(wanted: Any, average: Any, headroom: Any, factors: Any) -> tuple[Any, Any]:
    """Return the thrust shares of eight motors, 0 .. 1, and what was cut.

    Args:
        wanted: roll, pitch, yaw and throttle.
        average: how far the average throttle may go for the attitude.
        headroom: share that yaw may always have.
        factors: of roll, pitch, yaw and throttle, eight numbers each.

    Returns:
        The shares (8), and 1 or 0 for: roll and pitch cut, yaw cut, no less throttle, no more.
    """
    roll, pitch, yaw, throttle = wanted
    by_roll, by_pitch, by_yaw, by_throttle = factors
    cut, cut_yaw, least, most = 0.0 * roll, 0.0 * roll, 0.0 * roll, 0.0 * roll
    if throttle <= 0.0:
        throttle, least = 0.0 * throttle, 1.0 + 0.0 * roll
    if throttle >= 1.0:
        throttle, most = 1.0 + 0.0 * throttle, 1.0 + 0.0 * roll
    if average < throttle:
        average = throttle
    if average > 1.0:
        average = 1.0 + 0.0 * average

    middle = average if average < 0.5 else 0.5 + 0.0 * average
    allowed = 1.0 + 0.0 * roll
    for i in range(MOST):
        factor = by_yaw[i]
        size = factor if factor > 0.0 else -factor
        if size > 0.0:
            room = middle + roll * by_roll[i] + pitch * by_pitch[i]
            if yaw * factor > 0.0:
                room = 1.0 - room
            room = (room if room > 0.0 else 0.0 * room) / size
            allowed = room if room < allowed else allowed
    if allowed < headroom:
        allowed = headroom + 0.0 * allowed
    if yaw > allowed:
        yaw, cut_yaw = allowed, 1.0 + 0.0 * roll
    if yaw < -allowed:
        yaw, cut_yaw = -allowed, 1.0 + 0.0 * roll

    low, high = 0.0 * roll, 0.0 * roll
    for i in range(MOST):
        s = roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i]
        low = s if s < low else low
        high = s if s > high else high
    scale = 1.0 + 0.0 * roll
    if high - low > 1.0 + ROUNDING:
        scale = 1.0 / (high - low)
    if average + low < -ROUNDING and -average / low < scale:
        scale = -average / low
    low, high = scale * low, scale * high
    raised = throttle + low
    if scale < 1.0:
        cut, cut_yaw = 1.0 + 0.0 * roll, 1.0 + 0.0 * roll
        most = 1.0 + 0.0 * roll if raised > ROUNDING else most
        raised = 0.0 * raised
    elif raised < 0.0:
        raised = 0.0 * raised
    elif raised > 1.0 - high + low + ROUNDING:
        raised, most = 1.0 - high + low, 1.0 + 0.0 * roll
    base = raised - low
    columns = (by_roll, by_pitch, by_yaw, by_throttle)
    turns = (scale * roll, scale * pitch, scale * yaw, base)
    shares = (
        _share(0, turns, columns),
        _share(1, turns, columns),
        _share(2, turns, columns),
        _share(3, turns, columns),
        _share(4, turns, columns),
        _share(5, turns, columns),
        _share(6, turns, columns),
        _share(7, turns, columns),
    )
    return shares, (cut, cut_yaw, least, most)


@register_jitable(forceinline=True)
def _share(i: Any, turns: Any, columns: Any) -> Any:
    """Return the thrust share of motor i, of scaled roll, pitch, yaw and of throttle."""
    roll, pitch, yaw, throttle = turns
    by_roll, by_pitch, by_yaw, by_throttle = columns
    return throttle * by_throttle[i] + (roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i])


@register_jitable(forceinline=True)
def actuator(u: Any, expo: Any, spin_min: Any, spin_max: Any) -> Any:
    """Return the share of a motor's full signal, for a share of its thrust."""
    if u < 0.0:
        u = 0.0 * u
    if u > 1.0:
        u = 1.0 + 0.0 * u
    if expo < LINEAR and expo > -LINEAR:
        ratio = u
    else:
        line = 1.0 - expo
        ratio = ((line * line + 4.0 * expo * u) ** 0.5 - line) / (2.0 * expo)
    if ratio < 0.0:
        ratio = 0.0 * ratio
    if ratio > 1.0:
        ratio = 1.0 + 0.0 * ratio
    return spin_min + (spin_max - spin_min) * ratio
