"""Oracle: pid, indi and lqi by the equations that they name, in numpy, update after update.

pid: a cascade of P and PID loops with conditional integration (Åström and Hägglund, Advanced PID
Control, 2006, section 3.5). indi: Smeur, Chu, de Croon, Adaptive incremental nonlinear dynamic
inversion, 2016, and Cascaded INDI, 2018. lqi: state feedback of chains with integrals (Franklin,
Powell, Workman, Digital Control of Dynamic Systems, 1998, sections 8.5 and 9.3), whose gains are
scipy's. Vectors here, numbers there; first-order lags are backward differences,
(τ + dt) x = τ x_before + dt u.

All that a law measures is random, so that integrals stop, the tilt is limited, and rotors do
something else than the law asked for.
"""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are
from scipy.spatial.transform import Rotation

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import (
    Guidance,
    KnownBody,
    KnownVehicle,
    LawSetpoint,
    MeasuredMotion,
    Reference,
)

MASS, GRAVITY, DT = 1.3, 9.81, 1 / 128
INERTIA = np.array([[0.02, 0.001, -0.002], [0.001, 0.03, 0.0015], [-0.002, 0.0015, 0.04]])
YAW_DRAG, ROTOR_LAG, SPIN_UP_TIME = 0.05, 0.03, 0.3
NUMBERS = (MASS, tuple(INERTIA[np.triu_indices(3)]), YAW_DRAG, ROTOR_LAG, SPIN_UP_TIME, 0.0)
FREE = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
MAX_TILT = 0.5
LIMITS = {"max_speed": 40.0, "max_climb_rate": 40.0, "max_tilt": MAX_TILT, "max_yaw_rate": 9.0}
Z = np.array([0.0, 0.0, 1.0])
FLIGHTS, UPDATES = 12, 12


def lagged(before, now, time_constant):
    return (time_constant * before + DT * now) / (time_constant + DT)


def within_tilt(f):
    """Return a specific force [m/s²] with 0.3 g upwards at least, tilted by MAX_TILT at most."""
    up = max(f[2], 0.3 * GRAVITY)
    level = np.linalg.norm(f[:2])
    most = np.tan(MAX_TILT) * up
    return np.append(f[:2] * min(1.0, most / level), up)


def grown(integral, slope, missing):
    """Return an integral after DT; where saturation is missing some of its sign, it grows no more.

    Args:
        missing: what is not reached because of saturation, 0 without (3).
    """
    stopped = np.sign(slope) * np.sign(missing) > 0.0
    return np.where(stopped, integral, integral + DT * slope)


def beyond(value, tolerance):
    return np.where(np.abs(value) > tolerance, value, 0.0)


def tilt_error(f):
    """Return the shortest turn from z to f, as its axis times 2 sin(angle / 2)."""
    axis = np.cross(Z, f)
    angle = np.arctan2(np.linalg.norm(axis), f[2])
    return 2.0 * np.sin(angle / 2.0) * axis / np.linalg.norm(axis)


def moment(alpha, w):
    return INERTIA @ alpha + np.cross(w, INERTIA @ w)


def level_and_climb(g, name):
    return np.array([g[f"{name}_xy"], g[f"{name}_xy"], g[f"{name}_z"]])


def outer(s, g):
    """Return the error of the velocity, and the wanted turn in T, of all three laws."""
    v_sp = level_and_climb(g, "kp_position") * (s.p_sp - s.p) + s.v_ref
    return v_sp - s.v, s.R.T @ (s.yaw_rate * Z)


