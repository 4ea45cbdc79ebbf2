"""Modes, against python-control's damp."""

import control
import numpy as np
import pytest

from workbench.design.judge.modes import least_damping, modes, modes_of, named_poles


@pytest.mark.parametrize("period", [0.0, 0.01])
def test_modes_are_in_the_words_of_damp(closed, period):
    loop = control.tf([40.0], [1.0, 12.0, 20.0, 0.0])
    system = control.sample_system(control.ss(loop), period, "zoh") if period else loop
    model = closed(system)
    found = modes(model)
    frequency, damping, poles = control.damp(
        control.ss(model.A, model.b[:, None], model.c[None], 0, period), doprint=False
    )
    expected = sorted({(round(w, 9), round(z, 9)) for w, z in zip(frequency, damping, strict=True)})
    assert [(m.frequency, m.damping) for m in found] == pytest.approx(
        [pytest.approx(pair, rel=1e-6) for pair in expected]
    )
    slowest = found[0]
    pole = poles[np.argmin(frequency)]
    s = np.log(pole) / period if period else pole
    assert slowest.time_constant == pytest.approx(-1.0 / s.real, rel=1e-9)
    assert abs(slowest.imaginary) == pytest.approx(abs(s.imag), rel=1e-9)


def test_what_grows_has_negative_damping(closed):
    found = modes(closed(control.tf([7.0], [1.0, 3.0, 2.0, 0.0])))
    assert found[0].damping < 0.0
    assert found[0].time_constant < 0.0
    assert least_damping(found) == found[0].damping


def test_place_and_heading_are_no_modes(steering, holding):
    assert min(mode.frequency for mode in modes(steering)) > 1.0
    assert min(mode.frequency for mode in modes(holding)) == pytest.approx(1.43, rel=0.02)
    count = sum(2 if mode.imaginary else 1 for mode in modes(steering))
    assert count <= len(steering.A) - 4


@pytest.mark.parametrize("scale", [1.0, 1e-4, 1e5])
def test_modes_have_the_names_of_joints_that_move_in_them(scale):
    """Two pendulums on springs k that a spring e between them couples, and a loop of one state.

    By hand: with e far below the difference of their stiffnesses each moves alone, but for a share
    (e / (k_2 - k_1))² of the other; the units of a state change no participation.
    """
    states = ["speed", "slow_q", "quick_q", "slow_w", "quick_w"]
    k_1, k_2, e = 4.0, 100.0, 1.0
    A = np.zeros((5, 5))
    A[0, 0] = -7.0
    A[[1, 2], [3, 4]] = 1.0
    A[3, 1:3], A[4, 1:3] = (-k_1 - e, e), (e, -k_2 - e)
    A[4, 0] = 3.0
    T = np.diag([1.0, scale, 1.0, scale, 1.0 / scale])
    poles, names = named_poles(
        T @ A @ np.linalg.inv(T), states, ["slow_q", "quick_q", "slow_w", "quick_w"]
    )
    found = {name: pole for pole, name in zip(poles, names, strict=True) if pole.imag >= 0.0}
    assert found[""].real == pytest.approx(-7.0)
    for name, k in (("slow", k_1), ("quick", k_2)):
        assert abs(found[name]) == pytest.approx(np.sqrt(k + e), rel=1e-2)


def test_modes_in_which_joints_move_alike_have_the_name_of_one():
    """Four equal legs on springs k, which springs e couple: a quarter of each mode is of each.

    By hand: all together at the rate sqrt(k), and against each other at sqrt(k + 4 e).
    """
    k, e, legs = 25.0, 2.0, [f"leg{number}" for number in (1, 2, 3, 4)]
    states = [f"{leg}_x" for leg in legs] + [f"{leg}_v" for leg in legs]
    stiffness = k * np.eye(4) + e * (4.0 * np.eye(4) - 1.0)
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-stiffness, np.zeros((4, 4))]])
    poles, names = named_poles(A, states, states)
    together = np.abs(np.abs(poles) - np.sqrt(k)) < 1e-6
    assert together.sum() == 2 and np.abs(poles[~together]) == pytest.approx(np.sqrt(k + 4.0 * e))
    assert set(names) <= set(legs)


def test_a_mode_is_gone_where_its_envelope_is_a_twentieth():
    (mode,) = modes_of(np.array([-0.4 + 3.0j, -0.4 - 3.0j]), 0.0)
    after = -np.log(0.05) / 0.4  # e^-3 is a twentieth
    assert mode.gone_after(1.01 * after)
    assert not mode.gone_after(0.99 * after)
    (growing,) = modes_of(np.array([0.4]), 0.0)
    assert not growing.gone_after(1e6)
