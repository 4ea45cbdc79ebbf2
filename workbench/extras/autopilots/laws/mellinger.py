"""Mellinger controller of the Crazyflie firmware 2025.12.

With errors of position r = p_d - p and velocity v_e = v_d - v, their limited integral i, and z the
thrust's direction, all loops at 512 Hz (500 Hz in the firmware):

    F = mass (a_d + g e_z) + kp r + kd v_e + ki i,    thrust = massThrust F · z
    z_d = F / |F|,   y_d = z_d x x_c / |z_d x x_c|,   x_d = y_d x z_d,   x_c = (cos ψ_d, sin ψ_d, 0)
    e_R = (R_dᵀ R - Rᵀ R_d)^v,   e_ω = ω_d - ω
    M = -kR e_R + kw e_ω + ki_m ∫ -e_R + kd_omega de_ω/dt          clipped at ±32000, in 65535ths

If thrust is not above 0, the torque is zero and the integrals are reset.

ψ_d is the present yaw plus the commanded yaw rate times the update period, so the heading is not
held. M is the torque for the power distribution, with ω in rad/s. The firmware has no ½ in e_R, and
no derivative of the yaw-rate error.

Attitudes: as in the firmware, it recovers only where F points upwards of the rotors, F · z > 0: up
to a tilt of 90° at rest. Beyond, thrust and torque are zero, and it falls as it is, or tumbles on.

Source: bitcraze/crazyflie-firmware, controller_mellinger.c; Mellinger and Kumar, "Minimum Snap
Trajectory Generation and Control for Quadrotors", ICRA 2011. docs/autopilots.md lists omissions.
"""

