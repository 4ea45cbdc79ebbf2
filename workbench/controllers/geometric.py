"""Geometric tracking on SE(3), with the acceleration of the path fed forward.

After T. Lee, M. Leok, N. H. McClamroch, Geometric tracking control of a quadrotor UAV on SE(3),
49th IEEE Conference on Decision and Control, 2010, equations 10 to 16. With z up, gains over mass
and inertia, and e_p = p_sp - p, e_v = v_sp - v:

    f    = k_position e_p + k_velocity e_v + a_path + d + g     specific force in W [m/s²]
    R_sp = [b2 x b3, b2, b3],  b3 = f / |f|,  b2 = b3 x h / |b3 x h|
    e_R  = ½ (R_spᵀ R - Rᵀ R_sp)^∨,   e_ω = ω - Rᵀ R_sp ω_sp
    m    = I (-k_attitude e_R - k_rate e_ω) + ω x I ω            moment [N·m]
    F    = mass f · z                                           force along the rotors' axis [N]

h is the commanded heading, a horizontal unit vector that turns at the reference's yaw rate. ω_sp is
that rate about world z plus the horizontal part of b3 x (da_path/dt) / |f|, the rate at which b3
turns along the path. The limits of speed and tilt apply as for every law; d is the drag of still
air. The derivative of ω_sp is left out, because it needs the path's snap.

e_R vanishes with the opposite attitude, too, where the paper's law would hang upside down. Within
5° of it, e_R keeps the length that it has there; exactly opposite, it turns about x.

Attitudes: it recovers from any, and falls 10 m at most if at rest. From exactly upside down, the
published law turns only by rounding errors, after 7 s and 230 m.
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
    Matrix3,
    MeasuredMotion,
    Memory,
    Probes,
    Vector3,
    attitude_matrix,
    difference,
    gain,
    into_body,
    loops_about,
    loops_along,
    moment,
    position_error,
    probe3,
    probe_tilt,
    states,
    tilted,
    velocity_setpoint,
)
from workbench.controllers.pd_rule import rule as pd_rule
from workbench.plant.vehicle import Vehicle

MIN_HEADING_SQUARED = 0.25
"""Squared length below which there is no commanded heading yet."""
INVERTED_TILT_SUM = 1e-12
"""Squared sum, 1 + cos of the tilt, below which a vehicle is on its back."""
MIN_ERROR_SQUARED = 1e-20
"""Squared length of e_R below which it has no direction."""
MIN_OPPOSITE_ERROR = 0.08715574274765817
"""Length of e_R near the opposite attitude, the sine of 5°."""

PARAMETERS = (
    gain("k_position_xy", "1/s^2", (0.0, 100.0), 4.0, "position P gain, horizontal", "Position"),
    gain("k_position_z", "1/s^2", (0.0, 100.0), 6.0, "position P gain, vertical", "Position"),
    gain("k_velocity_xy", "1/s", (0.1, 30.0), 3.0, "velocity P gain, horizontal", "Velocity"),
    gain("k_velocity_z", "1/s", (0.5, 30.0), 4.0, "velocity P gain, vertical", "Velocity"),
    gain("k_attitude_xy", "1/s^2", (0.0, 2500.0), 150.0, "attitude P gain, tilt", "Attitude"),
    gain("k_attitude_z", "1/s^2", (0.0, 500.0), 8.0, "attitude P gain, heading", "Attitude"),
    gain("k_rate_xy", "1/s", (0.0, 150.0), 20.0, "rate gain, tilt", "Attitude"),
    gain("k_rate_z", "1/s", (0.0, 60.0), 4.0, "rate gain, yaw", "Attitude"),
)

MEMORY = (*states("heading", "1", "xy"), *states("path", "m/s^2"))

POINTS = CASCADE_POINTS

_GEOMETRIC_POSITION_GAINS = (("k_position_xy",), ("k_position_xy",), ("k_position_z",))
_GEOMETRIC_VELOCITY_GAINS = (("k_velocity_xy",), ("k_velocity_xy",), ("k_velocity_z",))
_GEOMETRIC_TILT_GAINS = ("k_attitude_xy", "k_rate_xy")
_GEOMETRIC_ATTITUDE_GAINS = (
    _GEOMETRIC_TILT_GAINS,
    _GEOMETRIC_TILT_GAINS,
    ("k_attitude_z", "k_rate_z"),
)
LOOPS = (
    *loops_along("velocity", "acceleration", _GEOMETRIC_VELOCITY_GAINS),
    *loops_about(
        ("roll", "pitch", "heading"), "attitude", "angular_acceleration", _GEOMETRIC_ATTITUDE_GAINS
    ),
    *loops_along("position", "", _GEOMETRIC_POSITION_GAINS, hold=True),
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
    a, d, m = setpoint.a_WBcm, measured.drag, memory
    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    share_xy, share_z = g.k_position_xy / g.k_velocity_xy, g.k_position_z / g.k_velocity_z
    e = share_xy * e[0], share_xy * e[1], share_z * e[2]  # as a velocity, so that limits apply
    v_x, v_y, v_z, yaw_rate = velocity_setpoint(e, measured, setpoint, g)
    e = probe3(difference((v_x, v_y, v_z), measured.v_WBcm), VELOCITY_POINT, loops)
    f_x, f_y, f_z = probe3(
        (
            g.k_velocity_xy * e[0] + a[0] + d[0],
            g.k_velocity_xy * e[1] + a[1] + d[1],
            g.k_velocity_z * e[2] + a[2] + d[2],
        ),
        ACCELERATION_POINT,
        loops,
    )
    R = attitude_matrix(measured.q_WT)
    f_W = probe_tilt(tilted(f_x, f_y, f_z + GRAVITY, g), R, SETPOINT_POINT, loops)

    h_x, h_y = turned_heading(m.heading_x, m.heading_y, R, yaw_rate * dt)
    R_sp = commanded_rotation(f_W, h_x, h_y)
    w = into_body(R, measured.w_WB)
    j_x, j_y, j_z = (a[0] - m.path_x) / dt, (a[1] - m.path_y) / dt, (a[2] - m.path_z) / dt
    f_squared = f_W[0] * f_W[0] + f_W[1] * f_W[1] + f_W[2] * f_W[2]
    w_sp = into_body(
        R,
        (
            (f_W[1] * j_z - f_W[2] * j_y) / f_squared,
            (f_W[2] * j_x - f_W[0] * j_z) / f_squared,
            yaw_rate,
        ),
    )
    e_R = probe3(turning_error(R, R_sp), ATTITUDE_POINT, loops)
    alpha = probe3(
        (
            -g.k_attitude_xy * e_R[0] - g.k_rate_xy * (w[0] - w_sp[0]),
            -g.k_attitude_xy * e_R[1] - g.k_rate_xy * (w[1] - w_sp[1]),
            -g.k_attitude_z * e_R[2] - g.k_rate_z * (w[2] - w_sp[2]) + vehicle.yaw_drag * w[2],
        ),
        TURN_POINT,
        loops,
    )
    m_x, m_y, m_z = moment(alpha, w, vehicle.inertia)
    return (vehicle.mass * into_body(R, f_W)[2], m_x, m_y, m_z), (h_x, h_y, a[0], a[1], a[2])


def turned_heading(h_x: float, h_y: float, R: Matrix3, angle: float) -> tuple[float, float]:
    """Return the commanded heading, turned by a small angle [rad], of unit length.

    Initially it is x of T after turning z upright by the shortest way, so that a vehicle on its
    side or on its back has a heading, too. Exactly on its back no way is the shortest; x is level
    there, and is the heading.
    """
    if h_x * h_x + h_y * h_y < MIN_HEADING_SQUARED:
        h_x, h_y = R[0] + R[4], R[3] - R[1]
        if h_x * h_x + h_y * h_y < INVERTED_TILT_SUM:
            h_x, h_y = R[0], R[3]
    n_x, n_y = h_x - angle * h_y, h_y + angle * h_x
    length = (n_x * n_x + n_y * n_y + 1e-12) ** 0.5
    return n_x / length, n_y / length


def commanded_rotation(f: Vector3, h_x: float, h_y: float) -> Matrix3:
    """Return R_sp in row order (9): z along f, x as near to the heading as possible."""
    length = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]) ** 0.5
    x, y, z = f[0] / length, f[1] / length, f[2] / length
    s_x, s_y, s_z = -z * h_y, z * h_x, x * h_y - y * h_x  # b3 x h
    length = (s_x * s_x + s_y * s_y + s_z * s_z) ** 0.5
    s_x, s_y, s_z = s_x / length, s_y / length, s_z / length
    return (
        s_y * z - s_z * y,
        s_x,
        x,
        s_z * x - s_x * z,
        s_y,
        y,
        s_x * y - s_y * x,
        s_z,
        z,
    )


def attitude_error_so3(R: Matrix3, S: Matrix3) -> Vector3:
    """Return ½ (Sᵀ R - Rᵀ S)^∨ of two matrices in row order."""
    return (
        0.5 * (S[2] * R[1] + S[5] * R[4] + S[8] * R[7] - R[2] * S[1] - R[5] * S[4] - R[8] * S[7]),
        0.5 * (S[0] * R[2] + S[3] * R[5] + S[6] * R[8] - R[0] * S[2] - R[3] * S[5] - R[6] * S[8]),
        0.5 * (S[1] * R[0] + S[4] * R[3] + S[7] * R[6] - R[1] * S[0] - R[4] * S[3] - R[7] * S[6]),
    )


def turning_error(R: Matrix3, S: Matrix3) -> Vector3:
    """Return e_R, with the length of `MIN_OPPOSITE_ERROR` near the attitude opposite to S."""
    e_x, e_y, e_z = attitude_error_so3(R, S)
    trace = 0.0 * R[0]
    for i in range(9):
        trace = trace + S[i] * R[i]
    squared = e_x * e_x + e_y * e_y + e_z * e_z
    if trace > 0.0 or squared >= MIN_OPPOSITE_ERROR * MIN_OPPOSITE_ERROR:
        return e_x, e_y, e_z
    if squared < MIN_ERROR_SQUARED:
        return MIN_OPPOSITE_ERROR + 0.0 * e_x, e_y, e_z
    scale = MIN_OPPOSITE_ERROR / squared**0.5
    return scale * e_x, scale * e_y, scale * e_z


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return gains for a vehicle, with the bandwidths of the PD cascade."""
    pd = pd_rule(vehicle)
    level, climb, yaw = pd["kp_velocity_x"], pd["kp_velocity_z"], pd["kp_yaw_rate"]
    return {
        "k_position_xy": level * pd["kp_position_xy"],
        "k_position_z": climb * pd["kp_position_z"],
        "k_velocity_xy": level,
        "k_velocity_z": climb,
        "k_attitude_xy": min(pd["kp_roll"], pd["kp_pitch"]),
        "k_rate_xy": min(pd["kd_roll"], pd["kd_pitch"]),
        "k_attitude_z": yaw * yaw / 4.0,
        "k_rate_z": yaw,
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
        "max_tilt": pd["max_tilt"],
    }
