"""P on velocity, PD on tilt."""

from workbench.controllers import (
    GRAVITY,
    attitude_error,
    attitude_matrix,
    gain,
    into_body,
    moment,
    tilted,
    velocity_setpoint,
)

PARAMETERS = [
    gain("p_velocity", "1/s", (0.1, 20.0), 3.0, "velocity P gain"),
    gain("p_tilt", "1/s^2", (0.0, 500.0), 150.0, "tilt P gain"),
    gain("d_tilt", "1/s", (0.0, 100.0), 20.0, "tilt D gain"),
    gain("p_yaw", "1/s", (0.0, 30.0), 4.0, "yaw rate P gain"),
]


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    """Return the wrench; this law remembers nothing."""
    v_x, v_y, v_z, yaw_rate = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)
    v, p = measured.v_WBcm, g.p_velocity
    f_W = tilted(p * (v_x - v[0]), p * (v_y - v[1]), p * (v_z - v[2]) + GRAVITY, g)
    R_WT = attitude_matrix(measured.q_WT)
    f, w = into_body(R_WT, f_W), into_body(R_WT, measured.w_WB)
    e = attitude_error(f, w, (R_WT[6] * yaw_rate, R_WT[7] * yaw_rate, R_WT[8] * yaw_rate))
    alpha = g.p_tilt * e[0] - g.d_tilt * w[0], g.p_tilt * e[1] - g.d_tilt * w[1], g.p_yaw * e[2]
    m_x, m_y, m_z = moment(alpha, w, vehicle.inertia)
    return (vehicle.mass * f[2], m_x, m_y, m_z), memory
