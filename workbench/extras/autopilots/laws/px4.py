"""PX4's multicopter position, attitude and rate control, and its control allocation.

Parameters have PX4's names, units and defaults (v1.16). PX4 uses NED and FRD; here x, y, z are
those of the world and the body with z up, where the same equations hold. By component:

    v_sp = P_pos (p_sp - p) + v_ff          level: the first part has priority within XY_VEL_MAX
    a_sp = a_ff + P_vel (v_sp - v) + I_vel - D_vel dv/dt
    f    = (a_x, a_y, g),  tilted by TILTMAX_AIR at most;  F = h (1 + a_z / g) / cos(tilt) along it
    h is THR_HOVER; a horizontal thrust of THR_XY_MARG is left when F reaches THR_MAX
    dI_vel/dt = I (v_sp - v), level: less 2 / P_vel (a_sp - what the limited thrust makes)

    q_d: z along f, y_C = (-sin ψ, cos ψ, 0), x = y_C x z;  q_red: the shortest turn to that z
    q_d <- q_red with MC_YAW_WEIGHT w of the remaining yaw
    ω_sp = 2 P_att sgn(q_0) Im(q⁻¹ q_d) + (world's z) dψ_sp/dt,   P_yaw over w, within RATE_MAX
    τ    = K P (ω_sp - ω) + I_rate - K D dω/dt + FF ω_sp
    dI_rate/dt = max(0, 1 - (e / 400°/s)²) K I e,  within INT_LIM; not towards torque that the
                 allocation could not make

ω has passed the second-order low-pass IMU_GYRO_CUTOFF, and dω/dt also the first-order low-pass
IMU_DGYRO_CUTOFF. The yaw torque passes the first-order low-pass MC_YAW_TQ_CUTOFF.
Motor signals follow from τ and F, see `extras/autopilots/mixers.py`. A signal x gives the thrust
share THR_MDL_FAC x² + (1 - THR_MDL_FAC) x, and a speed controller converts x to a speed between
SIM_GZ_EC_MIN and SIM_GZ_EC_MAX. Rates: 512, 256 and 102 Hz; in PX4 400, 250 and 50 to 100.

Source: PX4-Autopilot, PositionControl.cpp, ControlMath.cpp, AttitudeControl.cpp, rate_control.cpp,
module parameters. docs/autopilots.md lists omissions.
"""

import math

import numpy as np

