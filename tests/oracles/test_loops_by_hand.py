"""Margins of pd's yaw and pitch loop, and steps of pid and lqi, against loops derived by hand.

All numbers are typed here, from the equations below and the shipped drone's constants; sampling
is `held`, margins are python-control's.

Yaw at hover. Four rotors turn at ω0, each with the torques -d c k ω² (drag) and -J d dω/dt
(spin-up) about z. Speeds ω0 - d δ make the moment 4 (2 c k ω0 δ + J dδ/dt), whose zero is
s = -z0 with z0 = 2 c k ω0 / J. Scaled so that a steady δ is the angular acceleration that it
makes, with λ the rate of the rotors' lag and κ the part of the yaw rate that rotor drag takes a
second, 4 D ω0 r² / Izz::

    dδ/dt = λ (a - δ)       dr/dt = δ + dδ/dt / z0 - κ r       a = -(kp - κ) r

The law asks for a: its gain, less what it gives back of the drag.

Pitch at hover. With angle θ and rate q, the tilt that the velocity loop wants, θ*, and the speed
v, which thrust moves at g θ and rotor drag brakes by β = 4 D ω0 / m::

    dq/dt = δ               a = kp (θ* - θ) - kd q          g θ* = -kp_v v - kd_v e + β v

where e is the estimate of dv/dt: what v changes by in a period when it is filtered with the time
constant τ, so f_next = f + (1 - exp(-T / τ)) (v - f) and e = (f_next - f) / T.

With a feed-forward of the spin-up torque the law asks the drag torque for what is left of a, when
the torque of spinning up by that is taken off, dδ/dt being the change since the last update::

    a = u + (u - u_before) / (T z0)          u is held in place of a

A command acts from its update on, and holds for a control period.
"""

import math

import control
import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from workbench.control.controller_file import load_controller
from workbench.control.law_constants import known_body, law_constants
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.session import Session

T = 1 / 128
MASS, I_ZZ, GRAVITY = 1.9, 0.036375441834, 9.81
K, C_M, J, D = 8.54858e-6, 0.016, 6.5e-5, 8.06428e-5
ARM = 0.25
SPEED = math.sqrt(MASS * GRAVITY / 4 / K)
ESTIMATE = 0.02
"""Time constant of the estimate of acceleration, τ [s]."""
LAG = (1 / 0.0125 + 1 / 0.025) / 2
"""Of small steps: the mean of the rates up and down [1/s]."""
KAPPA = 4 * D * SPEED * ARM**2 / I_ZZ
BETA = 4 * D * SPEED / MASS


