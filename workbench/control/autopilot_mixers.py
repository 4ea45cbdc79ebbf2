"""Mixers of the autopilots, for up to eight motors: from torques and thrust to motor signals.

Betaflight's mixer, from PID sums and throttle
----------------------------------------------
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

ArduPilot's mixer and thrust linearisation, from torques and throttle
---------------------------------------------------------------------
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

PX4's control allocation, from normalised torque and thrust
-----------------------------------------------------------
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

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.common.jitable import attributes, register_jitable, unique
from workbench.control.law_parts import between
from workbench.plant.thrust_frame import ThrustFrame

MOST = 8
"""Maximum number of motors."""
COLUMNS = ("roll", "pitch", "yaw", "thrust")
EFFECTS = ("f", "x", "y", "z")
NAMES = tuple(f"{name}_{k + 1}" for name in (*COLUMNS, *EFFECTS) for k in range(MOST)) + ("count",)
"""Names of the numbers of `column_numbers`."""
LEAST = 1e-9
"""A moment below this share of the largest one counts as zero."""
ROUNDING = 1e-12
"""Tolerance at the ends: yaw that is limited to end there may exceed them by rounding."""
LINEAR = 1e-6
"""A smaller MOT_THST_EXPO counts as zero."""
LEAST_ENTRY = 0.2
"""A motor that a column moves by less than this does not limit a step."""
YAW_ROOM = 0.15
"""How far yaw may exceed the full scale before thrust is reduced."""
SMALL_ENTRY, SMALL_EFFECT = 1e-3, 6.5e-3
"""A smaller entry of a column counts as zero, and so does one of the pseudo-inverse; PX4's limit of
the latter is for thrusts in units of CA_ROTOR_CT, 6.5 by default."""
ACHIEVED = 1e-6
"""Squared unallocated torque below which it counts as zero."""
SCALES = ("roll_scale", "pitch_scale", "yaw_scale")
"""Torque in a column's unit over the moment for a thrust of 1 at each motor [1/m]."""


def moment_shares(rotors: Any, most: float, mixer: str) -> np.ndarray:
    """Return the columns (n, 4) of Betaflight's and ArduPilot's mixers.

    They are the motors' moments in T over the largest one, times `most`, and 1 for throttle.

    Args:
        rotors: see `guidance.KnownRotor`.
        most: largest entry of roll, of pitch and of yaw: 1 in Betaflight, 0.5 in ArduPilot.
        mixer: its name, for the message.

    Raises:
        ValueError: if there are more than eight motors, or they cannot turn the vehicle.
    """
    moments = np.array([[each.m_x, each.m_y, each.m_z] for each in rotors])
    check_motors(np.column_stack([moments, [each.force for each in rotors]]), mixer)
    shares = moments / np.abs(moments).max(axis=0)
    shares[np.abs(shares) < LEAST] = 0.0
    return np.column_stack([most * shares, np.ones(len(rotors))])


def hover_authority(rotors: Any, frame: ThrustFrame, mix: np.ndarray, *per_signal: Any) -> Any:
    """Return angular accelerations (3) and vertical force for a unit of each column, in hover.

    Args:
        rotors: see `guidance.KnownRotor`.
        frame: of the vehicle.
        mix: columns of roll, pitch, yaw and thrust (n, 4).
        per_signal: factors of the slope of a motor's speed over its signal, or of each motor's (n)
            [rad/s].

    Returns:
        [rad/s²] about x, y and z of T, and [N].
    """
    constants = np.array([each.motor_constant for each in rotors])
    linear = np.array([each.linear_speed for each in rotors])
    slopes = constants * (2.0 * frame.hover_speeds + linear)
    for factor in per_signal:
        slopes = slopes * factor
    effects = np.array([[each.m_x, each.m_y, each.m_z, each.force] for each in rotors])
    found = (effects * mix * slopes[:, None]).sum(axis=0)
    return found / [*np.diagonal(frame.inertia_T), 1.0]


def check_motors(effects: np.ndarray, mixer: str) -> None:
    """Check the number of motors, and that they can make all moments and the force.

    Args:
        effects: of each motor on moments and force (n, 4).
        mixer: its name, for the message.

    Raises:
        ValueError: if there are more than eight motors, or they cannot turn the vehicle.
    """
    if len(effects) > MOST:
        raise ValueError(f"{mixer} here is for {MOST} motors, and there are {len(effects)}")
    if np.linalg.matrix_rank(effects) < len(COLUMNS):
        raise ValueError("the rotors cannot make roll, pitch, yaw and thrust: check their places")


def column_numbers(rotors: Any, mix: np.ndarray) -> list[float]:
    """Return columns and effects of eight motors, 0 for missing ones, and the number of motors.

    Args:
        rotors: see `guidance.KnownRotor`.
        mix: columns of roll, pitch, yaw and thrust (n, 4).
    """
    effects = np.array([[each.force, each.m_x, each.m_y, each.m_z] for each in rotors])
    padded = np.zeros((2 * len(COLUMNS), MOST))
    padded[:4, : len(rotors)], padded[4:, : len(rotors)] = mix.T, effects.T
    return [*padded.ravel().tolist(), float(len(rotors))]