from workbench.control.law_constants import known_vehicle, law_constants
from workbench.control.quaternions import (
    canonical,
    inverse,
    normalized,
    product,
    shortest_turn,
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
    Quaternion,
    State,
    Vector3,
    arctan2,
    attitude_matrix,
    between,
    clipped,
    cosine_sine,
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
from workbench.extras.autopilots.filters import (
    LOWPASS_COEFFICIENTS,
    butterworth,
    first_order,
    first_order_filtered,
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
    TORQUE_SCALE_NAMES,
    column_numbers,
    effects_per_thrust,
    flies_with_defaults,
    hover_authority,
    mixer_columns,
    with_motor,
)
from workbench.extras.autopilots.px4_mixer import px4_allocated, px4_mixing, px4_unallocated_torque
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

PERIOD = 1 / 512
DIVIDERS = (2, 5)
DEGREE_RAD = math.pi / 180.0
INTEGRAL_END_RAD_S = 400.0 * DEGREE_RAD
"""Rate error at which its integral stops growing [rad/s]."""
MIN_YAW_WEIGHT = 1e-4
PX4_LENGTH_OFFSET = 1e-12
MIN_UNALLOCATED_TORQUE = 1.2e-7
"""FLT_EPSILON: integrals ignore a smaller unallocated torque."""

PARAMETERS = (
    gain("MPC_XY_P", "1/s", (0.0, 10.0), 0.95, "position P gain, horizontal", "Position"),
    gain("MPC_Z_P", "1/s", (0.0, 10.0), 1.0, "position P gain, vertical", "Position"),
    gain("MPC_XY_VEL_P_ACC", "1/s", (0.1, 50.0), 1.8, "velocity P gain, horizontal", "Velocity"),
    gain("MPC_XY_VEL_I_ACC", "1/s^2", (0.0, 60.0), 0.4, "velocity I gain, horizontal", "Velocity"),
    gain("MPC_XY_VEL_D_ACC", "1", (0.0, 10.0), 0.2, "velocity D gain, horizontal", "Velocity"),
    gain("MPC_Z_VEL_P_ACC", "1/s", (0.1, 50.0), 4.0, "velocity P gain, vertical", "Velocity"),
    gain("MPC_Z_VEL_I_ACC", "1/s^2", (0.0, 30.0), 2.0, "velocity I gain, vertical", "Velocity"),
    gain("MPC_Z_VEL_D_ACC", "1", (0.0, 10.0), 0.0, "velocity D gain, vertical", "Velocity"),
    gain("MPC_XY_VEL_MAX", "m/s", (0.0, 60.0), 12.0, "maximum horizontal velocity", "Velocity"),
    gain("MPC_Z_VEL_MAX_UP", "m/s", (0.1, 40.0), 3.0, "maximum climb rate", "Velocity"),
    gain("MPC_Z_VEL_MAX_DN", "m/s", (0.1, 40.0), 1.5, "maximum descent rate", "Velocity"),
    gain("MPC_TILTMAX_AIR", "deg", (5.0, 89.0), 45.0, "maximum tilt", "Thrust"),
    gain("MPC_THR_HOVER", "1", (0.02, 0.95), 0.5, "hover thrust", "Thrust"),
    gain("MPC_THR_MIN", "1", (0.01, 1.0), 0.12, "minimum collective thrust", "Thrust"),
    gain("MPC_THR_MAX", "1", (0.0, 1.0), 1.0, "maximum collective thrust", "Thrust"),
    gain("MPC_THR_XY_MARG", "1", (0.0, 1.0), 0.3, "horizontal thrust margin", "Thrust"),
    gain("MPC_ACC_DECOUPLE", "1", (0.0, 1.0), 1.0, "1: tilt independent of climb", "Thrust"),
    gain("MC_ROLL_P", "1/s", (0.0, 50.0), 4.0, "attitude P gain, roll", "Attitude"),
    gain("MC_PITCH_P", "1/s", (0.0, 50.0), 4.0, "attitude P gain, pitch", "Attitude"),
    gain("MC_YAW_P", "1/s", (0.0, 50.0), 2.8, "attitude P gain, yaw", "Attitude"),
    gain("MC_YAW_WEIGHT", "1", (0.0, 1.0), 0.4, "yaw weight", "Attitude"),
    gain("MC_ROLLRATE_MAX", "deg/s", (0.0, 1800.0), 220.0, "maximum roll rate", "Attitude"),
    gain("MC_PITCHRATE_MAX", "deg/s", (0.0, 1800.0), 220.0, "maximum pitch rate", "Attitude"),
    gain("MC_YAWRATE_MAX", "deg/s", (0.0, 1800.0), 200.0, "maximum yaw rate", "Attitude"),
    *(
        gain(f"MC_{axis}RATE_{name}", unit, limits, value, f"{axis.lower()} rate {what}", "Rate")
        for axis, values in (
            ("ROLL", (0.15, 0.2, 0.003, 0.0, 1.0, 0.3)),
            ("PITCH", (0.15, 0.2, 0.003, 0.0, 1.0, 0.3)),
            ("YAW", (0.2, 0.1, 0.0, 0.0, 1.0, 0.3)),
        )
        for (name, unit, limits, what), value in zip(
            (
                ("P", "s/rad", (0.0, 10.0), "P gain"),
                ("I", "1/rad", (0.0, 20.0), "I gain"),
                ("D", "s^2/rad", (0.0, 1.0), "D gain"),
                ("FF", "s/rad", (0.0, 10.0), "feedforward"),
                ("K", "1", (0.0, 10.0), "overall gain"),
            ),
            values,
            strict=False,
        )
    ),
    gain("MC_RR_INT_LIM", "1", (0.0, 10.0), 0.3, "roll rate I limit", "Rate"),
    gain("MC_PR_INT_LIM", "1", (0.0, 10.0), 0.3, "pitch rate I limit", "Rate"),
    gain("MC_YR_INT_LIM", "1", (0.0, 10.0), 0.3, "yaw rate I limit", "Rate"),
    gain("MC_YAW_TQ_CUTOFF", "Hz", (0.0, 100.0), 2.0, "yaw torque low-pass cutoff", "Rate"),
    gain("IMU_GYRO_CUTOFF", "Hz", (0.0, 1000.0), 40.0, "gyro low-pass cutoff", "Filters"),
    gain("IMU_DGYRO_CUTOFF", "Hz", (0.0, 1000.0), 20.0, "D low-pass cutoff", "Filters"),
    gain("MC_AIRMODE", "1", (0.0, 2.0), 0.0, "0 off, 1 roll and pitch, 2 with yaw", "Motors"),
    gain("THR_MDL_FAC", "1", (0.0, 1.0), 0.0, "thrust model factor", "Motors"),
    gain("SIM_GZ_EC_MIN", "rad/s", (0.0, 5000.0), 150.0, "motor speed at signal 0", "Motors"),
    gain("SIM_GZ_EC_MAX", "rad/s", (1.0, 5000.0), 1000.0, "motor speed at signal 1", "Motors"),
)

MEMORY = (
    *states("i_velocity", "m/s^2"),
    State("attitude_w", "1", 1.0),
    *states("attitude", "1"),
    *states("rate_sp", "rad/s"),
    *states("i_rate", "1"),
    *states("gyro_1", "rad/s"),
    *states("gyro_2", "rad/s"),
    *states("rate_before", "rad/s"),
    *states("slope", "rad/s^2"),
    *states("left_over", "1"),
    State("thrust", "1"),
    State("yaw_torque", "1"),
    State("yaw_sp", "rad"),
    State("runs", "1"),
)

POINTS = stage_points("rad", "1")

_PX4_LEVEL_GAINS = ("MPC_XY_VEL_P_ACC", "MPC_XY_VEL_I_ACC", "MPC_XY_VEL_D_ACC")
_PX4_CLIMB_GAINS = ("MPC_Z_VEL_P_ACC", "MPC_Z_VEL_I_ACC", "MPC_Z_VEL_D_ACC")
_PX4_ANGLES = ("ROLL", "PITCH", "YAW")
LOOPS = stage_loops(
    (("MPC_XY_P",), ("MPC_XY_P",), ("MPC_Z_P",)),
    (_PX4_LEVEL_GAINS, _PX4_LEVEL_GAINS, _PX4_CLIMB_GAINS),
    [(f"MC_{name}_P",) for name in _PX4_ANGLES],
    [tuple(f"MC_{name}RATE_{term}" for term in "PID") for name in _PX4_ANGLES],
)

DESIGNED = (
    *MIXER_NUMBER_NAMES,
    *TORQUE_SCALE_NAMES,
    *(f"gyro_{name}" for name in LOWPASS_COEFFICIENTS),
    "slope_share",
    "cos_tilt",
    "sin_tilt",
    "yaw_share",
    "motor_constant",
    "linear_speed",
)


def design(vehicle: KnownVehicle, g: Gains, dt: float) -> list[float]:
    """Return columns of the allocation, filters, limits, and motor constants."""
    tilt = g.MPC_TILTMAX_AIR * DEGREE_RAD
    mix, scales = px4_mixing(vehicle.rotors)
    return [
        *column_numbers(vehicle.rotors, mix),
        *scales,
        *butterworth(g.IMU_GYRO_CUTOFF, dt),
        first_order(g.IMU_DGYRO_CUTOFF, dt),
        math.cos(tilt),
        math.sin(tilt),
        first_order(g.MC_YAW_TQ_CUTOFF, dt),
        vehicle.rotors[0].motor_constant,
        vehicle.rotors[0].linear_speed,
    ]


def constrained_velocity(
    p_x: float, p_y: float, f_x: float, f_y: float, most: float
) -> tuple[float, float]:
    """Return the sum of two horizontal velocities within a limit; the first has priority."""
    x, y = p_x + f_x, p_y + f_y
    if x * x + y * y <= most * most:
        return x, y
    size = p_x * p_x + p_y * p_y
    if size >= most * most:
        scale = most / size**0.5
        return scale * p_x, scale * p_y
    length = (f_x * f_x + f_y * f_y) ** 0.5
    u_x, u_y = f_x / length, f_y / length
    along = u_x * p_x + u_y * p_y
    s = (along * along - size + most * most) ** 0.5 - along
    return p_x + s * u_x, p_y + s * u_y


def commanded_quaternion(z: Vector3, yaw: float) -> Quaternion:
    """Return the quaternion whose z axis is a unit vector, at a yaw [rad]."""
    cos, sin = cosine_sine(yaw)
    x = cos * z[2], sin * z[2], -sin * z[1] - cos * z[0]
    length = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) ** 0.5 + PX4_LENGTH_OFFSET
    x = x[0] / length, x[1] / length, x[2] / length
    # the tilt, and the turn about z that brings the x axis there
    tilt = shortest_turn((0.0, 0.0, 1.0), z)
    a_x = 1.0 - 2.0 * (tilt[2] * tilt[2] + tilt[3] * tilt[3])
    a_y = 2.0 * (tilt[1] * tilt[2] + tilt[0] * tilt[3])
    a_z = 2.0 * (tilt[1] * tilt[3] - tilt[0] * tilt[2])
    cross = (a_y * x[2] - a_z * x[1], a_z * x[0] - a_x * x[2], a_x * x[1] - a_y * x[0])
    along = cross[0] * z[0] + cross[1] * z[1] + cross[2] * z[2]
    half = 0.5 * arctan2(along, a_x * x[0] + a_y * x[1] + a_z * x[2])
    cos, sin = cosine_sine(half)
    return product(tilt, (cos, 0.0 * cos, 0.0 * cos, sin))


