"""PD cascade, the default control law.

With errors of the position p, the velocity v of the centre of mass, and the tilt; kp_velocity and
kd_velocity are gains for each of x, y, z:

    v_sp = kp_position (p_sp - p) + v_ref                    within limits, see `guidance`
    f    = kp_velocity (v_sp - v) - kd_velocity a + d + g_W  specific force in W [m/s²], within tilt
    α_x  = kp_roll e_tilt + kd_roll (ω_sp - ω)               components about x: roll [rad/s²]
    α_y  = kp_pitch e_tilt + kd_pitch (ω_sp - ω)             components about y: pitch
    α_z  = kp_yaw_rate (ω_sp - ω) + drag_yaw ω               yaw
    m    = I α + ω x I ω                                     moment about the centre of mass [N·m]
    F    = mass f · z                                        force along the rotors' axis [N]

a is the estimated acceleration, d the drag of still air, g_W gravity upwards, ω_sp the wanted yaw
rate about world z, and e_tilt the shortest rotation from z to f, as its axis times
2 sin(angle / 2): it grows up to half a turn, so the law works at any attitude. Gains are
normalised by mass and inertia (1/s or 1/s², not newtons), so that they transfer between vehicles.

Roll, pitch, yaw and moments are about the axes of T, see docs/controllers.md.
"""

