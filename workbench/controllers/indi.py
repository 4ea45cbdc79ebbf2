"""INDI: the law adds the missing acceleration to the present output of the rotors.

Incremental nonlinear dynamic inversion, after E. J. J. Smeur, Q. P. Chu, G. C. H. E. de Croon,
Adaptive incremental nonlinear dynamic inversion for attitude control of micro air vehicles, Journal
of Guidance, Control, and Dynamics 39 (3), 2016, and for the position E. J. J. Smeur, G. C. H. E. de
Croon, Q. P. Chu, Cascaded incremental nonlinear dynamic inversion for MAV disturbance rejection,
Control Engineering Practice 73, 2018. Subscript f is the filter H = 1 / (1 + `INDI_FILTER_S` s), on
measurements and on the output of the rotors, which lag their commands by τ:

    a_sp = kp_velocity (v_sp - v) + a_path                    wanted acceleration in W [m/s²]
    f    = f_f + a_sp - a_f                                   specific force in W [m/s²]
    ν    = kp_tilt e_tilt + kd_tilt (ω_sp - ω)                wanted angular acceleration
    ν_z  = kp_yaw_rate (ω_sp - ω)                             of roll, pitch and yaw [rad/s²]
    m    = m_f + I (ν - dω_f/dt),   F = mass f · z            moment in T [N·m] and force [N]

The measurements contain wind, errors of mass and inertia, and weak rotors, so the law needs no
model of these, nor of drag, nor the term ω x I ω. In yaw, the output of the rotors includes their
spin-up torque, and with the rule's feed-forward so does the command. This is the second
effectiveness matrix of the 2016 paper. Without it the increments in yaw are too large, and an
inertia error of 30 % makes yaw oscillate.
"""