def rate_setpoint(q: Quaternion, q_d: Quaternion, weight: float) -> Vector3:
    """Return twice the vector part of the attitude error, with the weight of yaw (3)."""
    turn = shortest_turn(upright(q), upright(q_d))
    reduced = q_d
    if turn[0] >= 1e-5:
        reduced = product(turn, q)
    mix = canonical(product(inverse(reduced), q_d))
    cos, sin = cosine_sine(weight * arctan2(mix[3], mix[0]))
    e = canonical(product(inverse(q), product(reduced, (cos, 0.0 * cos, 0.0 * cos, sin))))
    return 2.0 * e[1], 2.0 * e[2], 2.0 * e[3]


def next_rate_integral(
    integral: float, e: float, left: float, slope: float, most: float, dt: float
) -> float:
    """Return the integral of a rate after an update.

    Args:
        integral: before.
        e: error of the rate [rad/s].
        left: unallocated torque: if it is positive, only a negative error is integrated, and vice
            versa.
        slope: growth per error.
        most: its limit.
        dt: since the update before [s].
    """
    if left > MIN_UNALLOCATED_TORQUE and e > 0.0:
        e = 0.0 * e
    if left < -MIN_UNALLOCATED_TORQUE and e < 0.0:
        e = 0.0 * e
    share = 1.0 - e * e / (INTEGRAL_END_RAD_S * INTEGRAL_END_RAD_S)
    if share < 0.0:
        share = 0.0 * share
    return clipped(integral + share * slope * e * dt, most)


