"""Betaflight 4.2 to 2026.6: its rate loop in angle mode, its mixer, and a small loop of our own.

Betaflight has no position loop: `outer_` parameters are the workbench's. Every eighth update

    v_sp = outer_p_position (p_sp - p) + v_ff             outer_p_height for z
    a    = outer_p_velocity (v_sp - v) + I + a_ff,   dI/dt = outer_i_velocity (v_sp - v)
           outer_p_climb, outer_i_climb for z;  I of a direction stands while it is limited

give angles θ_d (degrees, within angle_limit) with thrust along (a_x, a_y, g), and the throttle for
(g + a_z) / cos(tilt) on a motor whose thrust is proportional to the square of its signal; hover is
at outer_hover.

Everything else is Betaflight's, with its names, its integer gains and its scales. Rates are in
deg/s about x forward, y left (nose down) and z up. t is the throttle, PT1, PT2, PT3 are low-passes:

    ω_sp = PT3(angle_p_gain / 10 (θ_d - θ) + its share of the yaw rate);  yaw: the rate itself
    e    = ω_sp - ω                                        ω through gyro_lpf2 and gyro_lpf1
    P    = 0.032029 p e                                    yaw: through yaw_lowpass_hz
    dI/dt = 0.244381 i e max(0, 1 - |ω_sp - PT1(ω_sp)| / 8)         yaw: 2.5 times i, and no max
    D    = -0.000529 d M T dω_f/dt                         ω_f: ω through dterm_lpf1 and dterm_lpf2
    M    = min(d_max / d, PT2_35Hz(1 + (d_max / d - 1) max(c d_max_gain |PT2_85Hz(dω_f/dt)|,
               c d_max_advance |dω_sp/dt|))),                            c = 0.00008 / 35
    T    = 1 - tpa_rate / 100 max(0, t - b) / (1 - b),     b = tpa_breakpoint / 1000 - 1 <= 0.99
    F    = 0.013754 f / 100 dω_sp/dt                       roll and pitch: in rate mode alone
    A    = anti_gravity_gain PT2(|slope of t| (1 - t)²),   while t rises, times (1 - t) / 2

A is anti-gravity: for roll and pitch it adds 0.34 A to 0.244381 i, and increases P by
0.0034 A anti_gravity_p_gain / 100 / max(1, |ω_sp| / 50). Sums of P, I, D and F are clipped at
pidsum_limit, integrals at iterm_windup percent of it; they are thousandths of a motor's range.
First low-passes have dynamic cut-offs: min + (max - min) (t + expo / 10 t (1 - t)), or for an expo
of 0 the larger of min and 1.5 max (t - t³ / 3); if min is 0, the static one. A filter's type is 0
for PT1, 1 for the second order, 2 for PT2 and 3 for PT3. The part of the throttle above the
frequency throttle_boost_cutoff is boosted by throttle_boost / 10. In rate mode (`acro` 1) the outer
loop commands ω_sp = outer_p_angle (θ_d - θ), and the 8 above becomes 40.
Motor signals follow from sums and throttle, see `extras/autopilots/mixers.py`; a speed controller
converts a full signal to `motor_speed`. The update runs at 1024 Hz, Betaflight's at 8000.

`firmware` is the version that is computed; above is 2025.12. Otherwise there are

    up to 2025.12   another thrust linearisation, see `extras/autopilots/mixers.py`
    up to 4.6       d_max_advance times d_max_gain / 100
    up to 4.5       integrals within iterm_limit in place of iterm_windup
    up to 4.4       the 8 above is 40, and the PT3 has 250 Hz in place of 50
    up to 4.3       no PT3
    4.2             c = 0.00005 / 10, a PT1 of 10 Hz for the PT2 of 35 Hz, and a filter of second
                    order of 80 Hz for the PT2 of 85 Hz

Source: Betaflight 4.2.11, 4.3.2, 4.4.3, 4.5.1, 4.6.0 development snapshot (MSP API 1.47), 2025.12.5
and 2026.6.1, pid.c, pid_init.c, filter.c, gyro.c. docs/autopilots.md lists omissions.
"""

import numpy as np