from workbench.controllers import (
    GRAVITY,
    POSITION_POINT,
    SETPOINT_POINT,
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
    attitude_matrix,
    clipped,
    gain,
    into_body,
    level_heading,
    loops_about,
    loops_along,
    points,
    position_error,
    probe3,
    probe_tilt,
    states,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.extras.autopilots.crazyflie_power import (
    FULL_MOTOR_SIGNAL,
    MOTOR_EFFECTS,
    larger_motors,
    motor_effects,
    power_distribution,
)
from workbench.plant.vehicle import Vehicle

PERIOD = 1 / 512
MAX_MELLINGER_TORQUE = 32000.0
MELLINGER_LENGTH_OFFSET = 1e-30
"""Added to a length, to avoid a division by zero."""

PARAMETERS = (
    gain("ctrlMel_kp_xy", "N/m", (0.0, 20.0), 0.4, "position P gain, horizontal", "Position"),
    gain("ctrlMel_kd_xy", "N*s/m", (0.0, 20.0), 0.2, "position D gain, horizontal", "Position"),
    gain("ctrlMel_ki_xy", "N/(m*s)", (0.0, 20.0), 0.05, "position I gain, horizontal", "Position"),
    gain("ctrlMel_i_range_xy", "m*s", (0.0, 20.0), 2.0, "position I limit, horizontal", "Position"),
    gain("ctrlMel_kp_z", "N/m", (0.0, 20.0), 1.25, "position P gain, vertical", "Position"),
    gain("ctrlMel_kd_z", "N*s/m", (0.0, 20.0), 0.4, "position D gain, vertical", "Position"),
    gain("ctrlMel_ki_z", "N/(m*s)", (0.0, 20.0), 0.05, "position I gain, vertical", "Position"),
    gain("ctrlMel_i_range_z", "m*s", (0.0, 20.0), 0.4, "position I limit, vertical", "Position"),
    gain("ctrlMel_mass", "kg", (0.001, 20.0), 0.029, "mass", "Position"),
    gain("ctrlMel_massThrust", "1/N", (1.0, 1e6), 132000.0, "thrust per newton", "Position"),
    gain("ctrlMel_kR_xy", "1", (0.0, 1e6), 70000.0, "attitude P gain, tilt", "Attitude"),
    gain("ctrlMel_kw_xy", "s", (0.0, 3e5), 20000.0, "attitude D gain, tilt", "Attitude"),
    gain("ctrlMel_ki_m_xy", "1/s", (0.0, 1e5), 0.0, "attitude I gain, tilt", "Attitude"),
    gain("ctrlMel_i_range_m_xy", "s", (0.0, 1e4), 1.0, "attitude I limit, tilt", "Attitude"),
    gain("ctrlMel_kd_omega_rp", "s^2", (0.0, 5e3), 200.0, "rate D gain, tilt", "Attitude"),
    gain("ctrlMel_kR_z", "1", (0.0, 1e6), 60000.0, "attitude P gain, yaw", "Yaw"),
    gain("ctrlMel_kw_z", "s", (0.0, 3e5), 12000.0, "attitude D gain, yaw", "Yaw"),
    gain("ctrlMel_ki_m_z", "1/s", (0.0, 1e5), 500.0, "attitude I gain, yaw", "Yaw"),
    gain("ctrlMel_i_range_m_z", "s", (0.0, 1e4), 1500.0, "attitude I limit, yaw", "Yaw"),
    gain("thrust_max", "N", (0.001, 100.0), 0.12, "motor thrust at full scale", "Motors"),
    gain("vbat", "V", (1.0, 60.0), 4.2, "full battery voltage", "Motors"),
)

MEMORY = (
    *states("i_position", "m*s"),
    *states("i_attitude", "s"),
    *states("rate_before", "rad/s", "xy"),
    State("runs", "1"),
)

POINTS = points(
    {
        "position_{}_error": "m",
        "velocity_{}_error": "m/s",
        "force_{}": "N",
        "rate_{}_error": "rad/s",
        "torque_{}": "1",
    }
) | {"roll_setpoint": "1", "pitch_setpoint": "1"}
MELLINGER_FORCE_POINT = 6
MELLINGER_RATE_POINT = 9
MELLINGER_TORQUE_POINT = 12


def _gains(names: str) -> tuple[str, ...]:
    return tuple(f"ctrlMel_{name}" for name in names.split())


_MELLINGER_TILT_GAINS = _gains("kR_xy kw_xy kd_omega_rp")
_MELLINGER_POSITION_GAINS = (_gains("kp_xy ki_xy"), _gains("kp_xy ki_xy"), _gains("kp_z ki_z"))
_MELLINGER_VELOCITY_GAINS = (_gains("kd_xy"), _gains("kd_xy"), _gains("kd_z"))
_MELLINGER_ATTITUDE_GAINS = (
    _MELLINGER_TILT_GAINS,
    _MELLINGER_TILT_GAINS,
    _gains("kR_z kw_z ki_m_z"),
)
LOOPS = (
    *loops_along("velocity", "force", _MELLINGER_VELOCITY_GAINS),
    *loops_about(("roll", "pitch", "yaw"), "rate", "torque", _MELLINGER_ATTITUDE_GAINS),
    *loops_along("position", "", _MELLINGER_POSITION_GAINS, hold=True),
)

DESIGNED = MOTOR_EFFECTS


def design(vehicle: KnownVehicle, g: Gains, dt: float) -> list[float]:
    """Return the effects of each motor's thrust, and the turning direction of m1."""
    return motor_effects(vehicle.rotors)


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
    m, v, a = memory, measured.v_WBcm, setpoint.a_WBcm
    R = attitude_matrix(measured.q_WT)
    w_x, w_y, w_z = into_body(R, measured.w_WB)
    s_x, s_y, s_z, yaw_rate = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)

    r = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    e = probe3((s_x - v[0], s_y - v[1], s_z - v[2]), VELOCITY_POINT, loops)
    i_x = clipped(m.i_position_x + r[0] * dt, g.ctrlMel_i_range_xy)
    i_y = clipped(m.i_position_y + r[1] * dt, g.ctrlMel_i_range_xy)
    i_z = clipped(m.i_position_z + r[2] * dt, g.ctrlMel_i_range_z)
    kp, kd, ki = g.ctrlMel_kp_xy, g.ctrlMel_kd_xy, g.ctrlMel_ki_xy
    climbing = g.ctrlMel_kp_z * r[2] + g.ctrlMel_kd_z * e[2] + g.ctrlMel_ki_z * i_z
    F_x, F_y, F_z = probe3(
        (
            g.ctrlMel_mass * a[0] + kp * r[0] + kd * e[0] + ki * i_x,
            g.ctrlMel_mass * a[1] + kp * r[1] + kd * e[1] + ki * i_y,
            g.ctrlMel_mass * (a[2] + GRAVITY) + climbing,
        ),
        MELLINGER_FORCE_POINT,
        loops,
    )
    F_x, F_y, F_z = probe_tilt((F_x, F_y, F_z), R, SETPOINT_POINT, loops)
    thrust = g.ctrlMel_massThrust * (F_x * R[2] + F_y * R[5] + F_z * R[8])

    heading_x, heading_y, _ = level_heading(R)
    turn = yaw_rate * dt
    # cosine and sine of so small an angle, exact to 1e-12
    cos, sin = 1.0 - 0.5 * turn * turn, turn - turn * turn * turn / 6.0
    c_x, c_y = heading_x * cos - heading_y * sin, heading_y * cos + heading_x * sin
    length = (F_x * F_x + F_y * F_y + F_z * F_z) ** 0.5 + MELLINGER_LENGTH_OFFSET
    z_x, z_y, z_z = F_x / length, F_y / length, F_z / length
    y_x, y_y, y_z = -z_z * c_y, z_z * c_x, z_x * c_y - z_y * c_x
    length = (y_x * y_x + y_y * y_y + y_z * y_z) ** 0.5 + MELLINGER_LENGTH_OFFSET
    y_x, y_y, y_z = y_x / length, y_y / length, y_z / length
    x_x, x_y, x_z = y_y * z_z - y_z * z_y, y_z * z_x - y_x * z_z, y_x * z_y - y_y * z_x
    # of R_dᵀ R and its transpose: rows are desired axes, columns are those of the body
    e_x = z_x * R[1] + z_y * R[4] + z_z * R[7] - (y_x * R[2] + y_y * R[5] + y_z * R[8])
    e_y = x_x * R[2] + x_y * R[5] + x_z * R[8] - (z_x * R[0] + z_y * R[3] + z_z * R[6])
    e_z = y_x * R[0] + y_y * R[3] + y_z * R[6] - (x_x * R[1] + x_y * R[4] + x_z * R[7])

    e_p, e_q, e_r = probe3((-w_x, -w_y, yaw_rate - w_z), MELLINGER_RATE_POINT, loops)
    first = m.runs < 0.5
    slope_x = 0.0 * w_x if first else (m.rate_before_x - w_x) / dt
    slope_y = 0.0 * w_y if first else (m.rate_before_y - w_y) / dt
    i_roll = clipped(m.i_attitude_x - e_x * dt, g.ctrlMel_i_range_m_xy)
    i_pitch = clipped(m.i_attitude_y - e_y * dt, g.ctrlMel_i_range_m_xy)
    i_yaw = clipped(m.i_attitude_z - e_z * dt, g.ctrlMel_i_range_m_z)
    kR, kw, ki, kd = g.ctrlMel_kR_xy, g.ctrlMel_kw_xy, g.ctrlMel_ki_m_xy, g.ctrlMel_kd_omega_rp
    roll = clipped(-kR * e_x + kw * e_p + ki * i_roll + kd * slope_x, MAX_MELLINGER_TORQUE)
    pitch = clipped(-kR * e_y + kw * e_q + ki * i_pitch + kd * slope_y, MAX_MELLINGER_TORQUE)
    yaw = -g.ctrlMel_kR_z * e_z + g.ctrlMel_kw_z * e_r + g.ctrlMel_ki_m_z * i_yaw
    roll, pitch, yaw = probe3(
        (roll, pitch, clipped(yaw, MAX_MELLINGER_TORQUE)), MELLINGER_TORQUE_POINT, loops
    )
    if thrust <= 0.0:  # as in the firmware
        thrust, roll, pitch, yaw = 0.0 * thrust, 0.0 * roll, 0.0 * pitch, 0.0 * yaw
        i_x, i_y, i_z = 0.0 * i_x, 0.0 * i_y, 0.0 * i_z
        i_roll, i_pitch, i_yaw = 0.0 * i_roll, 0.0 * i_pitch, 0.0 * i_yaw
    wrench = power_distribution(thrust, (roll, -pitch, yaw), g, g.vbat * measured.voltage)
    after = (i_x, i_y, i_z, i_roll, i_pitch, i_yaw, w_x, w_y, 1.0 + 0.0 * thrust)
    return wrench, after


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return values for a vehicle; the firmware's for one of a Crazyflie's size.

    Other vehicles have the gains of the PD cascade in this form: e_R is about twice the angle.
    """
    motors = larger_motors(vehicle)
    if motors is None:
        return {}
    pd = pd_rule(vehicle)
    level, climb = pd["kp_velocity_x"], pd["kp_velocity_z"]
    tilt = min(pd["kp_roll"] / motors.roll, pd["kp_pitch"] / motors.pitch)
    damped = min(pd["kd_roll"] / motors.roll, pd["kd_pitch"] / motors.pitch)
    yaw = pd["kp_yaw_rate"] / motors.yaw
    values = {
        "thrust_max": motors.thrust_max,
        "mass": vehicle.mass,
        "massThrust": FULL_MOTOR_SIGNAL / (len(vehicle.rotors) * motors.thrust_max),
        "kp_xy": vehicle.mass * level * pd["kp_position_xy"],
        "kd_xy": vehicle.mass * level,
        "ki_xy": 0.1 * vehicle.mass * level * pd["kp_position_xy"],
        "kp_z": vehicle.mass * climb * pd["kp_position_z"],
        "kd_z": vehicle.mass * climb,
        "ki_z": 0.1 * vehicle.mass * climb * pd["kp_position_z"],
        "kR_xy": 0.5 * tilt,
        "kw_xy": damped,
        "kd_omega_rp": 0.01 * damped,
        "kR_z": 0.1 * pd["kp_yaw_rate"] * yaw,
        "kw_z": yaw,
        "ki_m_z": 0.001 * pd["kp_yaw_rate"] * yaw,
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
    }
    own = {row.name for row in PARAMETERS}
    return {
        f"ctrlMel_{name}" if f"ctrlMel_{name}" in own else name: value
        for name, value in values.items()
    }