def speed_signal(u: float, factor: float) -> float:
    """Return the motor signal of a thrust share, 0 .. 1."""
    if factor < 1e-6:
        return u
    b = 0.5 * (1.0 - factor) / factor
    return (b * b + u / factor) ** 0.5 - b


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
    m, v, a, first = memory, measured.v_WBcm, measured.a_WBcm, memory.runs < 0.5
    q = normalized(measured.q_WT)
    R = attitude_matrix(q)
    s_x, s_y, s_z, yaw_rate = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)
    yaw_sp = arctan2(R[3], R[0]) if first else m.yaw_sp + yaw_rate * dt
    if yaw_sp > math.pi:
        yaw_sp = yaw_sp - 2.0 * math.pi
    if yaw_sp < -math.pi:
        yaw_sp = yaw_sp + 2.0 * math.pi

    # position and velocity
    thrust = m.thrust
    q_d = (m.attitude_w, m.attitude_x, m.attitude_y, m.attitude_z)
    i_x, i_y, i_z = m.i_velocity_x, m.i_velocity_y, m.i_velocity_z
    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    since = measured.elapsed[1]
    e_x, e_y, e_z = 0.0 * v[0], 0.0 * v[1], 0.0 * v[2]
    if since > 0.0 or first:
        p_x, p_y, p_z = g.MPC_XY_P * e[0], g.MPC_XY_P * e[1], g.MPC_Z_P * e[2]
        w_x, w_y = constrained_velocity(p_x, p_y, s_x, s_y, g.MPC_XY_VEL_MAX)
        w_z = between(p_z + s_z, -g.MPC_Z_VEL_MAX_DN, g.MPC_Z_VEL_MAX_UP)
        added = w_x - s_x, w_y - s_y, w_z - s_z
        w_x, w_y, w_z, _ = velocity_setpoint(added, measured, setpoint, g)
        e_x, e_y, e_z = w_x - v[0], w_y - v[1], w_z - v[2]
    e_x, e_y, e_z = probe3((e_x, e_y, e_z), VELOCITY_POINT, loops)
    if since > 0.0 or first:
        period = since if since > 0.0 else DIVIDERS[1] * dt
        i_z = clipped(i_z, GRAVITY)
        ahead = setpoint.a_WBcm
        a_x = ahead[0] + g.MPC_XY_VEL_P_ACC * e_x + i_x - g.MPC_XY_VEL_D_ACC * a[0]
        a_y = ahead[1] + g.MPC_XY_VEL_P_ACC * e_y + i_y - g.MPC_XY_VEL_D_ACC * a[1]
        a_z = ahead[2] + g.MPC_Z_VEL_P_ACC * e_z + i_z - g.MPC_Z_VEL_D_ACC * a[2]
        pull = GRAVITY if g.MPC_ACC_DECOUPLE > 0.5 else GRAVITY + a_z
        length = (a_x * a_x + a_y * a_y + pull * pull) ** 0.5
        z_x, z_y, z_z = a_x / length, a_y / length, pull / length
        if z_z < g.cos_tilt:
            level = (z_x * z_x + z_y * z_y) ** 0.5 + PX4_LENGTH_OFFSET
            z_x, z_y = g.sin_tilt * z_x / level, g.sin_tilt * z_y / level
            z_z = g.cos_tilt + 0.0 * z_z
        collective = g.MPC_THR_HOVER * (1.0 + a_z / GRAVITY) / z_z
        if collective < g.MPC_THR_MIN:
            collective = g.MPC_THR_MIN + 0.0 * collective
        t_x, t_y, t_z = collective * z_x, collective * z_y, collective * z_z
        up = e_z
        if (t_z <= g.MPC_THR_MIN and up <= 0.0) or (t_z >= g.MPC_THR_MAX and up >= 0.0):
            up = 0.0 * up
        most = g.MPC_THR_MAX * g.MPC_THR_MAX
        level = t_x * t_x + t_y * t_y
        margin = g.MPC_THR_XY_MARG * g.MPC_THR_XY_MARG
        room = most - (level if level < margin else margin)
        highest = room**0.5 if room > 0.0 else 0.0 * room  # THR_MAX may be below THR_XY_MARG
        if t_z > highest:
            t_z = highest
        rest = most - t_z * t_z
        if level > rest:
            shrink = (rest if rest > 0.0 else 0.0 * rest) / level
            t_x, t_y = t_x * shrink**0.5, t_y * shrink**0.5
        made_x, made_y = t_x * GRAVITY / g.MPC_THR_HOVER, t_y * GRAVITY / g.MPC_THR_HOVER
        if a_x * a_x + a_y * a_y > made_x * made_x + made_y * made_y:
            e_x = e_x - 2.0 / g.MPC_XY_VEL_P_ACC * (a_x - made_x)
            e_y = e_y - 2.0 / g.MPC_XY_VEL_P_ACC * (a_y - made_y)
        i_x = i_x + g.MPC_XY_VEL_I_ACC * e_x * period
        i_y = i_y + g.MPC_XY_VEL_I_ACC * e_y * period
        i_z = i_z + g.MPC_Z_VEL_I_ACC * up * period
        t_x, t_y, t_z = probe_tilt((t_x, t_y, t_z), R, TILT_SETPOINT_POINT, loops)
        thrust = (t_x * t_x + t_y * t_y + t_z * t_z) ** 0.5
        q_d = commanded_quaternion((t_x / thrust, t_y / thrust, t_z / thrust), yaw_sp)

    # attitude
    weight = g.MC_YAW_WEIGHT
    e_x, e_y, e_z = probe3(rate_setpoint(q, q_d, weight), ATTITUDE_STAGE_POINT, loops)
    r_x, r_y, r_z = m.rate_sp_x, m.rate_sp_y, m.rate_sp_z
    if measured.elapsed[0] > 0.0 or first:
        yaw_p = g.MC_YAW_P / weight if weight > MIN_YAW_WEIGHT else g.MC_YAW_P + 0.0 * weight
        turn = yaw_rate
        r_x = clipped(g.MC_ROLL_P * e_x + R[6] * turn, g.MC_ROLLRATE_MAX * DEGREE_RAD)
        r_y = clipped(g.MC_PITCH_P * e_y + R[7] * turn, g.MC_PITCHRATE_MAX * DEGREE_RAD)
        r_z = clipped(yaw_p * e_z + R[8] * turn, g.MC_YAWRATE_MAX * DEGREE_RAD)

    # rates, filtered
    w = into_body(R, measured.w_WB)
    before = m.rate_before_x, m.rate_before_y, m.rate_before_z
    one, two = (m.gyro_1_x, m.gyro_1_y, m.gyro_1_z), (m.gyro_2_x, m.gyro_2_y, m.gyro_2_z)
    if first:
        share = 1.0 / (1.0 + g.gyro_a1 + g.gyro_a2)
        one = share * w[0], share * w[1], share * w[2]
        two, before = one, w
    low = (g.gyro_b0, g.gyro_b1, g.gyro_b2, g.gyro_a1, g.gyro_a2)
    (p, q_, r), now = second_order_filtered(w, one, two, low)
    gyro = (*now, *one)
    slope = ((p - before[0]) / dt, (q_ - before[1]) / dt, (r - before[2]) / dt)
    alpha = first_order_filtered((m.slope_x, m.slope_y, m.slope_z), slope, g.slope_share)

    # rate control
    s_x = probe(r_x, RATE_SETPOINT_POINT, loops)
    s_y = probe(r_y, RATE_SETPOINT_POINT + 1, loops)
    e_x, e_y, e_z = probe3((s_x - p, s_y - q_, r_z - r), RATE_STAGE_POINT, loops)
    k_x, k_y, k_z = g.MC_ROLLRATE_K, g.MC_PITCHRATE_K, g.MC_YAWRATE_K
    roll = k_x * g.MC_ROLLRATE_P * e_x + m.i_rate_x - k_x * g.MC_ROLLRATE_D * alpha[0]
    pitch = k_y * g.MC_PITCHRATE_P * e_y + m.i_rate_y - k_y * g.MC_PITCHRATE_D * alpha[1]
    yaw = k_z * g.MC_YAWRATE_P * e_z + m.i_rate_z - k_z * g.MC_YAWRATE_D * alpha[2]
    roll = roll + g.MC_ROLLRATE_FF * s_x
    pitch = pitch + g.MC_PITCHRATE_FF * s_y
    yaw = yaw + g.MC_YAWRATE_FF * r_z
    i_p = next_rate_integral(
        m.i_rate_x, e_x, m.left_over_x, k_x * g.MC_ROLLRATE_I, g.MC_RR_INT_LIM, dt
    )
    i_q = next_rate_integral(
        m.i_rate_y, e_y, m.left_over_y, k_y * g.MC_PITCHRATE_I, g.MC_PR_INT_LIM, dt
    )
    i_r = next_rate_integral(
        m.i_rate_z, e_z, m.left_over_z, k_z * g.MC_YAWRATE_I, g.MC_YR_INT_LIM, dt
    )
    yaw = yaw if first else m.yaw_torque + g.yaw_share * (yaw - m.yaw_torque)
    smooth = yaw
    roll, pitch, yaw = probe3((roll, pitch, yaw), TORQUE_STAGE_POINT, loops)

    # allocation and motors
    mix, by = mixer_columns(g), effects_per_thrust(g)
    u = px4_allocated((roll, pitch, yaw, thrust), g.MC_AIRMODE, mix)
    scales = g.roll_scale, g.pitch_scale, g.yaw_scale
    left = px4_unallocated_torque(u, (roll, pitch, yaw), scales, by)
    none = 0.0 * thrust
    wrench = (none, none, none, none)
    for i in range(MAX_MIXER_MOTORS):
        signal = speed_signal(u[i], g.THR_MDL_FAC)
        speed = g.SIM_GZ_EC_MIN + (g.SIM_GZ_EC_MAX - g.SIM_GZ_EC_MIN) * signal
        wrench = with_motor(wrench, i, g.motor_constant * speed * (speed + g.linear_speed), by)
    outer = (i_x, i_y, i_z, *q_d, r_x, r_y, r_z, i_p, i_q, i_r)
    inner = (*gyro, p, q_, r, *alpha, *left)
    return wrench, (*outer, *inner, thrust, smooth, yaw_sp, 1.0 + none)


