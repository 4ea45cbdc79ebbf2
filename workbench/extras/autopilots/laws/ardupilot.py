"""ArduPilot Copter 4.3 to 4.7: position, thrust-vector attitude, rate PIDs, and its mixer.

Parameters have ArduPilot's names, units (SI, degrees where it has them) and defaults. It uses NED
and FRD; here x, y, z are those of the world and the body, z up: N and E are horizontal, D is
height. All runs at 512 Hz, in ArduPilot at its main loop's 400. LPF_f is a first-order low-pass,
and

    sqrtP(e; k, a) = k e                             where |e| <= a / k²,  else
                     sgn(e) (2 a (|e| - a / (2 k²)))^½              a = 0: k e
                     k = 0: sgn(e) (2 a |e|)^½; of angles no more than e / dt

    v_sp = sqrtP(p_sp - p; POS_P, WP_ACC) + v_ff     level along the error; within WP_SPD
    e_f  = LPF_FLTE(v_sp - v),   a_sp = VEL_P e_f + I + VEL_D LPF_FLTD(de_f/dt) + a_ff
    |a_sp| level <= g tan(ATC_ANGLE_MAX); while this limit is active, I does not grow towards it
    thr  = PID_ACC(a_sp - a) + MOT_THST_HOVER,       of height; F = thr / cos(tilt), 2 Hz

The commanded attitude has its thrust along (a_x, a_y, g). A shaped target moves there by

    ω_d = sqrtP(e; κ, a_m) - ω_t,   dω_t/dt = κ (ω_d - ω_t) within a_m, its slope within κ a_m

with κ = 1 / ATC_INPUT_TC and a_m = ATC_ACC_MAX; the yaw rate turns it, shaped likewise. Up to 4.6
the jerk is not limited: ω_t = sqrtP(e; κ, a_m), its slope within a_m; `firmware` chooses. With
ATC_RATE_FF_ENAB 0 the target is the commanded attitude, and ω_t is 0. From body to target, e is the
rotation of the thrust vector, x and y, and the remaining heading error, z. The latter is limited to
45°, and to the error at which P_yaw commands full scale:

    ω_sp = sqrtP(e; ATC_ANG_P, ATC_ACC_MAX / 2 within 40 .. 720 °/s², yaw 10 .. 120) + ω_t
           ω_t and yaw's FF fade out from 30° of thrust error; there is no yaw control from 60°
    e_f  = LPF_FLTE(LPF_FLTT(ω_sp) - ω),   τ = P e_f + I + D LPF_FLTD(de_f/dt) + FF LPF_FLTT(ω_sp)
    dI/dt = I e_f, within IMAX; only towards 0 while the mixer saturates

ω has passed INS_GYRO_FILTER. Motor signals follow from τ and F, see
`extras/autopilots/mixers.py`; a speed controller converts a full signal to `motor_speed`.

Source: ArduPilot, AC_PosControl.cpp, AC_AttitudeControl.cpp, AC_AttitudeControl_Multi.cpp,
AC_PID.cpp, AP_Math/control.cpp. docs/autopilots.md lists omissions.
"""

import math

import numpy as np

