"""LQI: state feedback with integrals, whose gains follow from weights by a Riccati equation.

Near hover the vehicle is three independent chains, each with the rotors' lag τ at its end:

    level   dξ/dt = e_v,  de_v/dt = -g θ,  dθ/dt = ω,  dω/dt = α,  τ dα/dt = u - α     (x and y)
    climb   dξ/dt = e_v,  de_v/dt = -a,    τ da/dt = u - a
    yaw     dξ/dt = e_ω,  de_ω/dt = -α,    τ dα/dt = u - α

Each is discretised with a zero-order hold, and `control.dlqr` returns the feedback u = -K x that
minimises the sum of x' Q x + u², with the weights q_* on the diagonal of Q (Franklin, Powell,
Workman, Digital Control of Dynamic Systems, 1998, section 9.3; integral states section 8.5). In
flight the same feedback is used at any attitude, as a cascade:

    f = g (K_v e_v + K_ξ ξ) / K_θ + a_path + d + g       specific force in W [m/s²], within tilt
    α = K_θ e_tilt + K_ω (ω_sp - ω) - K_α α_rotors       angular acceleration in T [rad/s²]
    m = I α + ω x I ω,   F = mass f · z

α_rotors is the commanded wrench after the rotor lag, d the drag of still air, a_path the
acceleration of a path. Integrals stop in saturation, as in `pid`.
"""

from collections.abc import Sequence
from functools import lru_cache

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
    KnownVehicle,
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
    integrated,
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

LQI_SATURATION_TOLERANCE = 0.02
"""Tolerance of saturation: missing force over weight."""
MAX_YAW_INTEGRAL_SQUARED = 1.0
"""Square of the largest integral of a yaw rate [rad²]."""
_WEIGHT_RANGE = (1e-6, 1e8)

PARAMETERS = (
    gain("kp_position_xy", "1/s", (0.0, 5.0), 0.8, "position P gain, horizontal", "Position"),
    gain("kp_position_z", "1/s", (0.0, 5.0), 1.0, "position P gain, vertical", "Position"),
    gain(
        "q_level_integral", "1/(s^2*m^2)", _WEIGHT_RANGE, 100.0, "velocity integral weight", "Level"
    ),
    gain("q_level_velocity", "1/(s^2*m^2)", _WEIGHT_RANGE, 100.0, "velocity weight", "Level"),
    gain("q_tilt", "1/s^4", _WEIGHT_RANGE, 1000.0, "tilt weight", "Level"),
    gain("q_tilt_rate", "1/s^2", _WEIGHT_RANGE, 10.0, "tilt rate weight", "Level"),
    gain("q_climb_integral", "1/s^4", _WEIGHT_RANGE, 10.0, "velocity integral weight", "Climb"),
    gain("q_climb_velocity", "1/s^2", _WEIGHT_RANGE, 10.0, "velocity weight", "Climb"),
    gain("q_yaw_integral", "1/s^4", _WEIGHT_RANGE, 10.0, "yaw rate integral weight", "Yaw"),
    gain("q_yaw_rate", "1/s^2", _WEIGHT_RANGE, 10.0, "yaw rate weight", "Yaw"),
)

DESIGNED = (
    *(f"level_{state}" for state in ("integral", "velocity", "tilt", "rate", "rotors")),
    *(f"climb_{state}" for state in ("integral", "velocity", "rotors")),
    *(f"yaw_{state}" for state in ("integral", "rate", "rotors")),
)

MEMORY = (
    *states("integral", "m"),
    State("yaw_integral_z", "rad"),
    *states("rotors", "rad/s^2"),
    State("lift_z", "m/s^2"),
    State("asked_z", "1"),
)

POINTS = CASCADE_POINTS

