"""PID cascade: integrals reject constant wind and an unknown mass.

With errors of position p, velocity v of the centre of mass, tilt and angular velocity ω, gains by
name, and integrals i (all by component):

    v_sp = kp_position (p_sp - p) + v_ref                    within limits, see `guidance`
    f    = kp_velocity (v_sp - v) + i_v - kd_velocity a + d + g   specific force in W [m/s²]
    ω_sp = kp_tilt e_tilt                                    roll and pitch; the reference in yaw
    α    = kp_rate (ω_sp - ω) + i_ω - kd_rate dω/dt          angular acceleration in T [rad/s²]
    m    = I α + ω x I ω,   F = mass f · z                   moment [N·m] and force [N]

    di_v/dt = ki_velocity (v_sp - v),   di_ω/dt = ki_rate (ω_sp - ω)

An integral is stored as its contribution to the output, so a change of its gain causes no jump. It
stops while its error would increase saturation (conditional integration: Åström and Hägglund,
Advanced PID Control, 2006, section 3.5): horizontal ones while the tilt limit is active, the others
while the rotors saturate. dω/dt is s / (1 + `RATE_FILTER_S` s) of ω. a is the estimated
acceleration, d the drag of still air over mass, with the sign that compensates it.
"""

from workbench.controllers import (
    ACCELERATION_POINT,
    GRAVITY,
    POSITION_POINT,
    VELOCITY_POINT,
    Gains,
    KnownBody,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
    Probes,
    attitude_error,
    attitude_matrix,
    difference,
    gain,
    integrated,
    into_body,
    loops_about,
    loops_along,
    moment,
    points,
    position_error,
    probe,
    probe3,
    probe_tilt,
    states,
    tilted,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.plant.vehicle import Vehicle

RATE_FILTER_S = 0.01
"""Time constant of the filter of dω/dt [s]."""
PID_SATURATION_TOLERANCE = 0.02
"""Tolerance of saturation: missing force over weight, or missing angular acceleration [rad/s²]."""
MAX_RATE_INTEGRAL = 10.0
"""Largest integral of a rate [rad/s²]."""

PARAMETERS = (
    gain("kp_position_xy", "1/s", (0.0, 5.0), 0.8, "position P gain, horizontal", "Position"),
    gain("kp_position_z", "1/s", (0.0, 5.0), 1.0, "position P gain, vertical", "Position"),
    gain("kp_velocity_xy", "1/s", (0.0, 30.0), 3.0, "velocity P gain, horizontal", "Velocity"),
    gain("ki_velocity_xy", "1/s^2", (0.0, 30.0), 1.5, "velocity I gain, horizontal", "Velocity"),
    gain("kd_velocity_xy", "1", (0.0, 1.0), 0.1, "velocity D gain, horizontal", "Velocity"),
    gain("kp_velocity_z", "1/s", (0.5, 30.0), 4.0, "velocity P gain, vertical", "Velocity"),
    gain("ki_velocity_z", "1/s^2", (0.0, 30.0), 3.0, "velocity I gain, vertical", "Velocity"),
    gain("kd_velocity_z", "1", (0.0, 1.0), 0.1, "velocity D gain, vertical", "Velocity"),
    gain("kp_tilt", "1/s", (0.0, 50.0), 8.0, "attitude P gain, roll and pitch", "Attitude"),
    gain("kp_rate", "1/s", (0.0, 150.0), 20.0, "rate P gain, roll and pitch", "Rate"),
    gain("ki_rate", "1/s^2", (0.0, 500.0), 20.0, "rate I gain, roll and pitch", "Rate"),
    gain("kd_rate", "1", (0.0, 1.0), 0.0, "rate D gain, roll and pitch", "Rate"),
    gain("kp_yaw_rate", "1/s", (0.0, 30.0), 4.0, "yaw rate P gain", "Yaw"),
    gain("ki_yaw_rate", "1/s^2", (0.0, 100.0), 2.0, "yaw rate I gain", "Yaw"),
)

MEMORY = (
    *states("i_velocity", "m/s^2"),
    *states("i_rate", "rad/s^2"),
    *states("rate_filtered", "rad/s", "xy"),
    *states("asked", "1"),
)

POINTS = points(
    {
        "position_{}_error": "m",
        "velocity_{}_error": "m/s",
        "acceleration_{}": "m/s^2",
        "tilt_{}_error": "1",
        "rate_{}_error": "rad/s",
        "angular_acceleration_{}": "rad/s^2",
    }
) | {
    "roll_setpoint": "1",
    "pitch_setpoint": "1",
    "roll_rate_setpoint": "rad/s",
    "pitch_rate_setpoint": "rad/s",
}
PID_TILT_POINT = 9
PID_RATE_POINT = 12
PID_TURN_POINT = 15
PID_SETPOINT_POINT = 18
PID_RATE_SETPOINT_POINT = 20


_PID_POSITION_GAINS = (("kp_position_xy",), ("kp_position_xy",), ("kp_position_z",))
_PID_LEVEL_GAINS = ("kp_velocity_xy", "ki_velocity_xy", "kd_velocity_xy")
_PID_CLIMB_GAINS = ("kp_velocity_z", "ki_velocity_z", "kd_velocity_z")
_PID_TILT_GAINS = ("kp_tilt",)
_PID_RATE_GAINS = ("kp_rate", "ki_rate", "kd_rate")
_PID_YAW_GAINS = ("kp_yaw_rate", "ki_yaw_rate")
LOOPS = (
    *loops_along(
        "velocity", "acceleration", (_PID_LEVEL_GAINS, _PID_LEVEL_GAINS, _PID_CLIMB_GAINS)
    ),
    *loops_about(("roll", "pitch"), "tilt", "", (_PID_TILT_GAINS, _PID_TILT_GAINS)),
    *loops_about(
        ("roll_rate", "pitch_rate", "yaw_rate"),
        "rate",
        "angular_acceleration",
        (_PID_RATE_GAINS, _PID_RATE_GAINS, _PID_YAW_GAINS),
    ),
    *loops_along("position", "", _PID_POSITION_GAINS, hold=True),
)


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
    v, a, d, m = measured.v_WBcm, measured.a_WBcm, measured.drag, memory
    weight = vehicle.mass * GRAVITY
    xx, yy = vehicle.inertia[0], vehicle.inertia[3]

    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    e = g.kp_position_xy * e[0], g.kp_position_xy * e[1], g.kp_position_z * e[2]
    v_x, v_y, v_z, yaw_rate = velocity_setpoint(e, measured, setpoint, g)
    e = probe3(difference((v_x, v_y, v_z), v), VELOCITY_POINT, loops)
    f_x, f_y, f_z = probe3(
        (
            g.kp_velocity_xy * e[0] + m.i_velocity_x - g.kd_velocity_xy * a[0] + d[0],
            g.kp_velocity_xy * e[1] + m.i_velocity_y - g.kd_velocity_xy * a[1] + d[1],
            g.kp_velocity_z * e[2] + m.i_velocity_z - g.kd_velocity_z * a[2] + d[2],
        ),
        ACCELERATION_POINT,
        loops,
    )
    f_W = tilted(f_x, f_y, f_z + GRAVITY, g)
    beyond_x, beyond_y = f_x - f_W[0], f_y - f_W[1]  # 0 within the largest tilt
    missing = m.asked_z - measured.wrench[0] / weight
    i_vx = integrated(m.i_velocity_x, g.ki_velocity_xy * e[0], beyond_x, 0.0, dt)
    i_vy = integrated(m.i_velocity_y, g.ki_velocity_xy * e[1], beyond_y, 0.0, dt)
    i_vz = integrated(m.i_velocity_z, g.ki_velocity_z * e[2], missing, PID_SATURATION_TOLERANCE, dt)

    R_WT = attitude_matrix(measured.q_WT)
    f_W = probe_tilt(f_W, R_WT, PID_SETPOINT_POINT, loops)
    f, w = into_body(R_WT, f_W), into_body(R_WT, measured.w_WB)
    w_sp = (R_WT[6] * yaw_rate, R_WT[7] * yaw_rate, R_WT[8] * yaw_rate)
    e_x, e_y, _ = probe3(attitude_error(f, w, w_sp), PID_TILT_POINT, loops)
    w_sp = (
        probe(g.kp_tilt * e_x + w_sp[0], PID_RATE_SETPOINT_POINT, loops),
        probe(g.kp_tilt * e_y + w_sp[1], PID_RATE_SETPOINT_POINT + 1, loops),
        w_sp[2],
    )
    e = probe3(difference(w_sp, w), PID_RATE_POINT, loops)
    dw_x = (w[0] - m.rate_filtered_x) / (RATE_FILTER_S + dt)
    dw_y = (w[1] - m.rate_filtered_y) / (RATE_FILTER_S + dt)
    alpha = probe3(
        (
            g.kp_rate * e[0] + m.i_rate_x - g.kd_rate * dw_x,
            g.kp_rate * e[1] + m.i_rate_y - g.kd_rate * dw_y,
            g.kp_yaw_rate * e[2] + m.i_rate_z + vehicle.yaw_drag * w[2],
        ),
        PID_TURN_POINT,
        loops,
    )
    missing_x = m.asked_x - measured.wrench[1] / xx
    missing_y = m.asked_y - measured.wrench[2] / yy
    past = m.i_rate_z if m.i_rate_z * m.i_rate_z > MAX_RATE_INTEGRAL * MAX_RATE_INTEGRAL else 0.0
    i_wx = integrated(m.i_rate_x, g.ki_rate * e[0], missing_x, PID_SATURATION_TOLERANCE, dt)
    i_wy = integrated(m.i_rate_y, g.ki_rate * e[1], missing_y, PID_SATURATION_TOLERANCE, dt)
    i_wz = integrated(m.i_rate_z, g.ki_yaw_rate * e[2], past, 0.0, dt)

    force = vehicle.mass * f[2]
    m_x, m_y, m_z = moment(alpha, w, vehicle.inertia)
    filtered = m.rate_filtered_x + dt * dw_x, m.rate_filtered_y + dt * dw_y
    asked = m_x / xx, m_y / yy, force / weight
    return (force, m_x, m_y, m_z), (i_vx, i_vy, i_vz, i_wx, i_wy, i_wz, *filtered, *asked)


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return gains for a vehicle: those of the PD cascade in this form, and slow integrals.

    kp_tilt kp_rate and kp_rate + kp_tilt correspond to its kp and kd, as far as real poles allow.
    An integral of a velocity is ten times slower than its loop, so that a step of velocity and a
    take-off overshoot by little more than a tenth; that of the yaw rate is five times slower.
    """
    pd = pd_rule(vehicle)
    kd = min(pd["kd_roll"], pd["kd_pitch"])
    level, climb, yaw = pd["kp_velocity_x"], pd["kp_velocity_z"], pd["kp_yaw_rate"]
    return {
        "kp_position_xy": pd["kp_position_xy"],
        "kp_position_z": pd["kp_position_z"],
        "kp_velocity_xy": level,
        "ki_velocity_xy": level * level / 10.0,
        "kd_velocity_xy": pd["kd_velocity_x"],
        "kp_velocity_z": climb,
        "ki_velocity_z": climb * climb / 10.0,
        "kd_velocity_z": pd["kd_velocity_z"],
        "kp_tilt": 0.3 * kd,
        "kp_rate": kd,
        "ki_rate": 0.05 * kd * kd,
        "kp_yaw_rate": yaw,
        "ki_yaw_rate": yaw * yaw / 5.0,
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
        "max_tilt": pd["max_tilt"],
    }
