"""A reader's own law: P and PD cascades with an integral in climb, in the fewest lines."""

from workbench.controllers import (
    GRAVITY,
    Loop,
    State,
    attitude_error,
    attitude_matrix,
    gain,
    integrated,
    into_body,
    moment,
    position_error,
    probe,
    tilted,
    velocity_setpoint,
)

PARAMETERS = [
    gain("k_place", "1/s", (0.0, 5.0), 0.7, "pull to a held place"),
    gain("k_speed", "1/s", (0.0, 20.0), 2.5, "acceleration per error of velocity"),
    gain("k_climb_integral", "1/s^2", (0.0, 10.0), 0.6, "growth of the integral in climb"),
    gain("k_tilt", "1/s^2", (0.0, 900.0), 120.0, "angular acceleration per error of tilt"),
    gain("k_turn", "1/s", (0.0, 90.0), 18.0, "angular acceleration per rate"),
    gain("k_yaw", "1/s", (0.0, 20.0), 3.0, "angular acceleration per error of yaw rate"),
]
MEMORY = [State("climb", "m/s^2")]
POINTS = {"speed_x": "m/s", "pitch": "rad/s^2"}
LOOPS = [
    Loop("speed", "speed_x", axis="x", gains=("k_speed",)),
    Loop("pitch", "pitch", axis="x", gains=("k_tilt", "k_turn")),
]


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    e_x, e_y, e_z = position_error(measured, setpoint)
    correction = g.k_place * e_x, g.k_place * e_y, g.k_place * e_z
    v_x, v_y, v_z, turn = velocity_setpoint(correction, measured, setpoint, g)
    v = measured.v_WBcm
    e_x, e_y, e_z = probe(v_x - v[0], 0, loops), v_y - v[1], v_z - v[2]
    up = g.k_speed * e_z + memory.climb
    f_W = tilted(g.k_speed * e_x, g.k_speed * e_y, up + GRAVITY, g)
    R = attitude_matrix(measured.q_WT)
    f, w = into_body(R, f_W), into_body(R, measured.w_WB)
    a_x, a_y, a_z = attitude_error(f, w, (0.0, 0.0, turn))
    roll = g.k_tilt * a_x - g.k_turn * w[0]
    pitch = probe(g.k_tilt * a_y - g.k_turn * w[1], 1, loops)
    m_x, m_y, m_z = moment((roll, pitch, g.k_yaw * a_z), w, vehicle.inertia)
    missing = vehicle.mass * (up + GRAVITY) / measured.wrench[0] - 1.0
    climb = integrated(memory.climb, g.k_climb_integral * e_z, missing, 0.5, dt)
    return (vehicle.mass * f[2], m_x, m_y, m_z), (climb,)