from workbench.controllers import (
    ACCELERATION_POINT,
    ATTITUDE_POINT,
    CASCADE_POINTS,
    GRAVITY,
    POSITION_POINT,
    SETPOINT_POINT,
    TURN_POINT,
    VELOCITY_POINT,
    Gains,
    KnownBody,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
    Probes,
    State,
    attitude_error,
    attitude_matrix,
    difference,
    gain,
    into_body,
    loops_about,
    loops_along,
    position_error,
    probe3,
    probe_tilt,
    states,
    tilted,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.plant.vehicle import Vehicle

INDI_FILTER_S = 0.02
"""Time constant of H [s]; that of the estimated acceleration, see `acceleration_estimate`."""

PARAMETERS = (
    gain("kp_position_xy", "1/s", (0.0, 5.0), 0.8, "position P gain, horizontal", "Position"),
    gain("kp_position_z", "1/s", (0.0, 5.0), 1.0, "position P gain, vertical", "Position"),
    gain("kp_velocity_xy", "1/s", (0.0, 30.0), 3.0, "velocity P gain, horizontal", "Velocity"),
    gain("kp_velocity_z", "1/s", (0.5, 30.0), 4.0, "velocity P gain, vertical", "Velocity"),
    gain("kp_tilt", "1/s^2", (0.0, 2500.0), 150.0, "attitude P gain, roll and pitch", "Attitude"),
    gain("kd_tilt", "1/s", (0.0, 150.0), 20.0, "attitude D gain, roll and pitch", "Attitude"),
    gain("kp_yaw_rate", "1/s", (0.0, 30.0), 4.0, "yaw rate P gain", "Yaw"),
)

MEMORY = (
    State("lift_z", "m/s^2", GRAVITY),
    *states("moment", "N*m"),
    *states("force_filtered", "m/s^2", "xy"),
    State("force_filtered_z", "m/s^2", GRAVITY),
    *states("moment_filtered", "N*m"),
    *states("rate_filtered", "rad/s"),
)

POINTS = CASCADE_POINTS

_INDI_POSITION_GAINS = (("kp_position_xy",), ("kp_position_xy",), ("kp_position_z",))
_INDI_LEVEL_GAINS, _INDI_CLIMB_GAINS = ("kp_velocity_xy",), ("kp_velocity_z",)
_INDI_TILT_GAINS, _INDI_YAW_GAINS = ("kp_tilt", "kd_tilt"), ("kp_yaw_rate",)
LOOPS = (
    *loops_along(
        "velocity", "acceleration", (_INDI_LEVEL_GAINS, _INDI_LEVEL_GAINS, _INDI_CLIMB_GAINS)
    ),
    *loops_about(
        ("roll", "pitch", "yaw_rate"),
        "attitude",
        "angular_acceleration",
        (_INDI_TILT_GAINS, _INDI_TILT_GAINS, _INDI_YAW_GAINS),
    ),
    *loops_along("position", "", _INDI_POSITION_GAINS, hold=True),
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
    a, a_path, m = measured.a_WBcm, setpoint.a_WBcm, memory
    R = attitude_matrix(measured.q_WT)
    w = into_body(R, measured.w_WB)

    turning = dt / (vehicle.rotor_lag + dt)  # output of the rotors, first unfiltered
    commanded = measured.wrench
    lift = m.lift_z + turning * (commanded[0] / vehicle.mass - m.lift_z)
    m_x = m.moment_x + turning * (commanded[1] - m.moment_x)
    m_y = m.moment_y + turning * (commanded[2] - m.moment_y)
    m_z = m.moment_z + turning * (commanded[3] - m.moment_z)
    spin_up = vehicle.spin_up_time * (m_z - m.moment_z) / dt
    passed = dt / (INDI_FILTER_S + dt)
    F_x = m.force_filtered_x + passed * (R[2] * lift - m.force_filtered_x)
    F_y = m.force_filtered_y + passed * (R[5] * lift - m.force_filtered_y)
    F_z = m.force_filtered_z + passed * (R[8] * lift - m.force_filtered_z)
    M_x = m.moment_filtered_x + passed * (m_x - m.moment_filtered_x)
    M_y = m.moment_filtered_y + passed * (m_y - m.moment_filtered_y)
    M_z = m.moment_filtered_z + passed * (m_z + spin_up - m.moment_filtered_z)
    w_x = m.rate_filtered_x + passed * (w[0] - m.rate_filtered_x)
    w_y = m.rate_filtered_y + passed * (w[1] - m.rate_filtered_y)
    w_z = m.rate_filtered_z + passed * (w[2] - m.rate_filtered_z)

    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    e = g.kp_position_xy * e[0], g.kp_position_xy * e[1], g.kp_position_z * e[2]
    v_x, v_y, v_z, yaw_rate = velocity_setpoint(e, measured, setpoint, g)
    e = probe3(difference((v_x, v_y, v_z), measured.v_WBcm), VELOCITY_POINT, loops)
    f_x, f_y, f_z = probe3(
        (
            F_x + g.kp_velocity_xy * e[0] + a_path[0] - a[0],
            F_y + g.kp_velocity_xy * e[1] + a_path[1] - a[1],
            F_z + g.kp_velocity_z * e[2] + a_path[2] - a[2] - GRAVITY,
        ),
        ACCELERATION_POINT,
        loops,
    )
    f_W = probe_tilt(tilted(f_x, f_y, f_z + GRAVITY, g), R, SETPOINT_POINT, loops)

    f = into_body(R, f_W)
    w_sp = (R[6] * yaw_rate, R[7] * yaw_rate, R[8] * yaw_rate)
    e = probe3(attitude_error(f, w, w_sp), ATTITUDE_POINT, loops)
    nu_x, nu_y, nu_z = probe3(
        (
            g.kp_tilt * e[0] + g.kd_tilt * (w_sp[0] - w[0]),
            g.kp_tilt * e[1] + g.kd_tilt * (w_sp[1] - w[1]),
            g.kp_yaw_rate * e[2],
        ),
        TURN_POINT,
        loops,
    )
    d_x = nu_x - (w_x - m.rate_filtered_x) / dt
    d_y = nu_y - (w_y - m.rate_filtered_y) / dt
    d_z = nu_z - (w_z - m.rate_filtered_z) / dt
    xx, xy, xz, yy, yz, zz = vehicle.inertia
    wrench = (
        vehicle.mass * f[2],
        M_x + xx * d_x + xy * d_y + xz * d_z,
        M_y + xy * d_x + yy * d_y + yz * d_z,
        M_z + xz * d_x + yz * d_y + zz * d_z,
    )
    return wrench, (lift, m_x, m_y, m_z, F_x, F_y, F_z, M_x, M_y, M_z, w_x, w_y, w_z)


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return gains for a vehicle: the PD cascade's, with slower velocity loops.

    Weak rotors act like additional attitude lag, which matters less for slower velocity loops.
    """
    pd = pd_rule(vehicle)
    return {
        "kp_position_xy": pd["kp_position_xy"],
        "kp_position_z": pd["kp_position_z"],
        "kp_velocity_xy": 0.6 * pd["kp_velocity_x"],
        "kp_velocity_z": 0.8 * pd["kp_velocity_z"],
        "kp_tilt": min(pd["kp_roll"], pd["kp_pitch"]),
        "kd_tilt": min(pd["kd_roll"], pd["kd_pitch"]),
        "kp_yaw_rate": pd["kp_yaw_rate"],
        "spin_up_feedforward": 1.0,
        "max_climb_rate": pd["max_climb_rate"],
        "max_tilt": pd["max_tilt"],
    }
