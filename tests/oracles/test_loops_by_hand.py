"""Margins of the yaw and the pitch loop against loops derived by hand.

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

Between an update of the law and the motion that it makes there is one physics step; then the
command holds for a control period.
"""

import math

import control
import numpy as np
import pytest
from scipy.linalg import expm

from workbench.design.judge.margins import loop_margins
from workbench.design.linear.study import LinearStudy

T, LATE = 1 / 128, 1 / 1024
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
    """Return F and G of x_next = F x + G a, of dx/dt = A x + B u, where u is held for T, acts LATE.

    x(T) = e^{A T} x + e^{A (T - LATE)} H(LATE) u_before + H(T - LATE) u,  H(t) = ∫ e^{A s} B ds.
    The last state is u_before; u is a share of what the law asks for, a, and the rest u_before.
    """
    n = len(A)
    extended = np.zeros((n + 1, n + 1))
    extended[:n, :n], extended[:n, n] = A, B

    def over(time):
        both = expm(extended * time)
        return both[:n, :n], both[:n, n]

    (early, before), (late, now) = over(LATE), over(T - LATE)
    F = np.zeros((n + 1, n + 1))
    share = T / (T + lead)
    F[:n, :n], F[:n, n], F[n, n] = late @ early, late @ before + (1 - share) * now, 1 - share
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
    assert gain == pytest.approx(6.89, rel=0.01)