from workbench.control.law_constants import known_vehicle, law_constants
from workbench.control.quaternions import (
    canonical,
    inverse,
    normalized,
    product,
    rotated,
    shortest_turn,
    small_turn,
    tilt_vector,
    upright,
)
from workbench.controllers import (
    GRAVITY,
    POSITION_POINT,
    VELOCITY_POINT,
    Gains,
    KnownBody,
    KnownVehicle,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
    Probes,
    State,
    Vector3,
    arctan2,
    attitude_matrix,
    between,
    clipped,
    gain,
    into_body,
    position_error,
    probe,
    probe3,
    probe_tilt,
    states,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.extras.autopilots.ardupilot_mixer import ardupilot_actuator, ardupilot_mixed
from workbench.extras.autopilots.filters import (
    LOWPASS_COEFFICIENTS,
    butterworth,
    first_order,
    second_order_filtered,
)
from workbench.extras.autopilots.loop_stages import (
    ATTITUDE_STAGE_POINT,
    RATE_SETPOINT_POINT,
    RATE_STAGE_POINT,
    TILT_SETPOINT_POINT,
    TORQUE_STAGE_POINT,
    stage_loops,
    stage_points,
)
from workbench.extras.autopilots.mixers import (
    MAX_MIXER_MOTORS,
    MIXER_NUMBER_NAMES,
    column_numbers,
    effects_per_thrust,
    flies_with_defaults,
    hover_authority,
    mixer_columns,
    moment_shares,
    with_motor,
)
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

PERIOD = 1 / 512
ONE_DEGREE_RAD = math.pi / 180.0
THROTTLE_CUTOFF_HZ = 2.0
"""Cut-off of the throttle's low-pass (POSCONTROL_THROTTLE_CUTOFF_FREQ_HZ) [Hz]."""
DEFAULT_INPUT_TC_S = 0.1
"""Default of ATC_INPUT_TC [s]."""
MIN_TARGET_TC_S = 0.01
"""Smallest time constant of the attitude target [s]."""
JERK_LIMIT_VERSION = 4.65
"""Versions above this limit the jerk of the attitude target."""
YAW_RATE_TC_S = 0.025
"""Time constant of the shaped yaw rate: PILOT_Y_RATE_TC 0 is ten of ArduPilot's loops [s]."""
NO_LIMIT_RAD_S2 = 1800.0 * ONE_DEGREE_RAD
"""Limit of the target's acceleration if ATC_ACC_MAX is 0 [rad/s²]."""
YAW_FADING_ERROR_RAD = 30.0 * ONE_DEGREE_RAD
"""Thrust error from which yaw control fades; at twice that it is off [rad]."""
MAX_HEADING_ERROR_RAD = 45.0 * ONE_DEGREE_RAD
"""Largest error of heading [rad]."""

ARDUPILOT_MIXER = (0.5, "ArduPilot's mixer")
"""Largest factor of the mixer, and its name."""
DEFAULT_THRUST_EXPO, DEFAULT_SPIN_MIN, DEFAULT_SPIN_MAX = 0.65, 0.15, 0.95
"""Defaults of MOT_THST_EXPO, MOT_SPIN_MIN and MOT_SPIN_MAX."""

_ARDUPILOT_AXES = (("RLL", "roll"), ("PIT", "pitch"), ("YAW", "yaw"))
PARAMETERS = (
    gain("PSC_NE_POS_P", "1/s", (0.0, 20.0), 1.0, "position P gain, horizontal", "NE"),
    gain("PSC_NE_VEL_P", "1/s", (0.0, 50.0), 2.0, "velocity P gain, horizontal", "NE"),
    gain("PSC_NE_VEL_I", "1/s^2", (0.0, 50.0), 1.0, "velocity I gain, horizontal", "NE"),
    gain("PSC_NE_VEL_D", "1", (0.0, 10.0), 0.25, "velocity D gain, horizontal", "NE"),
    gain("PSC_NE_VEL_IMAX", "m/s^2", (0.0, 100.0), 10.0, "velocity I limit, horizontal", "NE"),
    gain("PSC_NE_VEL_FLTE", "Hz", (0.0, 1000.0), 5.0, "velocity error filter, horizontal", "NE"),
    gain("PSC_NE_VEL_FLTD", "Hz", (0.0, 1000.0), 5.0, "velocity D filter, horizontal", "NE"),
    gain("WP_SPD", "m/s", (0.01, 100.0), 10.0, "maximum horizontal speed", "NE"),
    gain("WP_ACC", "m/s^2", (0.0, 100.0), 2.5, "maximum horizontal deceleration", "NE"),
    gain("PSC_D_POS_P", "1/s", (0.0, 20.0), 1.0, "position P gain, vertical", "D"),
    gain("PSC_D_VEL_P", "1/s", (0.0, 50.0), 5.0, "velocity P gain, vertical", "D"),
    gain("PSC_D_VEL_I", "1/s^2", (0.0, 50.0), 0.0, "velocity I gain, vertical", "D"),
    gain("PSC_D_VEL_D", "1", (0.0, 10.0), 0.0, "velocity D gain, vertical", "D"),
    gain("PSC_D_VEL_IMAX", "m/s^2", (0.0, 100.0), 10.0, "velocity I limit, vertical", "D"),
    gain("PSC_D_VEL_FLTE", "Hz", (0.0, 1000.0), 5.0, "velocity error filter, vertical", "D"),
    gain("PSC_D_VEL_FLTD", "Hz", (0.0, 1000.0), 5.0, "velocity D filter, vertical", "D"),
    gain("PSC_D_ACC_P", "s^2/m", (0.0, 1.0), 0.05, "acceleration P gain, vertical", "D"),
    gain("PSC_D_ACC_I", "s/m", (0.0, 3.0), 0.1, "acceleration I gain, vertical", "D"),
    gain("PSC_D_ACC_D", "s^3/m", (0.0, 1.0), 0.0, "acceleration D gain, vertical", "D"),
    gain("PSC_D_ACC_FF", "s^2/m", (0.0, 1.0), 0.0, "acceleration feedforward, vertical", "D"),
    gain("PSC_D_ACC_IMAX", "1", (0.0, 10.0), 0.8, "acceleration I limit, vertical", "D"),
    gain("PSC_D_ACC_FLTT", "Hz", (0.0, 1000.0), 0.0, "acceleration target filter, vertical", "D"),
    gain("PSC_D_ACC_FLTE", "Hz", (0.0, 1000.0), 20.0, "acceleration error filter, vertical", "D"),
    gain("PSC_D_ACC_FLTD", "Hz", (0.0, 1000.0), 0.0, "acceleration D filter, vertical", "D"),
    gain("WP_SPD_UP", "m/s", (0.01, 50.0), 2.5, "maximum climb rate", "D"),
    gain("WP_SPD_DN", "m/s", (0.01, 50.0), 1.5, "maximum descent rate", "D"),
    gain("WP_ACC_Z", "m/s^2", (0.0, 100.0), 1.0, "maximum vertical deceleration", "D"),
    gain("ATC_ANGLE_MAX", "deg", (10.0, 80.0), 30.0, "maximum tilt", "Attitude"),
    *(
        gain(f"ATC_ANG_{name}_P", "1/s", (0.0, 100.0), 4.5, f"attitude P gain, {axis}", "Attitude")
        for name, axis in _ARDUPILOT_AXES
    ),
    gain("ATC_ACC_R_MAX", "deg/s^2", (0.0, 9999.0), 1100.0, "roll acceleration limit", "Attitude"),
    gain("ATC_ACC_P_MAX", "deg/s^2", (0.0, 9999.0), 1100.0, "pitch acceleration limit", "Attitude"),
    gain("ATC_ACC_Y_MAX", "deg/s^2", (0.0, 9999.0), 270.0, "yaw acceleration limit", "Attitude"),
    gain("ATC_RATE_R_MAX", "deg/s", (0.0, 4000.0), 0.0, "roll rate limit, 0 off", "Attitude"),
    gain("ATC_RATE_P_MAX", "deg/s", (0.0, 4000.0), 0.0, "pitch rate limit, 0 off", "Attitude"),
    gain("ATC_RATE_Y_MAX", "deg/s", (0.0, 4000.0), 0.0, "yaw rate limit, 0 off", "Attitude"),
    gain("ATC_RATE_FF_ENAB", "1", (0.0, 1.0), 1.0, "1: shaped target and its rate", "Attitude"),
    gain("ATC_INPUT_TC", "s", (0.0, 10.0), DEFAULT_INPUT_TC_S, "target time constant", "Attitude"),
    gain("ATC_ANGLE_BOOST", "1", (0.0, 1.0), 1.0, "1: more throttle when tilted", "Attitude"),
    *(
        gain(f"ATC_RAT_{name}_{term}", each, limits, value, f"{axis} rate {what}", "Rate")
        for (name, axis), values in zip(
            _ARDUPILOT_AXES,
            (
                (0.135, 0.135, 0.0036, 0.0, 0.5, 20.0, 0.0, 20.0),
                (0.135, 0.135, 0.0036, 0.0, 0.5, 20.0, 0.0, 20.0),
                (0.18, 0.018, 0.0, 0.0, 0.5, 20.0, 2.5, 20.0),
            ),
            strict=True,
        )
        for (term, each, limits, what), value in zip(
            (
                ("P", "s/rad", (0.0, 5.0), "P gain"),
                ("I", "1/rad", (0.0, 10.0), "I gain"),
                ("D", "s^2/rad", (0.0, 0.5), "D gain"),
                ("FF", "s/rad", (0.0, 0.5), "feedforward"),
                ("IMAX", "1", (0.0, 10.0), "integrator limit"),
                ("FLTT", "Hz", (0.0, 1000.0), "target filter"),
                ("FLTE", "Hz", (0.0, 1000.0), "error filter"),
                ("FLTD", "Hz", (0.0, 1000.0), "D filter"),
            ),
            values,
            strict=True,
        )
    ),
    gain("INS_GYRO_FILTER", "Hz", (0.0, 256.0), 20.0, "gyro low-pass cutoff", "Rate"),
    gain("ATC_THR_MIX_MAX", "1", (0.1, 5.0), 0.5, "attitude priority over throttle", "Motors"),
    gain("MOT_YAW_HEADROOM", "1", (0.0, 1000.0), 200.0, "yaw headroom, thousandths", "Motors"),
    gain("MOT_THST_HOVER", "1", (0.0, 1.0), 0.35, "hover throttle", "Motors"),
    gain("MOT_THST_EXPO", "1", (-1.0, 1.0), DEFAULT_THRUST_EXPO, "thrust curve expo", "Motors"),
    gain("MOT_SPIN_MIN", "1", (0.0, 0.5), DEFAULT_SPIN_MIN, "minimum motor signal", "Motors"),
    gain("MOT_SPIN_MAX", "1", (0.5, 1.0), DEFAULT_SPIN_MAX, "maximum motor signal", "Motors"),
    gain("motor_speed", "rad/s", (1.0, 20000.0), 1000.0, "motor speed at full signal", "Motors"),
    gain("firmware", "1", (4.3, 99.0), 4.7, "version that is computed", "Firmware"),
)

MEMORY = (
    *states("i_velocity", "m/s^2"),
    *states("e_velocity", "m/s"),
    *states("d_velocity", "m/s^2"),
    *states("cut", "m/s^2", "xy"),
    State("attitude_w", "1", 1.0),
    *states("attitude", "1"),
    *states("target_rate", "rad/s"),
    *states("target_slope", "rad/s^2"),
    *states("gyro_1", "rad/s"),
    *states("gyro_2", "rad/s"),
    *states("wanted", "rad/s"),
    *states("e_rate", "rad/s"),
    *states("d_rate", "rad/s^2"),
    *states("i_rate", "1"),
    State("target_climb", "m/s^2"),
    State("e_climb", "m/s^2"),
    State("d_climb", "m/s^3"),
    State("i_climb", "1"),
    State("throttle", "1"),
    State("cut_tilt", "1"),
    State("cut_yaw", "1"),
    State("least", "1"),
    State("most", "1"),
    State("runs", "1"),
)

POINTS = stage_points("rad", "1")

_ARDUPILOT_LEVEL_GAINS = tuple(f"PSC_NE_VEL_{each}" for each in "PID")
_ARDUPILOT_CLIMB_GAINS = ("PSC_D_VEL_P", "PSC_D_ACC_P", "PSC_D_ACC_I")
LOOPS = stage_loops(
    (("PSC_NE_POS_P",), ("PSC_NE_POS_P",), ("PSC_D_POS_P",)),
    (_ARDUPILOT_LEVEL_GAINS, _ARDUPILOT_LEVEL_GAINS, _ARDUPILOT_CLIMB_GAINS),
    [(f"ATC_ANG_{name}_P",) for name, _ in _ARDUPILOT_AXES],
    [tuple(f"ATC_RAT_{name}_{term}" for term in "PID") for name, _ in _ARDUPILOT_AXES],
)

_FIRST_ORDER_CUTOFFS = (
    "PSC_NE_VEL_FLTE",
    "PSC_NE_VEL_FLTD",
    "PSC_D_VEL_FLTE",
    "PSC_D_VEL_FLTD",
    "PSC_D_ACC_FLTT",
    "PSC_D_ACC_FLTE",
    "PSC_D_ACC_FLTD",
    *(f"ATC_RAT_{name}_{each}" for name, _ in _ARDUPILOT_AXES for each in ("FLTT", "FLTE", "FLTD")),
)
"""Cut-offs of first-order low-passes; `design` returns the gain `k_...` of each."""
DESIGNED = (
    *MIXER_NUMBER_NAMES,
    *(f"gyro_{name}" for name in LOWPASS_COEFFICIENTS),
    *(f"k_{name}" for name in _FIRST_ORDER_CUTOFFS),
    "k_throttle",
    "most_level",
    *(f"angle_slope_{axis}" for axis in "xyz"),
    *(f"target_slope_{axis}" for axis in "xyz"),
    "most_heading",
    "motor_constant",
    "linear_speed",
)


def design(vehicle: KnownVehicle, g: Gains, dt: float) -> list[float]:
    """Return factors of the mixer, gains of low-passes, limits, and motor constants."""
    angle_slopes = [
        ONE_DEGREE_RAD * min(max(0.5 * most, least), largest) if most > 0.0 else 0.0
        for most, least, largest in (
            (g.ATC_ACC_R_MAX, 40.0, 720.0),
            (g.ATC_ACC_P_MAX, 40.0, 720.0),
            (g.ATC_ACC_Y_MAX, 10.0, 120.0),
        )
    ]
    target_slopes = [
        ONE_DEGREE_RAD * most if most > 0.0 else NO_LIMIT_RAD_S2
        for most in (g.ATC_ACC_R_MAX, g.ATC_ACC_P_MAX, g.ATC_ACC_Y_MAX)
    ]
    return [
        *column_numbers(vehicle.rotors, moment_shares(vehicle.rotors, *ARDUPILOT_MIXER)),
        *butterworth(g.INS_GYRO_FILTER, dt),
        *(first_order(getattr(g, name), dt) for name in _FIRST_ORDER_CUTOFFS),
        first_order(THROTTLE_CUTOFF_HZ, dt),
        GRAVITY * math.tan(ONE_DEGREE_RAD * g.ATC_ANGLE_MAX),
        *angle_slopes,
        *target_slopes,
        heading_limit(g.ATC_RAT_YAW_P, g.ATC_ANG_YAW_P, angle_slopes[2]),
        vehicle.rotors[0].motor_constant,
        vehicle.rotors[0].linear_speed,
    ]


def heading_limit(rate_p: float, angle_p: float, slope: float) -> float:
    """Return the heading error at which the yaw rate's P commands full scale [rad].

    Args:
        rate_p: ATC_RAT_YAW_P.
        angle_p: ATC_ANG_YAW_P [1/s].
        slope: of the rate asked for, 0 without a limit [rad/s²].

    Returns:
        The error; half a turn, and so no limit, where one of the gains is 0.
    """
    if rate_p <= 0.0 or angle_p <= 0.0:
        return math.pi
    rate = 1.0 / rate_p
    if slope <= 0.0 or rate < slope / angle_p:
        return min(rate / angle_p, MAX_HEADING_ERROR_RAD)
    return min(0.5 * slope / angle_p**2 + 0.5 * rate * rate / slope, MAX_HEADING_ERROR_RAD)


def sqrt_p(e: float, k: float, slope: float, dt: float) -> float:
    """Return ArduPilot's square-root controller of an error.

    Args:
        e: error.
        k: gain near 0, 0 for the root alone [1/s].
        slope: limit of the slope of its output; 0 for none.
        dt: time in which the root alone corrects at most the error; 0 for no such limit [s].
    """
    if slope <= 0.0:
        return k * e
    line = slope / (k * k) if k > 0.0 else 0.0 * k
    ahead = e if e > 0.0 else -e
    if k <= 0.0 and ahead < 2.0 * slope * dt * dt:
        return e / dt
    if e > line:
        return (2.0 * slope * (e - 0.5 * line)) ** 0.5
    if e < -line:
        return -((2.0 * slope * (-e - 0.5 * line)) ** 0.5)
    return k * e


def sqrt_p_level(x: float, y: float, k: float, slope: float, most: float) -> tuple[float, float]:
    """Return the square-root controller along a level error, within a length where k is not 0."""
    squared = x * x + y * y
    line = slope / (k * k) if slope > 0.0 and k > 0.0 else 0.0 * k
    b_x, b_y = k * x, k * y
    if slope > 0.0 and squared > line * line:
        length = squared**0.5
        scale = sqrt_p(length, k, slope, 0.0) / length
        b_x, b_y = scale * x, scale * y
    squared = b_x * b_x + b_y * b_y
    if k > 0.0 and squared > most * most:
        scale = most / squared**0.5
        b_x, b_y = scale * b_x, scale * b_y
    return b_x, b_y


def shaped_rate(
    e: float, rate: float, slope: float, k: float, most: float, limit: float, dt: float
) -> tuple[float, float]:
    """Return rate and slope of the attitude target about an axis after an update, see above.

    Args:
        e: error of the target [rad].
        rate: of the target [rad/s].
        slope: of that rate [rad/s²].
        k: 1 / ATC_INPUT_TC [1/s].
        most: largest slope [rad/s²].
        limit: largest rate, 0 for any [rad/s].
        dt: since the update before [s].
    """
    wanted = sqrt_p(e, k, most, 0.0)
    ahead = wanted if wanted > 0.0 else -wanted
    wanted = wanted - (rate if k * ahead <= most else most / (k * ahead) * rate)
    if limit > 0.0:
        wanted = clipped(wanted, limit)
    asked = clipped(k * (wanted - rate), most)
    slope = slope + clipped(asked - slope, k * most * dt)
    return rate + slope * dt, slope


def shaped_yaw_rate(
    asked: float, rate: float, slope: float, most: float, dt: float
) -> tuple[float, float]:
    """Return yaw rate and slope of the attitude target after an update; see `shaped_rate`."""
    wanted = clipped((asked - rate) / YAW_RATE_TC_S, most)
    slope = slope + clipped(wanted - slope, most / YAW_RATE_TC_S * dt)
    return rate + slope * dt, slope


def eased_rate(wanted: float, rate: float, most: float, dt: float) -> float:
    """Return a rate of the attitude target after an update, of versions up to 4.6.

    Args:
        wanted: the rate asked for [rad/s].
        rate: before [rad/s].
        most: largest slope, 0 for any [rad/s²].
        dt: since the update before [s].
    """
    return rate + clipped(wanted - rate, most * dt) if most > 0.0 else wanted


def within_rates(w: Vector3, most_x: float, most_y: float, most_z: float) -> Vector3:
    """Return rates within ATC_RATE_MAX, 0 for any: roll and pitch within an ellipse."""
    x, y, z = w
    if most_x > 0.0 and most_y > 0.0:
        size = x * x / (most_x * most_x) + y * y / (most_y * most_y)
        if size > 1.0:
            x, y = x / size**0.5, y / size**0.5
    elif most_x > 0.0:
        x = clipped(x, most_x)
    elif most_y > 0.0:
        y = clipped(y, most_y)
    if most_z > 0.0:
        z = clipped(z, most_z)
    return x, y, z


def next_axis_integral(
    integral: float, e: float, slope: float, cut: float, most: float, dt: float
) -> float:
    """Return an integral after an update; while its output is limited, it may only shrink.

    Args:
        integral: before.
        e: filtered error.
        slope: growth per error.
        cut: above 0.5 if the output was limited.
        most: its limit.
        dt: since the update before [s].
    """
    if slope <= 0.0:
        return 0.0 * integral
    if cut > 0.5 and integral * e >= 0.0:
        return integral
    return clipped(integral + slope * e * dt, most)


def next_level_integrals(
    i_x: float, i_y: float, by: tuple[float, float], cut: tuple[float, float], most: float
) -> tuple[float, float]:
    """Return the horizontal integrals after an update.

    Args:
        i_x: before.
        i_y: before.
        by: growth, x and y.
        cut: acceleration that was limited, x and y: towards it they may turn, but not grow.
        most: their largest length.
    """
    x, y = i_x + by[0], i_y + by[1]
    before, size = i_x * i_x + i_y * i_y, x * x + y * y
    if by[0] * cut[0] + by[1] * cut[1] > 0.0 and size > before:
        scale = (before / size) ** 0.5
        x, y, size = scale * x, scale * y, before
    if size > most * most:
        scale = most / size**0.5
        x, y = scale * x, scale * y
    return x, y


def update(
    measured: MeasuredMotion,
    setpoint: LawSetpoint,
    g: Gains,
    vehicle: KnownBody,
    memory: Memory,
    dt: float,
    loops: Probes,
) -> LawResult:
    """Return the wrench in T, F [N] and m [N·m], and the memory."""
    m, v, first = memory, measured.v_WBcm, memory.runs < 0.5
    q = normalized(measured.q_WT)
    R = attitude_matrix(q)

    # position to velocity
    x, y, z = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    b_x, b_y = sqrt_p_level(x, y, g.PSC_NE_POS_P, g.WP_ACC, g.WP_SPD)
    b_z = sqrt_p(z, g.PSC_D_POS_P, g.WP_ACC_Z, 0.0)
    if g.PSC_D_POS_P > 0.0:
        b_z = between(b_z, -g.WP_SPD_DN, g.WP_SPD_UP)
    s_x, s_y, s_z, yaw_rate = velocity_setpoint((b_x, b_y, b_z), measured, setpoint, g)

    # velocity to acceleration
    e = probe3((s_x - v[0], s_y - v[1], s_z - v[2]), VELOCITY_POINT, loops)
    before = (m.e_velocity_x, m.e_velocity_y, m.e_velocity_z)
    slope = (m.d_velocity_x, m.d_velocity_y, m.d_velocity_z)
    if first:
        before = e
    e_x = before[0] + g.k_PSC_NE_VEL_FLTE * (e[0] - before[0])
    e_y = before[1] + g.k_PSC_NE_VEL_FLTE * (e[1] - before[1])
    e_z = before[2] + g.k_PSC_D_VEL_FLTE * (e[2] - before[2])
    e_velocity = (e_x, e_y, e_z)
    d_x = slope[0] + g.k_PSC_NE_VEL_FLTD * ((e_x - before[0]) / dt - slope[0])
    d_y = slope[1] + g.k_PSC_NE_VEL_FLTD * ((e_y - before[1]) / dt - slope[1])
    d_z = slope[2] + g.k_PSC_D_VEL_FLTD * ((e_z - before[2]) / dt - slope[2])
    d_velocity = (d_x, d_y, d_z)
    ahead = setpoint.a_WBcm
    growth = g.PSC_NE_VEL_I * e_x * dt, g.PSC_NE_VEL_I * e_y * dt
    i_x, i_y = next_level_integrals(
        m.i_velocity_x, m.i_velocity_y, growth, (m.cut_x, m.cut_y), g.PSC_NE_VEL_IMAX
    )
    i_z = m.i_velocity_z
    if not ((m.least > 0.5 and e_z < 0.0) or (m.most > 0.5 and e_z > 0.0)):
        i_z = clipped(i_z + g.PSC_D_VEL_I * e_z * dt, g.PSC_D_VEL_IMAX)
    a_x = g.PSC_NE_VEL_P * e_x + i_x + g.PSC_NE_VEL_D * d_x + ahead[0]
    a_y = g.PSC_NE_VEL_P * e_y + i_y + g.PSC_NE_VEL_D * d_y + ahead[1]
    a_z = g.PSC_D_VEL_P * e_z + i_z + g.PSC_D_VEL_D * d_z + ahead[2]
    level, cut_x, cut_y = a_x * a_x + a_y * a_y, 0.0 * a_x, 0.0 * a_y
    if level > g.most_level * g.most_level:
        cut_x, cut_y, shrink = a_x, a_y, g.most_level / level**0.5
        a_x, a_y = shrink * a_x, shrink * a_y

    # vertical acceleration to throttle
    climb = a_z if first else m.target_climb + g.k_PSC_D_ACC_FLTT * (a_z - m.target_climb)
    e_c = climb - measured.a_WBcm[2]
    e_before = e_c if first else m.e_climb
    e_c = e_before + g.k_PSC_D_ACC_FLTE * (e_c - e_before)
    d_c = m.d_climb + g.k_PSC_D_ACC_FLTD * ((e_c - e_before) / dt - m.d_climb)
    hover, most_i = g.MOT_THST_HOVER, g.PSC_D_ACC_IMAX
    most_i = most_i if most_i > hover else hover
    i_c = next_axis_integral(m.i_climb, e_c, g.PSC_D_ACC_I, m.least + m.most, most_i, dt)
    throttle = g.PSC_D_ACC_P * e_c + i_c + g.PSC_D_ACC_D * d_c + g.PSC_D_ACC_FF * climb + hover

    # rates, filtered
    w = into_body(R, measured.w_WB)
    one, two = (m.gyro_1_x, m.gyro_1_y, m.gyro_1_z), (m.gyro_2_x, m.gyro_2_y, m.gyro_2_z)
    if first:
        share = 1.0 / (1.0 + g.gyro_a1 + g.gyro_a2)
        one = (share * w[0], share * w[1], share * w[2])
        two = one
    gyro, latest = second_order_filtered(
        w, one, two, (g.gyro_b0, g.gyro_b1, g.gyro_b2, g.gyro_a1, g.gyro_a2)
    )

    # attitude target
    a_x, a_y, _ = probe_tilt((a_x, a_y, GRAVITY), R, TILT_SETPOINT_POINT, loops)
    length = (a_x * a_x + a_y * a_y + GRAVITY * GRAVITY) ** 0.5
    up = (a_x / length, a_y / length, GRAVITY / length)
    q_t = (m.attitude_w, m.attitude_x, m.attitude_y, m.attitude_z)
    t_x, t_y, t_z = m.target_rate_x, m.target_rate_y, m.target_rate_z
    u_x, u_y, u_z = m.target_slope_x, m.target_slope_y, m.target_slope_z
    if first:
        q_t = q
    q_t = normalized(product(q_t, small_turn(t_x * dt, t_y * dt, t_z * dt)))
    towards_up = rotated(inverse(q_t), up)
    if g.ATC_RATE_FF_ENAB > 0.5:
        g_x, g_y, _ = tilt_vector(towards_up)
        k = 1.0 / (g.ATC_INPUT_TC if g.ATC_INPUT_TC > MIN_TARGET_TC_S else MIN_TARGET_TC_S)
        r_x, r_y, r_z = (
            ONE_DEGREE_RAD * g.ATC_RATE_R_MAX,
            ONE_DEGREE_RAD * g.ATC_RATE_P_MAX,
            ONE_DEGREE_RAD * g.ATC_RATE_Y_MAX,
        )
        if g.firmware > JERK_LIMIT_VERSION:
            t_x, u_x = shaped_rate(g_x, t_x, u_x, k, g.target_slope_x, r_x, dt)
            t_y, u_y = shaped_rate(g_y, t_y, u_y, k, g.target_slope_y, r_y, dt)
            t_z, u_z = shaped_yaw_rate(yaw_rate, t_z, u_z, g.target_slope_z, dt)
        else:
            most = ONE_DEGREE_RAD * g.ATC_ACC_R_MAX
            t_x = eased_rate(sqrt_p(g_x, k, most, 0.0), t_x, most, dt)
            most = ONE_DEGREE_RAD * g.ATC_ACC_P_MAX
            t_y = eased_rate(sqrt_p(g_y, k, most, 0.0), t_y, most, dt)
            t_z = eased_rate(yaw_rate, t_z, ONE_DEGREE_RAD * g.ATC_ACC_Y_MAX, dt)
            t_x, t_y, t_z = within_rates((t_x, t_y, t_z), r_x, r_y, r_z)
            u_x, u_y, u_z = 0.0 * u_x, 0.0 * u_y, 0.0 * u_z
    else:
        turn = small_turn(0.0 * t_x, 0.0 * t_y, yaw_rate * dt)
        q_t = normalized(product(product(q_t, shortest_turn((0.0, 0.0, 1.0), towards_up)), turn))
        t_x, t_y, t_z = 0.0 * t_x, 0.0 * t_y, 0.0 * t_z
        u_x, u_y, u_z = 0.0 * u_x, 0.0 * u_y, 0.0 * u_z

    # attitude to rates: the thrust vector first, then the heading
    away = product(inverse(q), q_t)
    n = upright(away)
    e_x, e_y, angle = tilt_vector(n)
    corrected = shortest_turn((0.0, 0.0, 1.0), n)
    rest = canonical(product(inverse(corrected), away))
    e_z = 2.0 * arctan2(rest[3], rest[0])
    if e_z > g.most_heading or e_z < -g.most_heading:
        e_z = clipped(e_z, g.most_heading)
        away = normalized(product(corrected, small_turn(0.0 * e_z, 0.0 * e_z, e_z)))
        q_t = normalized(product(q, away))
    e_x, e_y, e_z = probe3((e_x, e_y, e_z), ATTITUDE_STAGE_POINT, loops)
    r_x = sqrt_p(e_x, g.ATC_ANG_RLL_P, g.angle_slope_x, dt)
    r_y = sqrt_p(e_y, g.ATC_ANG_PIT_P, g.angle_slope_y, dt)
    r_z = sqrt_p(e_z, g.ATC_ANG_YAW_P, g.angle_slope_z, dt)
    r_x, r_y, r_z = within_rates(
        (r_x, r_y, r_z),
        ONE_DEGREE_RAD * g.ATC_RATE_R_MAX,
        ONE_DEGREE_RAD * g.ATC_RATE_P_MAX,
        ONE_DEGREE_RAD * g.ATC_RATE_Y_MAX,
    )
    f_x, f_y, f_z = rotated(away, (t_x, t_y, t_z))
    fading = 1.0 + 0.0 * angle
    if angle > 2.0 * YAW_FADING_ERROR_RAD:
        r_z = gyro[2]
    elif angle > YAW_FADING_ERROR_RAD:
        fading = 2.0 - angle / YAW_FADING_ERROR_RAD
        r_x, r_y = r_x + fading * f_x, r_y + fading * f_y
        r_z = (1.0 - fading) * gyro[2] + fading * (r_z + f_z)
    else:
        r_x, r_y, r_z = r_x + f_x, r_y + f_y, r_z + f_z

    # rates to torques
    r_x = probe(r_x, RATE_SETPOINT_POINT, loops)
    r_y = probe(r_y, RATE_SETPOINT_POINT + 1, loops)
    s = (m.wanted_x, m.wanted_y, m.wanted_z)
    if first:
        s = (r_x, r_y, r_z)
    s_p = s[0] + g.k_ATC_RAT_RLL_FLTT * (r_x - s[0])
    s_q = s[1] + g.k_ATC_RAT_PIT_FLTT * (r_y - s[1])
    s_r = s[2] + g.k_ATC_RAT_YAW_FLTT * (r_z - s[2])
    e = probe3((s_p - gyro[0], s_q - gyro[1], s_r - gyro[2]), RATE_STAGE_POINT, loops)
    was = (m.e_rate_x, m.e_rate_y, m.e_rate_z)
    if first:
        was = e
    e_p = was[0] + g.k_ATC_RAT_RLL_FLTE * (e[0] - was[0])
    e_q = was[1] + g.k_ATC_RAT_PIT_FLTE * (e[1] - was[1])
    e_r = was[2] + g.k_ATC_RAT_YAW_FLTE * (e[2] - was[2])
    d_p = m.d_rate_x + g.k_ATC_RAT_RLL_FLTD * ((e_p - was[0]) / dt - m.d_rate_x)
    d_q = m.d_rate_y + g.k_ATC_RAT_PIT_FLTD * ((e_q - was[1]) / dt - m.d_rate_y)
    d_r = m.d_rate_z + g.k_ATC_RAT_YAW_FLTD * ((e_r - was[2]) / dt - m.d_rate_z)
    i_p = next_axis_integral(m.i_rate_x, e_p, g.ATC_RAT_RLL_I, m.cut_tilt, g.ATC_RAT_RLL_IMAX, dt)
    i_q = next_axis_integral(m.i_rate_y, e_q, g.ATC_RAT_PIT_I, m.cut_tilt, g.ATC_RAT_PIT_IMAX, dt)
    i_r = next_axis_integral(m.i_rate_z, e_r, g.ATC_RAT_YAW_I, m.cut_yaw, g.ATC_RAT_YAW_IMAX, dt)
    roll = g.ATC_RAT_RLL_P * e_p + i_p + g.ATC_RAT_RLL_D * d_p + g.ATC_RAT_RLL_FF * s_p
    pitch = g.ATC_RAT_PIT_P * e_q + i_q + g.ATC_RAT_PIT_D * d_q + g.ATC_RAT_PIT_FF * s_q
    yaw = g.ATC_RAT_YAW_P * e_r + i_r + g.ATC_RAT_YAW_D * d_r + fading * g.ATC_RAT_YAW_FF * s_r
    roll, pitch, yaw = probe3((roll, pitch, yaw), TORQUE_STAGE_POINT, loops)

    # throttle in a tilt, mixer and motors
    boosted = throttle
    if g.ATC_ANGLE_BOOST > 0.5:
        boosted = throttle * between(10.0 * R[8], 0.0, 1.0)
        boosted = boosted / between(R[8], 0.1, 1.0)
    average = boosted if boosted > throttle else throttle
    average = between(average, 0.0, 1.0)
    rest = 1.0 - g.ATC_THR_MIX_MAX
    raised = g.ATC_THR_MIX_MAX * hover + (average * rest if rest > 0.0 else 0.0 * average)
    average = raised if raised > average else average
    given = boosted if first else m.throttle + g.k_throttle * (boosted - m.throttle)
    given = between(given, 0.0, 1.0)
    u, (cut_tilt, cut_yaw, least, most) = ardupilot_mixed(
        (roll, pitch, yaw, given), average, 0.001 * g.MOT_YAW_HEADROOM, mixer_columns(g)
    )
    none = 0.0 * given
    wrench, by = (none, none, none, none), effects_per_thrust(g)
    for i in range(MAX_MIXER_MOTORS):
        signal = ardupilot_actuator(u[i], g.MOT_THST_EXPO, g.MOT_SPIN_MIN, g.MOT_SPIN_MAX)
        speed = g.motor_speed * signal
        wrench = with_motor(wrench, i, g.motor_constant * speed * (speed + g.linear_speed), by)
    outer = (i_x, i_y, i_z, *e_velocity, *d_velocity, cut_x, cut_y)
    target = (*q_t, t_x, t_y, t_z, u_x, u_y, u_z)
    inner = (*latest, *one, s_p, s_q, s_r, e_p, e_q, e_r, d_p, d_q, d_r, i_p, i_q, i_r)
    vertical = (climb, e_c, d_c, i_c, given)
    cut = (cut_tilt, cut_yaw, least, most)
    return wrench, (*outer, *target, *inner, *vertical, *cut, 1.0 + none)


X500_ANGULAR_ACCELERATION = (113.0, 113.0, 5.6)
"""Angular acceleration of PX4's X500 in Gazebo over roll, pitch and yaw, in hover [rad/s²]."""
X500_RATE_P = 15.3
"""Its roll rate P with ArduPilot's defaults [1/s]."""
X500_LIFT = 15.0
"""Its vertical acceleration over throttle, in hover [m/s²]."""


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return values for a vehicle: motors, hover throttle, and gains unless it is like an X500.

    The gains are those of the PD cascade in this form: rate P = kd, attitude P = 0.3 kd, integrals
    and derivatives in the proportions of ArduPilot's defaults, integrals slower for a slower loop.
    Cut-offs grow with a rate loop faster than that of the X500, and the target's time constant
    grows with a slower one.
    """
    pd, frame = pd_rule(vehicle), thrust_frame(vehicle)
    fastest = vehicle.rotors[0].max_rot_velocity
    rotors = known_vehicle(law_constants(vehicle)).rotors
    mix = moment_shares(rotors, *ARDUPILOT_MIXER)
    signals = np.clip(frame.hover_speeds / fastest, DEFAULT_SPIN_MIN, DEFAULT_SPIN_MAX)
    ratios = (signals - DEFAULT_SPIN_MIN) / (DEFAULT_SPIN_MAX - DEFAULT_SPIN_MIN)
    shares = DEFAULT_THRUST_EXPO * ratios**2 + (1.0 - DEFAULT_THRUST_EXPO) * ratios
    per_share = (
        (DEFAULT_SPIN_MAX - DEFAULT_SPIN_MIN)
        * fastest
        / (2.0 * DEFAULT_THRUST_EXPO * ratios + 1.0 - DEFAULT_THRUST_EXPO)
    )
    *turned, force = hover_authority(rotors, frame, mix, per_share).tolist()
    lift = force / vehicle.mass
    values = {"MOT_THST_HOVER": float(np.mean(shares)), "motor_speed": fastest}
    if all(flies_with_defaults((*turned, lift), (*X500_ANGULAR_ACCELERATION, X500_LIFT))):
        return values
    for (name, axis), kp, place in zip(
        _ARDUPILOT_AXES, ("kd_roll", "kd_pitch", "kp_yaw_rate"), range(3), strict=True
    ):
        rate = pd[kp] / turned[place]
        values[f"ATC_RAT_{name}_P"] = rate
        values[f"ATC_RAT_{name}_I"] = rate * (
            0.1 if axis == "yaw" else min(1.0, pd[kp] / X500_RATE_P)
        )
        values[f"ATC_RAT_{name}_D"] = (0.0 if axis == "yaw" else 0.0267) * rate
        values[f"ATC_ANG_{name}_P"] = 0.3 * pd[kp]
    faster = min(pd["kd_roll"], pd["kd_pitch"]) / X500_RATE_P
    opened = 20.0 * min(max(1.0, faster), 10.0)
    values["INS_GYRO_FILTER"] = opened
    for name, _ in _ARDUPILOT_AXES[:2]:
        values[f"ATC_RAT_{name}_FLTT"] = values[f"ATC_RAT_{name}_FLTD"] = opened
    values["ATC_INPUT_TC"] = min(DEFAULT_INPUT_TC_S * max(1.0, 1.0 / faster), 1.0)
    level = min(pd["kp_velocity_x"], 0.3 / values["ATC_INPUT_TC"])
    return {
        **values,
        "PSC_NE_VEL_P": level,
        "PSC_NE_VEL_I": 0.25 * level**2,
        "PSC_NE_VEL_D": 0.125 * level,
        "PSC_NE_POS_P": min(pd["kp_position_xy"], 0.5 * level),
        "PSC_D_ACC_P": 0.05 * X500_LIFT / lift,
        "PSC_D_ACC_I": 0.1 * X500_LIFT / lift,
        "PSC_D_VEL_P": min(5.0, pd["kp_velocity_z"]),
        "PSC_D_POS_P": min(1.0, pd["kp_position_z"]),
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
    }