_LQI_POSITION_GAINS = (("kp_position_xy",), ("kp_position_xy",), ("kp_position_z",))
_LQI_LEVEL_WEIGHTS = ("q_level_integral", "q_level_velocity")
_LQI_CLIMB_WEIGHTS = ("q_climb_integral", "q_climb_velocity")
_LQI_TILT_WEIGHTS, _LQI_YAW_WEIGHTS = ("q_tilt", "q_tilt_rate"), ("q_yaw_integral", "q_yaw_rate")
LOOPS = (
    *loops_along(
        "velocity", "acceleration", (_LQI_LEVEL_WEIGHTS, _LQI_LEVEL_WEIGHTS, _LQI_CLIMB_WEIGHTS)
    ),
    *loops_about(
        ("roll", "pitch", "yaw_rate"),
        "attitude",
        "angular_acceleration",
        (_LQI_TILT_WEIGHTS, _LQI_TILT_WEIGHTS, _LQI_YAW_WEIGHTS),
    ),
    *loops_along("position", "", _LQI_POSITION_GAINS, hold=True),
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
    d, m = measured.drag, memory
    a = setpoint.a_WBcm
    weight = vehicle.mass * GRAVITY
    xx, yy, zz = vehicle.inertia[0], vehicle.inertia[3], vehicle.inertia[5]

    e = probe3(position_error(measured, setpoint), POSITION_POINT, loops)
    e = g.kp_position_xy * e[0], g.kp_position_xy * e[1], g.kp_position_z * e[2]
    v_x, v_y, v_z, yaw_rate = velocity_setpoint(e, measured, setpoint, g)
    e = probe3(difference((v_x, v_y, v_z), measured.v_WBcm), VELOCITY_POINT, loops)
    level = GRAVITY / g.level_tilt
    lift = m.lift_z + rotor_lag_gain(dt, vehicle) * (
        measured.wrench[0] / vehicle.mass - GRAVITY - m.lift_z
    )
    f_x, f_y, f_z = probe3(
        (
            level * (g.level_velocity * e[0] + g.level_integral * m.integral_x) + a[0] + d[0],
            level * (g.level_velocity * e[1] + g.level_integral * m.integral_y) + a[1] + d[1],
            g.climb_velocity * e[2]
            + g.climb_integral * m.integral_z
            - g.climb_rotors * lift
            + (1.0 + g.climb_rotors) * (a[2] + d[2]),
        ),
        ACCELERATION_POINT,
        loops,
    )
    f_W = tilted(f_x, f_y, f_z + GRAVITY, g)
    integral_x = integrated(m.integral_x, e[0], f_x - f_W[0], 0.0, dt)
    integral_y = integrated(m.integral_y, e[1], f_y - f_W[1], 0.0, dt)
    missing = m.asked_z - measured.wrench[0] / weight
    integral_z = integrated(m.integral_z, e[2], missing, LQI_SATURATION_TOLERANCE, dt)

    R_WT = attitude_matrix(measured.q_WT)
    f_W = probe_tilt(f_W, R_WT, SETPOINT_POINT, loops)
    f, w = into_body(R_WT, f_W), into_body(R_WT, measured.w_WB)
    w_sp = (R_WT[6] * yaw_rate, R_WT[7] * yaw_rate, R_WT[8] * yaw_rate)
    e = probe3(attitude_error(f, w, w_sp), ATTITUDE_POINT, loops)
    r_x = m.rotors_x + rotor_lag_gain(dt, vehicle) * (measured.wrench[1] / xx - m.rotors_x)
    r_y = m.rotors_y + rotor_lag_gain(dt, vehicle) * (measured.wrench[2] / yy - m.rotors_y)
    r_z = m.rotors_z + rotor_lag_gain(dt, vehicle) * (measured.wrench[3] / zz - m.rotors_z)
    alpha = probe3(
        (
            g.level_tilt * e[0] + g.level_rate * (w_sp[0] - w[0]) - g.level_rotors * r_x,
            g.level_tilt * e[1] + g.level_rate * (w_sp[1] - w[1]) - g.level_rotors * r_y,
            g.yaw_rate * e[2]
            + g.yaw_integral * m.yaw_integral_z
            - g.yaw_rotors * r_z
            + (1.0 + g.yaw_rotors) * vehicle.yaw_drag * w[2],
        ),
        TURN_POINT,
        loops,
    )
    past = (
        m.yaw_integral_z if m.yaw_integral_z * m.yaw_integral_z > MAX_YAW_INTEGRAL_SQUARED else 0.0
    )
    yaw_integral = integrated(m.yaw_integral_z, e[2], past, 0.0, dt)

    force = vehicle.mass * f[2]
    m_x, m_y, m_z = moment(alpha, w, vehicle.inertia)
    integrals = integral_x, integral_y, integral_z, yaw_integral
    return (force, m_x, m_y, m_z), (*integrals, r_x, r_y, r_z, lift, force / weight)


def rotor_lag_gain(dt: float, vehicle: KnownBody) -> float:
    """Return the gain of the discrete first-order rotor lag."""
    return dt / (vehicle.rotor_lag + dt)


def design(vehicle: KnownVehicle, g: Gains, dt: float) -> Sequence[float]:
    """Return the feedback gains of the three chains, see above."""
    lag = vehicle.rotor_lag
    tilt = (g.q_level_integral, g.q_level_velocity, g.q_tilt, g.q_tilt_rate, 0.0)
    return [
        *feedback((1.0, -GRAVITY, 1.0, 1.0), lag, tilt, dt),
        *feedback((1.0, -1.0), lag, (g.q_climb_integral, g.q_climb_velocity, 0.0), dt),
        *feedback((1.0, -1.0), lag, (g.q_yaw_integral, g.q_yaw_rate, 0.0), dt),
    ]


@lru_cache(maxsize=4096)  # a sweep of one chain's weights does not change the others
def feedback(
    slopes: tuple[float, ...], lag: float, weights: tuple[float, ...], dt: float
) -> list[float]:
    """Return the gains of a chain whose last state follows its input with a lag [s].

    The derivative of each other state is the next state times a slope. The first two states are
    errors, command minus measurement, so their gains change sign; the gains are then those of the
    cascade above.
    """
    import numpy as np
    from scipy import linalg  # python-control computes the same, and takes a second to load

    n = len(slopes) + 1
    chain = np.zeros((n + 1, n + 1))  # with the input, which is held, as the last state
    chain[:-2, 1:-1] = np.diag(slopes)
    chain[-2, -2:] = -1.0 / lag, 1.0 / lag
    held = linalg.expm(dt * chain)
    A, B = np.ascontiguousarray(held[:n, :n]), np.ascontiguousarray(held[:n, n:])
    S = linalg.solve_discrete_are(A, B, np.diag(weights), np.eye(1))
    K = linalg.solve(B.T @ S @ B + np.eye(1), B.T @ S @ A)
    signs = [-1.0, -1.0, *[1.0] * (n - 2)]
    return [float(sign * k) for sign, k in zip(signs, K[0], strict=True)]


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return weights for a vehicle.

    With a weight on the integral alone, the closed-loop poles would be on a circle about 0 (a
    Butterworth pattern) of radius p, for q = p^(2 n) over the squared gain of a chain of n states.
    The weights of the states in between add damping. In climb the weight of the integral is
    smaller, so that a take-off overshoots its speed by less than a tenth.
    """
    pd = pd_rule(vehicle)
    level, climb, yaw = pd["kp_velocity_x"], pd["kp_velocity_z"], pd["kp_yaw_rate"]
    tilt = min(pd["kp_roll"], pd["kp_pitch"])
    return {
        "kp_position_xy": pd["kp_position_xy"],
        "kp_position_z": pd["kp_position_z"],
        "q_level_integral": (tilt * 0.2 * level**2 / GRAVITY) ** 2,
        "q_level_velocity": (tilt * level / GRAVITY) ** 2,
        "q_tilt": tilt**2,
        "q_tilt_rate": 0.5 * tilt,
        "q_climb_integral": (0.12 * climb**2) ** 2,
        "q_climb_velocity": climb**2,
        "q_yaw_integral": (0.2 * yaw**2) ** 2,
        "q_yaw_rate": yaw**2,
        "spin_up_feedforward": pd["spin_up_feedforward"],
        "max_climb_rate": pd["max_climb_rate"],
        "max_tilt": pd["max_tilt"],
    }