X500_TORQUE_EFFECT = (231.0, 230.0, 16.3)
"""Angular acceleration of PX4's X500 in Gazebo over torque about x, y and z, in hover [rad/s²]."""
IDLE_SPEED_RATIO = 0.15
"""Speed at a signal of 0, over the largest one."""


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return values for a vehicle: motors, hover thrust, and gains unless it is like an X500.

    The gains are those of the PD cascade in this form: rate P = kd, attitude P = 0.3 kd, integrals
    and derivatives in the proportions of PX4's defaults.
    """
    pd, frame = pd_rule(vehicle), thrust_frame(vehicle)
    fastest = vehicle.rotors[0].max_rot_velocity
    least = IDLE_SPEED_RATIO * fastest
    signals = (frame.hover_speeds - least) / (fastest - least)
    rotors = known_vehicle(law_constants(vehicle)).rotors
    mix, _ = px4_mixing(rotors)
    turned = hover_authority(rotors, frame, mix, fastest - least)[:3]
    values = {
        "MPC_THR_HOVER": float(np.mean(signals)),
        "SIM_GZ_EC_MIN": least,
        "SIM_GZ_EC_MAX": fastest,
    }
    if all(flies_with_defaults(turned, X500_TORQUE_EFFECT)):
        return values
    for axis, kp, place in (
        ("ROLL", "kd_roll", 0),
        ("PITCH", "kd_pitch", 1),
        ("YAW", "kp_yaw_rate", 2),
    ):
        rate = pd[kp] / turned[place]
        values[f"MC_{axis}RATE_P"] = rate
        values[f"MC_{axis}RATE_I"] = (0.5 if axis == "YAW" else 1.3) * rate
        values[f"MC_{axis}RATE_D"] = (0.0 if axis == "YAW" else 0.01) * rate
        values[f"MC_{axis}_P"] = 0.3 * pd[kp]
    return {
        **values,
        "MPC_XY_P": pd["kp_position_xy"],
        "MPC_Z_P": pd["kp_position_z"],
        "MPC_XY_VEL_P_ACC": pd["kp_velocity_x"],
        "MPC_XY_VEL_I_ACC": 0.2 * pd["kp_velocity_x"],
        "MPC_Z_VEL_P_ACC": pd["kp_velocity_z"],
        "MPC_Z_VEL_I_ACC": 0.5 * pd["kp_velocity_z"],
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
    }