def pid(s, g, m):
    e_v, turn = outer(s, g)
    gains = [level_and_climb(g, f"{term}_velocity") for term in ("kp", "ki", "kd")]
    f = gains[0] * e_v + m["i_velocity"] - gains[2] * s.a + s.drag + GRAVITY * Z
    f_W = within_tilt(f)
    light = beyond(m["asked"][2] - s.wrench[0] / (MASS * GRAVITY), 0.02)
    i_velocity = grown(m["i_velocity"], gains[1] * e_v, [*(f - f_W)[:2], light])

    w = s.R.T @ s.w_W
    w_sp = g["kp_tilt"] * tilt_error(s.R.T @ f_W) + turn
    e_w = w_sp - w
    rate = lagged(m["rate_filtered"], w[:2], 0.01)
    slope = np.append((rate - m["rate_filtered"]) / DT, 0.0)
    kp = np.array([g["kp_rate"], g["kp_rate"], g["kp_yaw_rate"]])
    ki = np.array([g["ki_rate"], g["ki_rate"], g["ki_yaw_rate"]])
    alpha = kp * e_w + m["i_rate"] - g["kd_rate"] * slope + YAW_DRAG * w[2] * Z
    weak = beyond(m["asked"][:2] - s.wrench[1:3] / np.diag(INERTIA)[:2], 0.02)
    past = beyond(m["i_rate"][2], 10.0)  # the yaw's integral is at most 10 rad/s²
    i_rate = grown(m["i_rate"], ki * e_w, [*weak, past])

    force, turning = MASS * (s.R.T @ f_W)[2], moment(alpha, w)
    asked = [*turning[:2] / np.diag(INERTIA)[:2], force / (MASS * GRAVITY)]
    after = {"i_velocity": i_velocity, "i_rate": i_rate, "rate_filtered": rate, "asked": asked}
    return np.append(force, turning), after


def indi(s, g, m):
    e_v, turn = outer(s, g)
    w = s.R.T @ s.w_W
    lift = lagged(m["lift"], s.wrench[:1] / MASS, ROTOR_LAG)
    given = lagged(m["moment"], s.wrench[1:], ROTOR_LAG)
    spin_up = SPIN_UP_TIME * (given - m["moment"])[2] / DT
    force_f = lagged(m["force_filtered"], lift * s.R[:, 2], 0.02)
    moment_f = lagged(m["moment_filtered"], given + spin_up * Z, 0.02)
    rate_f = lagged(m["rate_filtered"], w, 0.02)

    f_W = within_tilt(force_f + level_and_climb(g, "kp_velocity") * e_v + s.a_path - s.a)
    f = s.R.T @ f_W
    nu = g["kp_tilt"] * tilt_error(f) + g["kd_tilt"] * (turn - w)
    nu[2] = g["kp_yaw_rate"] * (turn - w)[2]
    turning = moment_f + INERTIA @ (nu - (rate_f - m["rate_filtered"]) / DT)
    after = {"lift": lift, "moment": given, "force_filtered": force_f}
    after |= {"moment_filtered": moment_f, "rate_filtered": rate_f}
    return np.append(MASS * f[2], turning), after


@lru_cache
def feedback(slopes, weights):
    """Return K of u = -K x for a chain x_k' = slope_k x_k+1, whose end follows u with ROTOR_LAG."""
    n = len(slopes) + 1
    both = np.zeros((n + 1, n + 1))
    both[range(n - 1), range(1, n)] = slopes
    both[n - 1, n - 1 :] = -1.0 / ROTOR_LAG, 1.0 / ROTOR_LAG
    sampled = expm(DT * both)
    A, B = sampled[:n, :n], sampled[:n, n:]
    P = solve_discrete_are(A, B, np.diag(weights), np.eye(1))
    return np.linalg.solve(np.eye(1) + B.T @ P @ B, B.T @ P @ A)[0]


def lqi(s, g, m):
    names = ("q_level_integral", "q_level_velocity", "q_tilt", "q_tilt_rate")
    level = feedback((1.0, -GRAVITY, 1.0, 1.0), (*(g[name] for name in names), 0.0))
    climb = feedback((1.0, -1.0), (g["q_climb_integral"], g["q_climb_velocity"], 0.0))
    yaw = feedback((1.0, -1.0), (g["q_yaw_integral"], g["q_yaw_rate"], 0.0))
    e_v, turn = outer(s, g)
    drag = s.a_path + s.drag
    integral = m["integral"]
    # the tilt at which the level chain asks for nothing, which makes g times itself
    tilt = -(level[1] * e_v + level[0] * integral) / level[2]
    f = GRAVITY * tilt + drag + GRAVITY * Z
    # climb: u - a = -K (x - x_steady), where in the steady state a is that of path and drag
    lift = lagged(m["lift"], s.wrench[:1] / MASS - GRAVITY, ROTOR_LAG)
    steady = drag[2] - climb[2] * (lift[0] - drag[2])
    f[2] = GRAVITY + steady - climb[1] * e_v[2] - climb[0] * integral[2]
    f_W = within_tilt(f)
    light = beyond(m["asked"][0] - s.wrench[0] / (MASS * GRAVITY), 0.02)

    w = s.R.T @ s.w_W
    rotors = lagged(m["rotors"], s.wrench[1:] / np.diag(INERTIA), ROTOR_LAG)
    alpha = level[2] * tilt_error(s.R.T @ f_W) + level[3] * (turn - w) - level[4] * rotors
    e_yaw, held = (turn - w)[2], YAW_DRAG * w[2]
    alpha[2] = held - yaw[2] * (rotors[2] - held) - yaw[1] * e_yaw - yaw[0] * m["yaw_integral"][0]
    force = MASS * (s.R.T @ f_W)[2]
    after = {
        "integral": grown(integral, e_v, [*(f - f_W)[:2], light]),
        "yaw_integral": grown(m["yaw_integral"], e_yaw, beyond(m["yaw_integral"], 1.0)),
        "rotors": rotors,
        "lift": lift,
        "asked": [force / (MASS * GRAVITY)],
    }
    return np.append(force, moment(alpha, w)), after