def held(A, B, lead=0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return F and G of x_next = F x + G a, of dx/dt = A x + B u, where u is held for T.

    x(T) = e^{A T} x + H(T) u,  H(t) = ∫ e^{A s} B ds.
    The last state is u_before; u is a share of what the law asks for, a, and the rest u_before.
    """
    n = len(A)
    extended = np.zeros((n + 1, n + 1))
    extended[:n, :n], extended[:n, n] = A, B

    def over(time):
        both = expm(extended * time)
        return both[:n, :n], both[:n, n]

    turned, now = over(T)
    F = np.zeros((n + 1, n + 1))
    share = T / (T + lead)
    F[:n, :n], F[:n, n], F[n, n] = turned, (1 - share) * now, 1 - share
    return F, share * np.append(now, 1.0)


def open_loop(F, G, asked) -> control.StateSpace:
    """Return L(z), where the law asks for -asked x."""
    return control.ss(F, G[:, None], asked[None, :], 0.0, T)


def yaw_loop(kp: float, rotor_inertia: float, feedforward: float = 0.0) -> control.StateSpace:
    lead = rotor_inertia / (2 * C_M * K * SPEED)
    A = np.array([[-KAPPA, 1 - LAG * lead], [0.0, -LAG]])
    F, G = held(A, np.array([LAG * lead, LAG]), feedforward * lead)
    return open_loop(F, G, np.array([kp - KAPPA, 0.0, 0.0]))


def pitch_loop(kp, kd, kp_v, kd_v) -> control.StateSpace:
    """States are θ, q, v, δ, what is held, and f."""
    A = np.zeros((4, 4))
    A[0, 1] = A[1, 3] = 1.0
    A[2, [0, 2]] = GRAVITY, -BETA
    A[3, 3] = -LAG
    F, G = np.zeros((6, 6)), np.zeros(6)
    F[:5, :5], G[:5] = held(A, np.array([0, 0, 0, LAG]))
    follows = -math.expm1(-T / ESTIMATE)
    F[5, [2, 5]] = follows, 1.0 - follows
    estimate = np.array([0, 0, 1.0, 0, 0, -1.0]) * follows / T
    wanted = np.array([0, 0, BETA - kp_v, 0, 0, 0]) - kd_v * estimate
    tilt, rate = np.eye(6)[0] - wanted / GRAVITY, np.eye(6)[1]
    return open_loop(F, G, kp * tilt + kd * rate)


def by_hand(loop) -> tuple[float, float, float]:
    """Return gain margin, phase margin [rad] and crossover [rad/s] by python-control."""
    # up to half the sampling rate, where L is real, too
    at = np.append(np.geomspace(1e-4, 0.999999, 2000) * math.pi / T, math.pi / T)
    data = control.frd(loop(np.exp(1j * at * T)), at)
    gains, phases, _, _, at_gain, _ = control.stability_margins(data, returnall=True)
    edge = -1.0 / loop(-1.0 + 0.0j).real
    phases = np.abs((np.array(phases) + 180.0) % 360.0 - 180.0)
    return (
        min(gain for gain in (*gains, edge) if gain > 1.0),
        math.radians(phases.min()),
        max(at_gain),
    )


@pytest.fixture(scope="module")
def study():
    return LinearStudy()


def compare(found, wanted):
    gain, phase, crossover = wanted
    assert found.gain_margin == pytest.approx(gain, rel=0.01)
    assert found.phase_margin == pytest.approx(phase, rel=0.01)
    assert found.crossover == pytest.approx(crossover, rel=0.01)


def test_the_zero_of_the_yaw_loop():
    """At 3.1 rad/s it makes the loop ten times as fast, and takes most of its gain margin."""
    zero = 2 * C_M * K * SPEED / J
    assert zero == pytest.approx(3.107, rel=1e-3)
    with_it, without = (by_hand(yaw_loop(4.0, inertia)) for inertia in (J, 0.0))
    assert with_it[0] < 5.0 < 50.0 < without[0]
    assert with_it[2] > 30.0 > 4.0 > without[2]


@pytest.mark.parametrize("feedforward", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("kp", [2.0, 4.0, 8.0])
def test_the_yaw_loop_is_the_one_derived_by_hand(study, kp, feedforward):
    model = study.sampled(gains={"kp_yaw_rate": kp, "spin_up_feedforward": feedforward})
    compare(loop_margins(model, "yaw_acceleration"), by_hand(yaw_loop(kp, J, feedforward)))


@pytest.mark.parametrize(
    ("kp", "kd", "kd_v"),
    [(225.0, 27.0, 0.1), (100.0, 18.0, 0.1), (400.0, 60.0, 0.1), (225.0, 27.0, 0.8)],
)
def test_the_pitch_loop_is_the_one_derived_by_hand(study, kp, kd, kd_v):
    gains = {"kp_pitch": kp, "kd_pitch": kd, "kp_velocity_x": 4.45, "kd_velocity_x": kd_v}
    model = study.sampled(gains=gains)
    compare(loop_margins(model, "pitch_acceleration"), by_hand(pitch_loop(kp, kd, 4.45, kd_v)))


def test_the_pitch_loops_gain_margin_is_the_exact_lags():
    gain, _, _ = by_hand(pitch_loop(225.0, 27.0, 4.45, 0.1))
    assert gain == pytest.approx(8.70, rel=0.01)


# Steps of pid and lqi. The plant of each axis is the one above; climb is dv/dt = δ. The drag of the
# rotors, UP above the centre of mass, where the drone moves at v + UP q, also turns it: without
# that the step of lqi would be off by 0.7 %. Below stands what the laws ask for, a, and what they
# remember, linear in x, memory and the command c.

UP, I_YY = 0.0388, 0.02443
TURNS = BETA * MASS * UP / I_YY
LEVEL = [
    [0, 1, 0, 0],
    [0, -TURNS * UP, -TURNS, 1],
    [GRAVITY, -BETA * UP, -BETA, 0],
    [0, 0, 0, -LAG],
]
DERIVATIVE, STEP = 0.01, 1e-4
"""pid's filter of dω/dt [s]; of a command, so small that rotors answer linearly [m/s, rad/s]."""
PLANTS = {
    "x": (LEVEL, [0, 0, 0, LAG]),
    "z": ([[0, 1], [0, -LAG]], [0, LAG]),
    "yaw": (
        [[-KAPPA, 1 - LAG * J / (2 * C_M * K * SPEED)], [0, -LAG]],
        [LAG * J / (2 * C_M * K * SPEED), LAG],
    ),
}
SPEED_OF = {"x": 2, "z": 0, "yaw": 0}
"""Place of what is commanded in the plant's state, whose last place is the command before."""
FOLLOWS = -math.expm1(-T / ESTIMATE)


def pid(axis, g):
    """Return how many numbers it remembers, and its update."""

    def level(x, m, c):
        theta, q, v = x[:3]
        i_v, i_w, f, w_f = m
        error = c - v
        wanted = g["kp_velocity_xy"] * error + i_v + BETA * v
        wanted -= g["kd_velocity_xy"] * FOLLOWS * (v - f) / T
        rate_error = g["kp_tilt"] * (wanted / GRAVITY - theta) - q
        dw = (q - w_f) / (DERIVATIVE + T)
        after = (
            i_v + T * g["ki_velocity_xy"] * error,
            i_w + T * g["ki_rate"] * rate_error,
            f + FOLLOWS * (v - f),
            w_f + T * dw,
        )
        return g["kp_rate"] * rate_error + i_w - g["kd_rate"] * dw, after

    def climb(x, m, c):
        (v, *_), (i_v, f) = x, m
        asked = g["kp_velocity_z"] * (c - v) + i_v - g["kd_velocity_z"] * FOLLOWS * (v - f) / T
        return asked, (i_v + T * g["ki_velocity_z"] * (c - v), f + FOLLOWS * (v - f))

    def yaw(x, m, c):
        r, i = x[0], m[0]
        return g["kp_yaw_rate"] * (c - r) + i + KAPPA * r, (i + T * g["ki_yaw_rate"] * (c - r),)

    return {"x": (4, level), "z": (2, climb), "yaw": (1, yaw)}[axis]


def lqi(axis, g):
    share = T / (1 / LAG + T)

    def level(x, m, c):
        theta, q, v, before = *x[:3], x[-1]
        integral, rotors = m
        k_i, k_v, k_theta, k_q, k_rotors = feedback("x", g)
        rotors = rotors + share * (before - rotors)
        wanted = GRAVITY / k_theta * (k_v * (c - v) + k_i * integral) + BETA * v
        asked = k_theta * (wanted / GRAVITY - theta) - k_q * q - k_rotors * rotors
        return asked, (integral + T * (c - v), rotors)

    def chain(x, m, c):
        v, before = x[0], x[-1]
        integral, rotors = m
        k_i, k_v, k_rotors = feedback(axis, g)
        rotors = rotors + share * (before - rotors)
        drag = (KAPPA if axis == "yaw" else 0.0) * v
        asked = k_v * (c - v) + k_i * integral - k_rotors * rotors + (1 + k_rotors) * drag
        return asked, (integral + T * (c - v), rotors)

    return 2, level if axis == "x" else chain


def feedback(axis, g):
    """Return lqi's gains by dlqr: integral, velocity (tilt, its rate) and rotors."""
    if axis == "x":
        A = [[0, 1, 0, 0, 0], [0, 0, -GRAVITY, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]
        A = np.array([*A, [0, 0, 0, 0, -LAG]], float)
        weights = [g[f"q_{n}"] for n in ("level_integral", "level_velocity", "tilt", "tilt_rate")]
        weights.append(0.0)
    else:
        A = np.array([[0, 1, 0], [0, 0, -1], [0, 0, -LAG]], float)
        names = (
            ("climb_integral", "climb_velocity") if axis == "z" else ("yaw_integral", "yaw_rate")
        )
        weights = [*(g[f"q_{name}"] for name in names), 0.0]
    n = len(A)
    both = np.zeros((n + 1, n + 1))
    both[:n, :n], both[n - 1, n] = A, LAG
    sampled = expm(both * T)
    F, G = sampled[:n, :n], sampled[:n, n:]
    k, riccati, _ = control.dlqr(F, G, np.diag(weights), np.eye(1))
    assert riccati == pytest.approx(solve_discrete_are(F, G, np.diag(weights), np.eye(1)))
    return np.array([-1, -1, *[1] * (n - 2)]) * k[0]  # errors are commands less what is measured


def closed_loop(law, axis, g) -> control.StateSpace:
    """Return the closed loop from a command to what is commanded."""
    lead = J / (2 * C_M * K * SPEED) if axis == "yaw" else 0.0
    F, G = held(*map(np.array, PLANTS[axis]), lead=g["spin_up_feedforward"] * lead)
    size, update = law(axis, g)
    n = len(F)

    def after(everything):
        x, m, c = everything[:n], everything[n : n + size], everything[-1]
        asked, remembered = update(x, m, c)
        return np.concatenate([F @ x + G * asked, remembered])

    columns = np.array([after(unit) for unit in np.eye(n + size + 1)]).T
    out = np.eye(n + size)[SPEED_OF[axis]]
    return control.ss(columns[:, :-1], columns[:, -1:], out[None, :], 0.0, T)


STEP_AT = 0.25
"""[s]"""


@pytest.mark.parametrize("law", [pid, pytest.param(lqi, marks=pytest.mark.slow)])
def test_small_steps_of_pid_and_lqi_are_those_of_loops_by_hand(law, case):
    """On the full diagram, with the rule's gains, for 4 s; within half a percent of the step."""
    session = Session(
        Scenario(
            controller=law.__name__, start=ScenarioStart(position=[0.0, 0.0, 60.0]), duration=1000.0
        )
    )
    g = session.parameters()
    for axis in PLANTS:
        session.reset()
        session.tick(STEP_AT)
        session.command([STEP * (axis == each) for each in "xyz"], STEP * (axis == "yaw"))
        session.tick(4.0)
        flown = session.recording()
        which = flown.time >= STEP_AT - 1e-9
        found = (flown.w_WB[:, 2] if axis == "yaw" else flown.v_WB[:, "xyz".index(axis)])[which]
        _, wanted = control.step_response(closed_loop(law, axis, g), np.arange(len(found)) * T)
        with case(axis):
            assert found / STEP == pytest.approx(wanted, abs=0.005)
            assert wanted[-1] == pytest.approx(1.0, abs=0.1)


def test_lqis_gains_are_dlqrs_of_matrices_by_hand(vehicle):
    law = load_controller("lqi")
    rng = np.random.default_rng(3)
    for _ in range(20):
        g = {row.name: row.default for row in law.parameters}
        for name in g:
            if name.startswith("q_"):
                g[name] *= 10.0 ** rng.uniform(-1.0, 1.0)
        found = law.gains(g, known_body(law_constants(vehicle)), T)[len(law.parameters) :]
        wanted = np.concatenate([feedback(axis, g) for axis in PLANTS])
        assert found == pytest.approx(wanted, rel=1e-6)