from workbench.control.law_constants import known_vehicle, law_constants
from workbench.controllers import (
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
    arctan2,
    attitude_matrix,
    between,
    clipped,
    cosine_sine,
    gain,
    into_body,
    level_heading,
    points,
    position_error,
    probe,
    probe3,
    states,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.extras.autopilots.betaflight_mixer import betaflight_mixed
from workbench.extras.autopilots.betaflight_outer import RADIAN_DEG, outer_loop
from workbench.extras.autopilots.filters import (
    PT2,
    SECOND_ORDER,
    cascaded,
    first_order,
    first_order_filtered,
    low_passed,
)
from workbench.extras.autopilots.loop_stages import stage_loops
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

PERIOD = 1 / 1024
DIVIDERS = (8,)
P_SCALE, I_SCALE, D_SCALE, F_SCALE = 0.032029, 0.244381, 0.000529, 0.013754
"""Scales of the gains, see above."""
YAW_I_FACTOR = 2.5
"""Additional scale of i_yaw."""
PID_SUM_FULL_SCALE = 1000.0
"""A PID sum of this is a motor's whole range."""
BETAFLIGHT_MIXER = (1.0, "Betaflight's mixer")
"""Largest share of the mixer, and its name."""
I_RELAX_DEG_S, I_RELAX_ANGLE_DEG_S = 40.0, 8.0
"""Fast part of a setpoint that stops an integral, in rate mode and in angle mode [deg/s]."""
D_MAX_RANGE_HZ, D_MAX_SMOOTH_HZ = 85.0, 35.0
"""Cut-offs of the PT2 filters of d_max [Hz]."""
D_MAX_SCALE = 0.00008
MAX_VERSION = 9999.0
"""Largest number of a version."""
ANTI_GRAVITY_I, ANTI_GRAVITY_P, ANTI_GRAVITY_DEG_S = 0.34, 0.0034, 50.0

_BETAFLIGHT_AXES = ("roll", "pitch", "yaw")
OUTER_LOOP_GROUP = "Outer loop of the workbench"
PARAMETERS = (
    gain(
        "outer_p_position", "1/s", (0.0, 4.0), 1.0, "position P gain, horizontal", OUTER_LOOP_GROUP
    ),
    gain("outer_p_height", "1/s", (0.0, 4.0), 1.0, "position P gain, vertical", OUTER_LOOP_GROUP),
    gain(
        "outer_p_velocity", "1/s", (0.0, 10.0), 2.0, "velocity P gain, horizontal", OUTER_LOOP_GROUP
    ),
    gain(
        "outer_i_velocity",
        "1/s^2",
        (0.0, 10.0),
        0.5,
        "velocity I gain, horizontal",
        OUTER_LOOP_GROUP,
    ),
    gain("outer_p_climb", "1/s", (0.0, 20.0), 4.0, "velocity P gain, vertical", OUTER_LOOP_GROUP),
    gain("outer_i_climb", "1/s^2", (0.0, 20.0), 2.0, "velocity I gain, vertical", OUTER_LOOP_GROUP),
    gain("outer_hover", "1", (0.0, 0.9), 0.3, "hover throttle", OUTER_LOOP_GROUP),
    gain("acro", "1", (0.0, 1.0), 0.0, "1: rate mode, 0: angle mode", OUTER_LOOP_GROUP),
    gain("outer_p_angle", "1/s", (0.0, 50.0), 5.0, "angle P gain in rate mode", OUTER_LOOP_GROUP),
    *(
        gain(f"{term}_{axis}", "1", (0.0, most), value, f"{what}, {axis}", "PID")
        for axis, values in zip(
            _BETAFLIGHT_AXES,
            (
                (45.0, 80.0, 30.0, 120.0, 40.0),
                (47.0, 84.0, 34.0, 125.0, 46.0),
                (45.0, 80.0, 0.0, 120.0, 0.0),
            ),
            strict=True,
        )
        for (term, most, what), value in zip(
            (
                ("p", 250.0, "P gain"),
                ("i", 250.0, "I gain"),
                ("d", 250.0, "D gain"),
                ("f", 2000.0, "feedforward"),
                ("d_max", 250.0, "maximum D, 0 for D"),
            ),
            values,
            strict=True,
        )
    ),
    gain("angle_p_gain", "1", (0.0, 200.0), 50.0, "angle P gain, tenths", "Angle"),
    gain("angle_limit", "deg", (10.0, 90.0), 60.0, "maximum angle", "Angle"),
    gain("angle_earth_ref", "1", (0.0, 100.0), 100.0, "percent: yaw about the world's z", "Angle"),
    gain("d_max_gain", "1", (0.0, 100.0), 37.0, "D boost by gyro", "PID"),
    gain("d_max_advance", "1", (0.0, 200.0), 20.0, "D boost by setpoint", "PID"),
    gain("iterm_relax_cutoff", "Hz", (1.0, 50.0), 15.0, "I relax low-pass cutoff", "PID"),
    gain("iterm_windup", "1", (20.0, 100.0), 80.0, "I limit, percent of PID sum", "PID"),
    gain("iterm_limit", "1", (0.0, 500.0), 400.0, "I limit of firmware up to 4.5", "PID"),
    gain("pidsum_limit", "1", (100.0, 1000.0), 500.0, "PID sum limit, roll and pitch", "PID"),
    gain("pidsum_limit_yaw", "1", (100.0, 1000.0), 400.0, "PID sum limit, yaw", "PID"),
    gain("anti_gravity_gain", "1", (0.0, 250.0), 80.0, "anti-gravity gain", "PID"),
    gain("anti_gravity_p_gain", "1", (0.0, 250.0), 100.0, "anti-gravity P share, percent", "PID"),
    gain("anti_gravity_cutoff_hz", "Hz", (2.0, 50.0), 5.0, "anti-gravity low-pass cutoff", "PID"),
    gain("tpa_rate", "1", (0.0, 100.0), 65.0, "D reduction by throttle, percent", "PID"),
    gain("tpa_breakpoint", "us", (750.0, 2250.0), 1350.0, "throttle where it starts", "PID"),
    gain("gyro_lpf1_dyn_min_hz", "Hz", (0.0, 1000.0), 250.0, "gyro filter 1 minimum", "Filters"),
    gain("gyro_lpf1_dyn_max_hz", "Hz", (0.0, 1000.0), 500.0, "gyro filter 1 maximum", "Filters"),
    gain("gyro_lpf1_dyn_expo", "1", (0.0, 10.0), 5.0, "gyro filter 1 expo, tenths", "Filters"),
    gain("gyro_lpf1_static_hz", "Hz", (0.0, 4000.0), 250.0, "filter 1 if minimum 0", "Filters"),
    gain("gyro_lpf1_type", "1", (0.0, 3.0), 0.0, "PT1, 1 second order, 2 PT2, 3 PT3", "Filters"),
    gain("gyro_lpf2_static_hz", "Hz", (0.0, 4000.0), 500.0, "gyro filter 2", "Filters"),
    gain("gyro_lpf2_type", "1", (0.0, 3.0), 0.0, "PT1, 1 second order, 2 PT2, 3 PT3", "Filters"),
    gain("dterm_lpf1_dyn_min_hz", "Hz", (0.0, 1000.0), 75.0, "D filter 1 minimum", "Filters"),
    gain("dterm_lpf1_dyn_max_hz", "Hz", (0.0, 1000.0), 150.0, "D filter 1 maximum", "Filters"),
    gain("dterm_lpf1_dyn_expo", "1", (0.0, 10.0), 5.0, "D filter 1 expo, tenths", "Filters"),
    gain("dterm_lpf1_static_hz", "Hz", (0.0, 4000.0), 75.0, "filter 1 if minimum 0", "Filters"),
    gain("dterm_lpf1_type", "1", (0.0, 3.0), 0.0, "PT1, 1 second order, 2 PT2, 3 PT3", "Filters"),
    gain("dterm_lpf2_static_hz", "Hz", (0.0, 4000.0), 150.0, "D filter 2", "Filters"),
    gain("dterm_lpf2_type", "1", (0.0, 3.0), 0.0, "PT1, 1 second order, 2 PT2, 3 PT3", "Filters"),
    gain("yaw_lowpass_hz", "Hz", (0.0, 500.0), 100.0, "yaw P filter", "Filters"),
    gain("throttle_boost", "1", (0.0, 100.0), 5.0, "throttle boost, tenths", "Motors"),
    gain("throttle_boost_cutoff", "Hz", (5.0, 50.0), 15.0, "boost high-pass cutoff", "Motors"),
    gain("airmode", "1", (0.0, 1.0), 1.0, "1: attitude has priority over throttle", "Motors"),
    gain("thrust_linear", "1", (0.0, 150.0), 0.0, "thrust linearisation, percent", "Motors"),
    gain("motor_idle", "1", (0.0, 2000.0), 550.0, "idle signal, hundredths of a percent", "Motors"),
    gain("motor_speed", "rad/s", (1.0, 20000.0), 2600.0, "motor speed at full signal", "Motors"),
    gain("firmware", "1", (4.2, MAX_VERSION), 2025.12, "version that is computed", "Firmware"),
)

MEMORY = (
    *states("outer_i", "m/s^2"),
    *states("angle", "deg", "xy"),
    *states("pt3_1", "deg/s", "xy"),
    *states("pt3_2", "deg/s", "xy"),
    *states("pt3_3", "deg/s", "xy"),
    *(
        state
        for name in ("gyro_2", "gyro_1", "d_1", "d_2")
        for stage in "abc"
        for state in states(f"{name}{stage}", "deg/s")
    ),
    *states("d_before", "deg/s"),
    *states("relaxed", "deg/s"),
    *states("setpoint", "deg/s"),
    *states("i_rate", "1"),
    *(state for stage in "abc" for state in states(f"range_{stage}", "deg/s^2")),
    *states("boost_1", "1"),
    *states("boost_2", "1"),
    State("throttle", "1"),
    State("throttle_before", "1"),
    State("throttle_slow", "1"),
    State("gravity_1", "1"),
    State("gravity_2", "1"),
    State("p_yaw", "1"),
    State("runs", "1"),
)

POINTS = points(
    {
        "position_{}_error": "m",
        "velocity_{}_error": "m/s",
        "rate_{}_error": "deg/s",
        "torque_{}": "1",
    }
) | {
    **points({"angle_{}_error": "deg"}, "xy"),
    "roll_setpoint": "deg",
    "pitch_setpoint": "deg",
    "roll_rate_setpoint": "deg/s",
    "pitch_rate_setpoint": "deg/s",
}
BETAFLIGHT_RATE_POINT = 6
BETAFLIGHT_TORQUE_POINT = 9
BETAFLIGHT_ANGLE_POINT = 12
BETAFLIGHT_ANGLE_SETPOINT_POINT = 14
BETAFLIGHT_RATE_SETPOINT_POINT = 16

_BETAFLIGHT_LEVEL_GAINS, _BETAFLIGHT_CLIMB_GAINS = (
    ("outer_p_velocity", "outer_i_velocity"),
    ("outer_p_climb", "outer_i_climb"),
)
LOOPS = stage_loops(
    (("outer_p_position",), ("outer_p_position",), ("outer_p_height",)),
    (_BETAFLIGHT_LEVEL_GAINS, _BETAFLIGHT_LEVEL_GAINS, _BETAFLIGHT_CLIMB_GAINS),
    (("angle_p_gain",), ("angle_p_gain",)),
    [tuple(f"{term}_{name}" for term in "pid") for name in _BETAFLIGHT_AXES],
    "angle",
)

DESIGNED = (
    *MIXER_NUMBER_NAMES,
    "k_attitude",
    "range_cutoff",
    "range_kind",
    "k_boost_1",
    "k_boost_2",
    "k_gravity",
    "k_relax",
    "k_yaw",
    "k_throttle",
    "by_gyro",
    "by_step",
    "most_i",
    "most_i_yaw",
    "relax_angle",
    "linear_form",
    *(f"d_most_{axis}" for axis in "xyz"),
    "idle",
    "hover_signal",
    "motor_constant",
    "linear_speed",
)


def design(vehicle: KnownVehicle, g: Gains, dt: float) -> list[float]:
    """Return shares of the mixer, gains of low-passes, limits of D, and motor constants."""
    idle, version = 1e-4 * g.motor_idle, g.firmware
    attitude = 50.0 if version >= 4.5 else 250.0 if version >= 4.4 else 0.0
    slow_1, slow_2 = (cascaded(D_MAX_SMOOTH_HZ, dt, 2),) * 2
    by_gyro, by_step = D_MAX_SCALE * g.d_max_gain / D_MAX_SMOOTH_HZ, g.d_max_advance / 100.0
    if version < 4.3:
        by_gyro = 0.00005 * g.d_max_gain / 10.0
        slow_1, slow_2 = first_order(10.0, dt), 1.0
    limits = (g.iterm_limit, g.iterm_limit)
    if version >= 4.6:
        limits = tuple(
            0.01 * g.iterm_windup * most for most in (g.pidsum_limit, g.pidsum_limit_yaw)
        )
    pairs = ((g.d_max_roll, g.d_roll), (g.d_max_pitch, g.d_pitch), (g.d_max_yaw, g.d_yaw))
    return [
        *column_numbers(vehicle.rotors, moment_shares(vehicle.rotors, *BETAFLIGHT_MIXER)),
        cascaded(attitude, dt, 3),
        *((D_MAX_RANGE_HZ, PT2) if version >= 4.3 else (80.0, SECOND_ORDER)),
        slow_1,
        slow_2,
        cascaded(g.anti_gravity_cutoff_hz, dt, 2),
        first_order(g.iterm_relax_cutoff, dt),
        first_order(g.yaw_lowpass_hz, dt),
        first_order(g.throttle_boost_cutoff, dt),
        by_gyro,
        D_MAX_SCALE * g.d_max_advance / D_MAX_SMOOTH_HZ if version >= 2025.0 else by_gyro * by_step,
        *limits,
        I_RELAX_ANGLE_DEG_S if version >= 4.5 else I_RELAX_DEG_S,
        2.0 if version >= 2026.0 else 1.0 if version >= 4.3 else 0.0,
        *(most / base if 0.0 < base < most else 1.0 for most, base in pairs),
        idle,
        idle + (1.0 - idle) * g.outer_hover,
        vehicle.rotors[0].motor_constant,
        vehicle.rotors[0].linear_speed,
    ]


def dynamic_cutoff(throttle: float, least: float, most: float, expo: float, static: float) -> float:
    """Return a cut-off that depends on the throttle [Hz].

    Args:
        throttle: 0 .. 1.
        least: cut-off without throttle [Hz].
        most: cut-off at full throttle [Hz].
        expo: tenths of the bend between them.
        static: the cut-off if `least` is 0 [Hz].
    """
    if least <= 0.0:
        return static + 0.0 * throttle
    if expo > 0.0:
        return least + (most - least) * (throttle + 0.1 * expo * throttle * (1.0 - throttle))
    cutoff = 1.5 * most * throttle * (1.0 - throttle * throttle / 3.0)
    return cutoff if cutoff > least else least + 0.0 * throttle


def magnitude(x: float) -> float:
    """Return the absolute value."""
    return x if x > 0.0 else -x


def relaxed_error(e: float, wanted: float, slow: float, most: float) -> float:
    """Return the part of an error that is integrated while its setpoint moves fast.

    Args:
        e: error.
        wanted: its setpoint.
        slow: the same after the low-pass.
        most: fast part at which nothing is integrated.
    """
    share = 1.0 - magnitude(wanted - slow) / most
    return share * e if share > 0.0 else 0.0 * e


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
    R = attitude_matrix(measured.q_WT)
    cos, sin, flat = level_heading(R)
    roll, pitch = RADIAN_DEG * arctan2(R[7], R[8]), RADIAN_DEG * arctan2(-R[6], flat)
    w = into_body(R, measured.w_WB)
    w = (RADIAN_DEG * w[0], RADIAN_DEG * w[1], RADIAN_DEG * w[2])

    # outer loop: position and velocity to angles and throttle
    roll_d, pitch_d, throttle = m.angle_x, m.angle_y, m.throttle
    i_x, i_y, i_z = m.outer_i_x, m.outer_i_y, m.outer_i_z
    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    back = g.outer_p_position * e[0], g.outer_p_position * e[1], g.outer_p_height * e[2]
    s_x, s_y, s_z, yaw_rate = velocity_setpoint(back, measured, setpoint, g)
    e_x, e_y, e_z = probe3((s_x - v[0], s_y - v[1], s_z - v[2]), VELOCITY_POINT, loops)
    since = measured.elapsed[0]
    if since > 0.0 or first:
        period = since if since > 0.0 else DIVIDERS[0] * dt
        roll_d, pitch_d, throttle, i_x, i_y, i_z = outer_loop(
            (e_x, e_y, e_z),
            (i_x, i_y, i_z),
            setpoint.a_WBcm,
            (cos, sin),
            g,
            (g.idle, g.hover_signal),
            period,
        )

    # throttle: anti-gravity, thrust attenuation of D, boost
    was = throttle if first else m.throttle_before
    away, moves = 1.0 - throttle, magnitude(throttle - was) / dt
    moves = moves * away * away
    if throttle > was:
        moves = 0.5 * moves * away
    quick = m.gravity_1 + g.k_gravity * (moves - m.gravity_1)
    gravity = m.gravity_2 + g.k_gravity * (quick - m.gravity_2)
    anti = g.anti_gravity_gain * gravity
    knee = 0.001 * g.tpa_breakpoint - 1.0
    knee = knee if knee < 0.99 else 0.99 + 0.0 * knee
    above = throttle - knee if throttle > knee else 0.0 * throttle
    tpa = 1.0 - 0.01 * g.tpa_rate / (1.0 - knee) * above
    gyro_cutoff = dynamic_cutoff(
        throttle,
        g.gyro_lpf1_dyn_min_hz,
        g.gyro_lpf1_dyn_max_hz,
        g.gyro_lpf1_dyn_expo,
        g.gyro_lpf1_static_hz,
    )
    dterm_cutoff = dynamic_cutoff(
        throttle,
        g.dterm_lpf1_dyn_min_hz,
        g.dterm_lpf1_dyn_max_hz,
        g.dterm_lpf1_dyn_expo,
        g.dterm_lpf1_static_hz,
    )
    slow = throttle if first else m.throttle_slow
    slow = slow + g.k_throttle * (throttle - slow)
    boosted = between(throttle + 0.1 * g.throttle_boost * (throttle - slow), 0.0, 1.0)

    # rates, filtered; and again for D
    gyro_2 = (m.gyro_2a_x, m.gyro_2a_y, m.gyro_2a_z, m.gyro_2b_x, m.gyro_2b_y, m.gyro_2b_z)
    gyro_2 = (*gyro_2, m.gyro_2c_x, m.gyro_2c_y, m.gyro_2c_z)
    gyro_1 = (m.gyro_1a_x, m.gyro_1a_y, m.gyro_1a_z, m.gyro_1b_x, m.gyro_1b_y, m.gyro_1b_z)
    gyro_1 = (*gyro_1, m.gyro_1c_x, m.gyro_1c_y, m.gyro_1c_z)
    d_1 = (m.d_1a_x, m.d_1a_y, m.d_1a_z, m.d_1b_x, m.d_1b_y, m.d_1b_z)
    d_1 = (*d_1, m.d_1c_x, m.d_1c_y, m.d_1c_z)
    d_2 = (m.d_2a_x, m.d_2a_y, m.d_2a_z, m.d_2b_x, m.d_2b_y, m.d_2b_z)
    d_2 = (*d_2, m.d_2c_x, m.d_2c_y, m.d_2c_z)
    gyro, gyro_2 = low_passed(w, gyro_2, g.gyro_lpf2_static_hz, g.gyro_lpf2_type, first, dt)
    gyro, gyro_1 = low_passed(gyro, gyro_1, gyro_cutoff, g.gyro_lpf1_type, first, dt)
    slowed, d_1 = low_passed(gyro, d_1, dterm_cutoff, g.dterm_lpf1_type, first, dt)
    slowed, d_2 = low_passed(slowed, d_2, g.dterm_lpf2_static_hz, g.dterm_lpf2_type, first, dt)
    d_before = (m.d_before_x, m.d_before_y, m.d_before_z)
    if first:
        d_before = slowed
    falls = (
        -(slowed[0] - d_before[0]) / dt,
        -(slowed[1] - d_before[1]) / dt,
        -(slowed[2] - d_before[2]) / dt,
    )

    # angle mode, or rate mode
    roll_sp = probe(roll_d, BETAFLIGHT_ANGLE_SETPOINT_POINT, loops)
    pitch_sp = probe(pitch_d, BETAFLIGHT_ANGLE_SETPOINT_POINT + 1, loops)
    e_roll = probe(roll_sp - roll, BETAFLIGHT_ANGLE_POINT, loops)
    e_pitch = probe(pitch_sp - pitch, BETAFLIGHT_ANGLE_POINT + 1, loops)
    turn = RADIAN_DEG * yaw_rate
    earth, angle_p = 0.01 * g.angle_earth_ref, 0.1 * g.angle_p_gain
    _, sin_roll = cosine_sine(roll_sp / RADIAN_DEG)
    _, sin_pitch = cosine_sine(pitch_sp / RADIAN_DEG)
    asked = (
        angle_p * e_roll - turn * sin_pitch * earth,
        angle_p * e_pitch + turn * sin_roll * earth,
        0.0 * turn,
    )
    pt_1, pt_2, pt_3 = (
        (m.pt3_1_x, m.pt3_1_y, 0.0 * turn),
        (m.pt3_2_x, m.pt3_2_y, 0.0 * turn),
        (m.pt3_3_x, m.pt3_3_y, 0.0 * turn),
    )
    pt_1 = first_order_filtered(pt_1, asked, g.k_attitude)
    pt_2 = first_order_filtered(pt_2, pt_1, g.k_attitude)
    pt_3 = first_order_filtered(pt_3, pt_2, g.k_attitude)
    if g.acro > 0.5:
        s = (g.outer_p_angle * e_roll, g.outer_p_angle * e_pitch, turn)
        feed, quiet = 1.0, I_RELAX_DEG_S + 0.0 * turn
    else:
        steepest = (
            magnitude(roll_sp) if magnitude(roll_sp) > magnitude(pitch_sp) else magnitude(pitch_sp)
        )
        cos_most, _ = cosine_sine(earth * steepest / RADIAN_DEG)
        s = (pt_3[0], pt_3[1], turn * cos_most)
        feed, quiet = 0.0, g.relax_angle

    # rate control
    s = (
        probe(s[0], BETAFLIGHT_RATE_SETPOINT_POINT, loops),
        probe(s[1], BETAFLIGHT_RATE_SETPOINT_POINT + 1, loops),
        s[2],
    )
    s_slow = (m.relaxed_x, m.relaxed_y, m.relaxed_z)
    s_was = (m.setpoint_x, m.setpoint_y, m.setpoint_z)
    if first:
        s_slow, s_was = s, s
    s_slow = first_order_filtered(s_slow, s, g.k_relax)
    steps = feed * (s[0] - s_was[0]) / dt, feed * (s[1] - s_was[1]) / dt, (s[2] - s_was[2]) / dt
    e = probe3((s[0] - gyro[0], s[1] - gyro[1], s[2] - gyro[2]), BETAFLIGHT_RATE_POINT, loops)
    added = ANTI_GRAVITY_I * anti
    grows_p = (I_SCALE * g.i_roll + added) * relaxed_error(e[0], s[0], s_slow[0], quiet)
    grows_q = (I_SCALE * g.i_pitch + added) * relaxed_error(e[1], s[1], s_slow[1], quiet)
    i_p = clipped(m.i_rate_x + grows_p * dt, g.most_i)
    i_q = clipped(m.i_rate_y + grows_q * dt, g.most_i)
    i_r = clipped(m.i_rate_z + YAW_I_FACTOR * I_SCALE * g.i_yaw * e[2] * dt, g.most_i_yaw)
    more = ANTI_GRAVITY_P * 0.01 * g.anti_gravity_p_gain * anti
    p_p = P_SCALE * g.p_roll * e[0] * (1.0 + more / anti_gravity_divisor(s[0]))
    p_q = P_SCALE * g.p_pitch * e[1] * (1.0 + more / anti_gravity_divisor(s[1]))
    p_r = P_SCALE * g.p_yaw * e[2]
    p_r = p_r if first else m.p_yaw + g.k_yaw * (p_r - m.p_yaw)
    ranges = (m.range_a_x, m.range_a_y, m.range_a_z, m.range_b_x, m.range_b_y, m.range_b_z)
    ranges = (*ranges, m.range_c_x, m.range_c_y, m.range_c_z)
    moving, ranges = low_passed(falls, ranges, g.range_cutoff, g.range_kind, False, dt)
    boost = (
        d_max_factor(moving[0], steps[0], g.by_gyro, g.by_step, g.d_most_x),
        d_max_factor(moving[1], steps[1], g.by_gyro, g.by_step, g.d_most_y),
        d_max_factor(moving[2], steps[2], g.by_gyro, g.by_step, g.d_most_z),
    )
    boost_1, boost_2 = (
        (m.boost_1_x, m.boost_1_y, m.boost_1_z),
        (m.boost_2_x, m.boost_2_y, m.boost_2_z),
    )
    if first:
        boost_1, boost_2 = boost, boost
    boost_1 = first_order_filtered(boost_1, boost, g.k_boost_1)
    boost_2 = first_order_filtered(boost_2, boost_1, g.k_boost_2)
    d_p = D_SCALE * g.d_roll * falls[0] * between(boost_2[0], 0.0, g.d_most_x) * tpa
    d_q = D_SCALE * g.d_pitch * falls[1] * between(boost_2[1], 0.0, g.d_most_y) * tpa
    d_r = D_SCALE * g.d_yaw * falls[2] * between(boost_2[2], 0.0, g.d_most_z) * tpa
    sum_p = p_p + i_p + d_p + F_SCALE * 0.01 * g.f_roll * steps[0]
    sum_q = p_q + i_q + d_q + F_SCALE * 0.01 * g.f_pitch * steps[1]
    sum_r = p_r + i_r + d_r + F_SCALE * 0.01 * g.f_yaw * steps[2]
    torque = (
        clipped(sum_p, g.pidsum_limit) / PID_SUM_FULL_SCALE,
        clipped(sum_q, g.pidsum_limit) / PID_SUM_FULL_SCALE,
        clipped(sum_r, g.pidsum_limit_yaw) / PID_SUM_FULL_SCALE,
    )
    torque = probe3(torque, BETAFLIGHT_TORQUE_POINT, loops)

    # mixer and motors
    linear = (0.01 * g.thrust_linear, g.linear_form)
    u = betaflight_mixed((*torque, boosted), g.airmode, linear, mixer_columns(g))
    none = 0.0 * throttle
    wrench, by = (none, none, none, none), effects_per_thrust(g)
    for i in range(MAX_MIXER_MOTORS):
        speed = g.motor_speed * (g.idle + (1.0 - g.idle) * u[i])
        wrench = with_motor(wrench, i, g.motor_constant * speed * (speed + g.linear_speed), by)
    outer = (i_x, i_y, i_z, roll_d, pitch_d, *pt_1[:2], *pt_2[:2], *pt_3[:2])
    inner = (*gyro_2, *gyro_1, *d_1, *d_2, *slowed, *s_slow, *s, i_p, i_q, i_r, *ranges)
    last = (*boost_1, *boost_2, throttle, throttle, slow, quick, gravity, p_r, 1.0 + none)
    return wrench, (*outer, *inner, *last)


def anti_gravity_divisor(wanted: float) -> float:
    """Return the divisor of anti-gravity's P at a commanded rate."""
    share = magnitude(wanted) / ANTI_GRAVITY_DEG_S
    return share if share > 1.0 else 1.0 + 0.0 * share


def d_max_factor(fall: float, step: float, by_gyro: float, by_step: float, most: float) -> float:
    """Return the factor of D for fast moves and fast setpoints, unfiltered.

    Args:
        fall: filtered slope of the rate [deg/s²].
        step: slope of the setpoint [deg/s²].
        by_gyro: weight of `fall`.
        by_step: weight of `step`.
        most: d_max over d.
    """
    moves, asks = by_gyro * magnitude(fall), by_step * magnitude(step)
    return 1.0 + (most - 1.0) * (moves if moves > asks else asks)


FIVE_INCH_ACCELERATION = (2170.0, 1860.0, 146.0)
"""Angular acceleration of a 5-inch quad over roll, pitch and yaw, in hover [rad/s²]."""
FIVE_INCH_RATE_P = 60.0
"""Its roll rate P with Betaflight's defaults, over 1 + D [1/s]."""
MIN_YAW_SPIN_UP_S = 0.1
"""Required spin-up lead in yaw [s]: without it, the default i_yaw makes yaw oscillate."""
IDLE_SIGNAL_SHARE = 0.055
"""Share of the signal at default motor_idle."""
SIGNAL_PER_P_GAIN = P_SCALE * RADIAN_DEG / PID_SUM_FULL_SCALE
"""Share of a motor's range for a rate error of 1 rad/s and a P of 1."""


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return values for a vehicle: motors, throttle in hover, and gains unless like a 5-inch quad.

    Roll and pitch, or yaw, keep Betaflight's defaults if the vehicle turns as quickly as a 5-inch
    quad. Other gains are those of the PD cascade in this form: rate P = kd, angle P = 0.3 kd,
    integrals and derivatives in the proportions of Betaflight's defaults, integrals slower for a
    slower loop.
    """
    pd, frame = pd_rule(vehicle), thrust_frame(vehicle)
    fastest = vehicle.rotors[0].max_rot_velocity
    rotors = known_vehicle(law_constants(vehicle)).rotors
    mix = moment_shares(rotors, *BETAFLIGHT_MIXER)
    turned = hover_authority(rotors, frame, mix, 1.0 - IDLE_SIGNAL_SHARE, fastest)[:3].tolist()
    throttle = (frame.hover_speeds / fastest - IDLE_SIGNAL_SHARE) / (1.0 - IDLE_SIGNAL_SHARE)
    values = {
        "outer_hover": float(np.clip(np.mean(throttle), 0.0, 0.9)),
        "motor_speed": fastest,
        "outer_p_position": pd["kp_position_xy"],
        "outer_p_height": pd["kp_position_z"],
        "outer_p_velocity": pd["kp_velocity_x"],
        "outer_i_velocity": 0.12 * pd["kp_velocity_x"] ** 2,
        "outer_p_climb": pd["kp_velocity_z"],
        "outer_i_climb": 0.5 * pd["kp_velocity_z"],
        "max_climb_rate": pd["max_climb_rate"],
    }
    alike = flies_with_defaults(turned, FIVE_INCH_ACCELERATION)
    kept_level = alike[0] and alike[1]
    kept_yaw = kept_level and alike[2] and frame.spin_up_time > MIN_YAW_SPIN_UP_S
    for axis, kp, place, kept in (
        ("roll", "kd_roll", 0, kept_level),
        ("pitch", "kd_pitch", 1, kept_level),
        ("yaw", "kp_yaw_rate", 2, kept_yaw),
    ):
        if kept:
            continue
        p = min(pd[kp] / (turned[place] * SIGNAL_PER_P_GAIN), 250.0)
        values[f"p_{axis}"] = p
        slower = min(1.0, pd[kp] / FIVE_INCH_RATE_P)
        values[f"i_{axis}"] = min((0.7 if axis == "yaw" else 1.8) * p * slower, 250.0)
        values[f"d_{axis}"] = 0.0 if axis == "yaw" else min(0.7 * p, 180.0)
        values[f"d_max_{axis}"] = 0.0 if axis == "yaw" else min(0.95 * p, 250.0)
    if not kept_yaw:
        values["spin_up_feedforward"] = pd["spin_up_feedforward"]
    if not kept_level:
        values["angle_p_gain"] = min(3.0 * min(pd["kd_roll"], pd["kd_pitch"]), 200.0)
    return values