def random_situation(rng) -> SimpleNamespace:
    """Return what a law gets, in W, tilted by up to a right angle, near what the rotors can do."""
    axis = rng.normal(size=3) * [1.0, 1.0, 0.3]
    turn = Rotation.from_rotvec(rng.uniform(0.0, 1.5) * axis / np.linalg.norm(axis))
    turn = turn * Rotation.from_rotvec(rng.uniform(-3.0, 3.0) * Z)
    draw = rng.uniform
    return SimpleNamespace(
        R=turn.as_matrix(),
        q=turn.as_quat()[[3, 0, 1, 2]],
        p=draw(-1.0, 1.0, 3),
        p_sp=draw(-1.0, 1.0, 3),
        v=draw(-1.0, 1.0, 3),
        v_ref=draw(-1.0, 1.0, 3),
        yaw_rate=draw(-1.0, 1.0),
        w_W=draw(-2.0, 2.0, 3),
        a=draw(-2.0, 2.0, 3),
        a_path=draw(-2.0, 2.0, 3),
        drag=draw(-1.0, 1.0, 3),
        wrench=np.append(MASS * GRAVITY * draw(0.5, 1.5), INERTIA @ draw(-20.0, 20.0, 3)),
    )


def grouped(law, numbers):
    """Return a law's memory as vectors, by the names of its states without the axis."""
    found = {}
    for state, number in zip(law.memory, numbers, strict=True):
        found.setdefault(state.name.rpartition("_")[0], []).append(number)
    return {name: np.array(values) for name, values in found.items()}


@pytest.mark.parametrize("equations", [pid, indi, lqi], ids=lambda each: each.__name__)
def test_wrench_and_memory_are_those_of_the_equations(equations):
    """Twelve flights of twelve updates; memories begin anywhere, also beyond their limits."""
    law = load_controller(equations.__name__)
    flown, rng = flight_law(law), np.random.default_rng(7)
    known = KnownVehicle(*NUMBERS, rotors=())
    for _ in range(FLIGHTS):
        g = {row.name: row.default for row in law.parameters}
        g |= {
            name: value * rng.uniform(0.5, 1.5) if value else rng.uniform(0.0, 0.1)
            for name, value in g.items()
            if name.startswith(("k", "q_"))
        }
        g |= LIMITS
        gains = flown.gains(law.gains(g, known, DT))
        memory = rng.normal(0.0, 3.0, len(law.memory))
        if law.name == "pid":
            memory[5] = rng.uniform(-20.0, 20.0)
        expected = grouped(law, memory)
        for _ in range(UPDATES):
            s = random_situation(rng)
            wrench, memory = law.update(
                MeasuredMotion(s.p, s.v, s.a, s.q, s.w_W, s.drag, s.wrench),
                LawSetpoint(Reference(*s.v_ref, s.yaw_rate, *s.p_sp, 1.0), FREE, s.a_path),
                gains,
                KnownBody(*NUMBERS),
                flown.memory(list(memory)),
                DT,
                None,
            )
            wanted, expected = equations(s, g, expected)
            np.testing.assert_allclose(wrench, wanted, rtol=1e-7, atol=1e-7)
            for name, values in grouped(law, memory).items():
                np.testing.assert_allclose(values, expected[name], 1e-7, 1e-7, err_msg=name)
