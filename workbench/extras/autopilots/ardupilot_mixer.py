"""ArduPilot's mixer and thrust linearisation, from torques and throttle.

The factors of roll, pitch and yaw are the motors' moments, scaled to a largest value of 0.5; x_i is
that of motor i:

    s_i   = roll roll_i + pitch pitch_i                        of each motor
    yaw   within max(MOT_YAW_HEADROOM / 1000, least room_i / |yaw_i|), where room_i is the distance
            of min(0.5, most) + s_i from 0 or 1, in the direction that yaw moves the motor
    s_i   <- k (s_i + yaw yaw_i),   low = min s_i,   high = max s_i
            k = min(1, 1 / (high - low), -most / low where most + low < 0)
    u_i   = s_i - low + t           t: throttle + low, limited to 0 .. 1 - high + low; 0 if k < 1

`most` limits the average throttle for the attitude: from the throttle ATC_THR_MIX_MAX of the way to
that of hover. The integral of a limited torque may only shrink.
A thrust share u becomes a share of the motor's full signal by

    SPIN_MIN + (SPIN_MAX - SPIN_MIN) r,   r = (e - 1 + ((1 - e)² + 4 e u)^½) / (2 e)

with MOT_THST_EXPO for e.

Source: ArduPilot, AP_MotorsMatrix.cpp (output_armed_stabilizing), AP_Motors_Thrust_Linearization.
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

YAW_END_TOLERANCE = 1e-12
"""Tolerance at the ends: yaw that is limited to end there may exceed them by rounding."""
MIN_THRUST_EXPO = 1e-6
"""A smaller MOT_THST_EXPO counts as zero."""


@register_jitable(forceinline=True)
def _ardupilot_share(i: int, turns: Turns, columns: MixerColumns) -> float:
    """Return the thrust share of motor i, for scaled roll, pitch, yaw and throttle."""
    roll, pitch, yaw, throttle = turns
    by_roll, by_pitch, by_yaw, by_throttle = columns
    return throttle * by_throttle[i] + (roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i])


_ardupilot_shares = per_motor(_ardupilot_share)


@register_jitable(forceinline=True)
def ardupilot_mixed(
    wanted: Turns, average: float, headroom: float, factors: MixerColumns
) -> tuple[EachMotor, tuple[float, float, float, float]]:
    """Return the thrust shares of eight motors, 0 .. 1, and the limits that were met.

    Args:
        wanted: roll, pitch, yaw and throttle.
        average: limit of the average throttle for the attitude.
        headroom: share that is kept for yaw.
        factors: of roll, pitch, yaw and throttle, eight numbers each.

    Returns:
        The shares (8), and 1 or 0 for each of: roll and pitch limited, yaw limited, throttle at its
        minimum, throttle at its maximum.
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
    for i in range(MAX_MIXER_MOTORS):
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
    for i in range(MAX_MIXER_MOTORS):
        s = roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i]
        low = s if s < low else low
        high = s if s > high else high
    scale = 1.0 + 0.0 * roll
    if high - low > 1.0 + YAW_END_TOLERANCE:
        scale = 1.0 / (high - low)
    if average + low < -YAW_END_TOLERANCE and -average / low < scale:
        scale = -average / low
    low, high = scale * low, scale * high
    raised = throttle + low
    if scale < 1.0:
        cut, cut_yaw = 1.0 + 0.0 * roll, 1.0 + 0.0 * roll
        most = 1.0 + 0.0 * roll if raised > YAW_END_TOLERANCE else most
        raised = 0.0 * raised
    elif raised < 0.0:
        raised = 0.0 * raised
    elif raised > 1.0 - high + low + YAW_END_TOLERANCE:
        raised, most = 1.0 - high + low, 1.0 + 0.0 * roll
    base = raised - low
    columns = (by_roll, by_pitch, by_yaw, by_throttle)
    turns = (scale * roll, scale * pitch, scale * yaw, base)
    return _ardupilot_shares(turns, columns), (cut, cut_yaw, least, most)


@register_jitable(forceinline=True)
def ardupilot_actuator(u: float, expo: float, spin_min: float, spin_max: float) -> float:
    """Return the share of a motor's full signal, for a share of its thrust."""
    u = between(u, 0.0, 1.0)
    ratio = u
    if expo >= MIN_THRUST_EXPO or expo <= -MIN_THRUST_EXPO:
        line = 1.0 - expo
        ratio = ((line * line + 4.0 * expo * u) ** 0.5 - line) / (2.0 * expo)
    return spin_min + (spin_max - spin_min) * between(ratio, 0.0, 1.0)
