"""Oracle: the published equations in numpy, and flights that they are for.

T. Lee, M. Leok, N. H. McClamroch, Geometric tracking control of a quadrotor UAV on SE(3), 2010, as
RotorPy's SE3Control has them (S. Folk, J. Paulos, V. Kumar, 2023).
"""

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import Guidance, KnownBody, LawSetpoint, MeasuredMotion, Reference
from workbench.scenario.scenario import FigureEight, Scenario, ScenarioStart
from workbench.session.session import Session
from workbench.systems.reference import figure_eight

LAW = load_controller("geometric")
MASS, GRAVITY, PERIOD = 1.3, 9.81, 1 / 128
INERTIA = np.array([[0.02, 0.001, -0.002], [0.001, 0.03, 0.0015], [-0.002, 0.0015, 0.04]])
BODY = KnownBody(MASS, INERTIA[np.triu_indices(3)].tolist(), 0.0, 0.02, 0.0)
FREE = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def published(p, v, R, w, p_ref, v_ref, a_ref, w_ref, yaw, gains):
    """Return thrust and moment; axis by axis, gains are per mass and per inertia.

    Within 5° of the attitude opposite to the wanted one, e_R has the length that it has there: the
    one thing that the law does otherwise.
    """
    k_p, k_v, k_R, k_w = gains
    F_des = MASS * (k_p * (p_ref - p) + k_v * (v_ref - v) + a_ref + [0.0, 0.0, GRAVITY])
    b3 = F_des / np.linalg.norm(F_des)
    c1 = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    b2 = np.cross(b3, c1) / np.linalg.norm(np.cross(b3, c1))
    R_des = np.stack([np.cross(b2, b3), b2, b3]).T
    S_err = 0.5 * (R_des.T @ R - R.T @ R_des)
    e_R = np.array([-S_err[1, 2], S_err[0, 2], -S_err[0, 1]])
    angle = np.arccos(0.5 * (np.trace(R_des.T @ R) - 1.0))
    if angle > np.pi - np.radians(5.0):
        e_R *= np.sin(np.radians(5.0)) / np.linalg.norm(e_R)
    e_w = w - w_ref
    u1 = F_des @ R[:, 2]
    u2 = INERTIA @ (-k_R * e_R - k_w * e_w) + np.cross(w, INERTIA @ w)
    return np.append(u1, u2)


def test_its_wrench_is_the_published_one_at_1000_random_states():
    """Any attitude and turn; the reference's turn is that of the heading and of b3 along a path."""
    rng = np.random.default_rng(20)
    worst = 0.0
    for _ in range(1000):
        g = {row.name: row.default for row in LAW.parameters}
        for name in g:
            if name.startswith("k_"):
                g[name] *= rng.uniform(0.5, 1.5)
        g.update(max_speed=20.0, max_climb_rate=10.0, max_tilt=1.2, max_yaw_rate=6.0)
        spread = [[2.0], [0.25], [0.25], [6.0], [1.5], [9.0]]
        p, v, v_ref, w_W, a_ref, jerk = rng.uniform(-1.0, 1.0, (6, 3)) * spread
        p[2] += 10.0
        p_ref = p + rng.uniform(-0.1, 0.1, 3)
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        s, x, y, z = q
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        R = np.eye(3) + 2.0 * s * cross + 2.0 * cross @ cross
        heading, yaw_rate = rng.uniform(-np.pi, np.pi), rng.uniform(-0.4, 0.4)
        remembered = [np.cos(heading), np.sin(heading), *(a_ref - PERIOD * jerk)]
        reference = Reference(*v_ref, yaw_rate, *p_ref, 1.0)
        law = flight_law(LAW)
        wrench, after = LAW.update(
            MeasuredMotion(p, v, np.zeros(3), q, w_W, np.zeros(3), [MASS * GRAVITY, 0.0, 0.0, 0.0]),
            LawSetpoint(reference, FREE, a_ref),
            law.gains([g[row.name] for row in LAW.parameters]),
            BODY,
            law.memory(remembered),
            PERIOD,
            None,
        )
        k_p, k_v, k_R, k_w = (
            np.array([g[f"k_{name}_xy"], g[f"k_{name}_xy"], g[f"k_{name}_z"]])
            for name in ("position", "velocity", "attitude", "rate")
        )
        f = k_p * (p_ref - p) + k_v * (v_ref - v) + a_ref + [0.0, 0.0, GRAVITY]
        assert f[2] > 0.3 * GRAVITY and np.hypot(f[0], f[1]) < np.tan(1.2) * f[2], "within limits"
        w_ref = R.T @ np.append((np.cross(f, jerk) / (f @ f))[:2], yaw_rate)
        yaw = heading + np.arctan(yaw_rate * PERIOD)
        wanted = published(
            p, v, R, R.T @ w_W, p_ref, v_ref, a_ref, w_ref, yaw, (k_p, k_v, k_R, k_w)
        )
        worst = max(worst, np.abs(np.array(wrench) - wanted).max())
        assert after == pytest.approx((np.cos(yaw), np.sin(yaw), *a_ref), abs=1e-9)
    assert worst < 1e-9


def test_its_first_heading_is_the_vehicles():
    law = flight_law(LAW)
    g = law.gains([row.default for row in LAW.parameters])
    for yaw in np.linspace(-3.0, 3.0, 7):
        quaternion = RollPitchYaw(0.3, -0.0, yaw).ToQuaternion().wxyz()
        zero = np.zeros(3)
        _, after = LAW.update(
            MeasuredMotion(
                zero, zero, zero, quaternion, zero, zero, [MASS * GRAVITY, 0.0, 0.0, 0.0]
            ),
            LawSetpoint(Reference(*[0.0] * 8), FREE, zero),
            g,
            BODY,
            law.memory(LAW.initial_memory),
            PERIOD,
            None,
        )
        assert after[:2] == pytest.approx((np.cos(yaw), np.sin(yaw)), abs=1e-12)


def farthest(controller: str, duration: float) -> tuple[float, float]:
    """Return how far a figure of eight's flight is from where it should be [m], and top speed."""
    eight = FigureEight(center=[0.0, 0.0, 3.0], length=8.0, width=4.0, period=8.885, laps=1)
    session = Session(
        Scenario(
            controller=controller,
            start=ScenarioStart(position=[0.0, 0.0, 3.0]),
            figure_eight=eight,
            duration=duration,
        )
    )
    session.run()
    flown = session.recording()
    path = figure_eight(eight.center, eight.length, eight.width, eight.period, eight.laps)
    wanted = path.vector_values(np.minimum(flown.time, path.end_time()))[4:7].T
    off = np.linalg.norm(flown.p_WB - wanted, axis=1)
    return off.max(), np.linalg.norm(flown.v_WB, axis=1).max()


@pytest.mark.slow
def test_a_figure_of_eight_at_4_m_s_is_flown_within_5_cm():
    """The PD cascade, which knows no acceleration of the path, flies it a tenth too large."""
    off, speed = farthest("geometric", 10.0)
    assert off < 0.05
    assert 3.9 < speed < 4.1
    assert farthest("pd", 5.0)[0] > 0.4