def per_motor(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that returns what `function(i, ...)` returns for each motor (8).

    numba makes no tuple in a loop.
    """

    @register_jitable(forceinline=True)
    def run(*args: Any) -> Any:
        return (
            function(0, *args),
            function(1, *args),
            function(2, *args),
            function(3, *args),
            function(4, *args),
            function(5, *args),
            function(6, *args),
            function(7, *args),
        )

    return unique(run, function.__name__)


_roll, _pitch, _yaw, _thrust, _force, _moment_x, _moment_y, _moment_z = (
    attributes([f"{name}_{k + 1}" for k in range(MOST)], name) for name in (*COLUMNS, *EFFECTS)
)


@register_jitable(forceinline=True)
def columns(g: Any) -> Any:
    """Return the columns of roll, pitch, yaw and thrust, eight numbers each."""
    return _roll(g), _pitch(g), _yaw(g), _thrust(g)


@register_jitable(forceinline=True)
def effects(g: Any) -> Any:
    """Return force and moments per thrust, eight numbers each."""
    return _force(g), _moment_x(g), _moment_y(g), _moment_z(g)


@register_jitable(forceinline=True)
def with_motor(wrench: Any, i: Any, thrust: Any, by: Any) -> Any:
    """Return a wrench, F [N] and m [N·m], plus the contribution of motor i.

    Args:
        wrench: of the previous motors (4).
        i: index of the motor.
        thrust: of the motor [N].
        by: see `effects`.
    """
    force, by_x, by_y, by_z = by
    return (
        wrench[0] + force[i] * thrust,
        wrench[1] + by_x[i] * thrust,
        wrench[2] + by_y[i] * thrust,
        wrench[3] + by_z[i] * thrust,
    )


@register_jitable(forceinline=True)
def _betaflight_output(i: Any, turns: Any, linear: Any, shares: Any) -> Any:
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
def betaflight_mixed(wanted: Any, airmode: Any, linear: Any, shares: Any) -> Any:
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
    return _betaflight_outputs(turns, linear, shares)


@register_jitable(forceinline=True)
def _ardupilot_share(i: Any, turns: Any, columns: Any) -> Any:
    """Return the thrust share of motor i, for scaled roll, pitch, yaw and throttle."""
    roll, pitch, yaw, throttle = turns
    by_roll, by_pitch, by_yaw, by_throttle = columns
    return throttle * by_throttle[i] + (roll * by_roll[i] + pitch * by_pitch[i] + yaw * by_yaw[i])


_ardupilot_shares = per_motor(_ardupilot_share)


@register_jitable(forceinline=True)
def ardupilot_mixed(wanted: Any, average: Any, headroom: Any, factors: Any) -> tuple[Any, Any]:
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
    return _ardupilot_shares(turns, columns), (cut, cut_yaw, least, most)


@register_jitable(forceinline=True)
def ardupilot_actuator(u: Any, expo: Any, spin_min: Any, spin_max: Any) -> Any:
    """Return the share of a motor's full signal, for a share of its thrust."""
    u = between(u, 0.0, 1.0)
    ratio = u
    if expo >= LINEAR or expo <= -LINEAR:
        line = 1.0 - expo
        ratio = ((line * line + 4.0 * expo * u) ** 0.5 - line) / (2.0 * expo)
    return spin_min + (spin_max - spin_min) * between(ratio, 0.0, 1.0)


def px4_mixing(rotors: Any) -> tuple[np.ndarray, list[float]]:
    """Return PX4's normalised columns (n, 4): roll, pitch and yaw in T, and thrust upwards.

    They are the pseudo-inverse over scales. The scales of the torques, `SCALES`, are returned, too.

    Args:
        rotors: see `guidance.KnownRotor`.

    Raises:
        ValueError: if there are more than eight motors, or they cannot turn the vehicle.
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
    """Return the step along a column that brings outputs within 0 .. most, see above."""
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
def _added(i: Any, u: Any, column: Any, k: Any) -> Any:
    """Return the output of motor i moved by k along a column."""
    return u[i] + k * column[i]


@register_jitable(forceinline=True)
def _limited(i: Any, u: Any) -> Any:
    """Return the output of motor i limited to 0 .. 1."""
    return between(u[i], 0.0, 1.0)


added, _within = per_motor(_added), per_motor(_limited)


@register_jitable(forceinline=True)
def desaturated(u: Any, column: Any, most: Any) -> Any:
    """Return outputs moved towards their limits along a column, in two steps."""
    u = added(u, column, desaturating(u, column, most))
    return added(u, column, 0.5 * desaturating(u, column, most))


@register_jitable(forceinline=True)
def lowered(u: Any, column: Any) -> Any:
    """Return outputs with less thrust if one is above its limit; never with more."""
    k = desaturating(u, column, 1.0)
    if k > 0.0:
        return u
    u = added(u, column, k)
    return added(u, column, 0.5 * desaturating(u, column, 1.0))


@register_jitable(forceinline=True)
def px4_allocated(wanted: Any, mode: Any, columns: Any) -> Any:
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
    return _within(u)


@register_jitable(forceinline=True)
def px4_left_over(u: Any, torque: Any, scales: Any, by: Any) -> Any:
    """Return the unallocated torques (3): commanded ones minus those of the motors' outputs.

    They are zero if PX4 ignores them as too small.

    Args:
        u: outputs of eight motors.
        torque: commanded roll, pitch and yaw.
        scales: see `SCALES`.
        by: see `effects`.
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