from workbench.controllers import (
    ACCELERATION_POINT,
    ATTITUDE_POINT,
    GRAVITY,
    POSITION_POINT,
    SETPOINT_POINT,
    TURN_POINT,
    VELOCITY_POINT,
    Gains,
    KnownBody,
    LawResult,
    LawSetpoint,
    Loop,
    MeasuredMotion,
    Memory,
    Probes,
    Vector3,
    attitude_error,
    attitude_matrix,
    difference,
    gain,
    into_body,
    moment,
    position_error,
    probe3,
    probe_tilt,
    tilted,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import MAX_ATTITUDE_KP, rule

__all__ = ["LOOPS", "PARAMETERS", "POINTS", "rule", "update"]

_RATE_GAIN_RANGE = (0.0, 30.0)
_DAMPING_RANGE = (0.0, 1.0)
_STIFFNESS_RANGE = (0.0, MAX_ATTITUDE_KP)
_ANGLE_RATE_RANGE = (0.0, 150.0)

PARAMETERS = (
    gain("kp_position_xy", "1/s", (0.0, 5.0), 1.0, "position P gain, horizontal"),
    gain("kp_position_z", "1/s", (0.0, 5.0), 1.5, "position P gain, vertical"),
    gain("kp_velocity_x", "1/s", _RATE_GAIN_RANGE, 3.0, "velocity P gain, x"),
    gain("kp_velocity_y", "1/s", _RATE_GAIN_RANGE, 3.0, "velocity P gain, y"),
    gain("kp_velocity_z", "1/s", (0.5, 30.0), 4.0, "velocity P gain, z"),
    gain("kd_velocity_x", "1", _DAMPING_RANGE, 0.1, "velocity D gain, x"),
    gain("kd_velocity_y", "1", _DAMPING_RANGE, 0.1, "velocity D gain, y"),
    gain("kd_velocity_z", "1", _DAMPING_RANGE, 0.1, "velocity D gain, z"),
    gain("kp_roll", "1/s^2", _STIFFNESS_RANGE, 150.0, "attitude P gain, roll"),
    gain("kp_pitch", "1/s^2", _STIFFNESS_RANGE, 150.0, "attitude P gain, pitch"),
    gain("kd_roll", "1/s", _ANGLE_RATE_RANGE, 20.0, "attitude D gain, roll"),
    gain("kd_pitch", "1/s", _ANGLE_RATE_RANGE, 20.0, "attitude D gain, pitch"),
    gain("kp_yaw_rate", "1/s", _RATE_GAIN_RANGE, 4.0, "yaw rate P gain"),
)

POINTS = {
    "position_x_error": "m",
    "position_y_error": "m",
    "position_z_error": "m",
    "velocity_x_error": "m/s",
    "velocity_y_error": "m/s",
    "velocity_z_error": "m/s",
    "acceleration_x": "m/s^2",
    "acceleration_y": "m/s^2",
    "acceleration_z": "m/s^2",
    "roll_error": "1",
    "pitch_error": "1",
    "yaw_rate_error": "rad/s",
    "roll_acceleration": "rad/s^2",
    "pitch_acceleration": "rad/s^2",
    "yaw_acceleration": "rad/s^2",
    "roll_setpoint": "1",
    "pitch_setpoint": "1",
}
"""Errors, specific force in W without gravity, and angular acceleration in T. The errors of roll
and pitch are twice the sine of half the angle, about x and y of T; their setpoints are tangents of
the angles."""

# A loop's axis is that of the step which goes through it, see `Loop`, and not the axis it turns
# about: a step along y rolls the vehicle, about x of T, and a step along x pitches it.
LOOPS = tuple(
    Loop(name, f"{name}_error", output, hold=name.startswith("position"), axis=axis, gains=gains)
    for name, output, axis, gains in (
        ("velocity_x", "acceleration_x", "x", ("kp_velocity_x", "kd_velocity_x")),
        ("velocity_y", "acceleration_y", "y", ("kp_velocity_y", "kd_velocity_y")),
        ("velocity_z", "acceleration_z", "z", ("kp_velocity_z", "kd_velocity_z")),
        ("roll", "roll_acceleration", "y", ("kp_roll", "kd_roll")),
        ("pitch", "pitch_acceleration", "x", ("kp_pitch", "kd_pitch")),
        ("yaw_rate", "yaw_acceleration", "yaw", ("kp_yaw_rate",)),
        ("position_x", "position_x_error", "x", ("kp_position_xy",)),
        ("position_y", "position_y_error", "y", ("kp_position_xy",)),
        ("position_z", "position_z_error", "z", ("kp_position_z",)),
    )
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
    """Return the wrench in T, F [N] and m [N·m], and the memory, which is empty."""
    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    v_x, v_y, v_z, yaw_rate = velocity_setpoint(position_p(e, g), measured, setpoint, g)
    e = probe3(difference((v_x, v_y, v_z), measured.v_WBcm), VELOCITY_POINT, loops)
    f_x, f_y, f_z = probe3(
        velocity_pd(e, measured.a_WBcm, measured.drag, g), ACCELERATION_POINT, loops
    )
    R_WT = attitude_matrix(measured.q_WT)
    f_W = probe_tilt(tilted(f_x, f_y, f_z + GRAVITY, g), R_WT, SETPOINT_POINT, loops)

    f, w = into_body(R_WT, f_W), into_body(R_WT, measured.w_WB)
    w_sp = (R_WT[6] * yaw_rate, R_WT[7] * yaw_rate, R_WT[8] * yaw_rate)
    e = probe3(attitude_error(f, w, w_sp), ATTITUDE_POINT, loops)
    alpha = probe3(attitude_pd(e, w, w_sp, vehicle, g), TURN_POINT, loops)
    m_x, m_y, m_z = moment(alpha, w, vehicle.inertia)
    return (vehicle.mass * f[2], m_x, m_y, m_z), memory


def position_p(e: Vector3, g: Gains) -> Vector3:
    """Return the velocity for a position error e [m], in W [m/s]."""
    return g.kp_position_xy * e[0], g.kp_position_xy * e[1], g.kp_position_z * e[2]


def velocity_pd(e: Vector3, a: Vector3, drag: Vector3, g: Gains) -> Vector3:
    """Return the specific force without gravity, in W [m/s²], for a velocity error e [m/s].

    It compensates the drag of still air, so that the response to a gain does not depend on drag.
    """
    return (
        g.kp_velocity_x * e[0] - g.kd_velocity_x * a[0] + drag[0],
        g.kp_velocity_y * e[1] - g.kd_velocity_y * a[1] + drag[1],
        g.kp_velocity_z * e[2] - g.kd_velocity_z * a[2] + drag[2],
    )


def attitude_pd(e: Vector3, w: Vector3, w_sp: Vector3, vehicle: KnownBody, g: Gains) -> Vector3:
    """Return the angular acceleration in T [rad/s²] for errors e of roll, pitch and yaw rate."""
    return (
        g.kp_roll * e[0] + g.kd_roll * (w_sp[0] - w[0]),
        g.kp_pitch * e[1] + g.kd_pitch * (w_sp[1] - w[1]),
        g.kp_yaw_rate * e[2] + vehicle.yaw_drag * w[2],
    )
