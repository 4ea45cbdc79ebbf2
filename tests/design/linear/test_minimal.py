"""Oracle: transfer functions at points of the plane, and orders known by hand."""

import control
import numpy as np
import pytest

from workbench.design.linear.linearize import linearize, minimal_realisation
from workbench.design.linear.model import Matrices


def least_of(A, B, C):
    """Return the system of least order, as python-control has it."""
    D = np.zeros((len(C), B.shape[1]))
    inputs, outputs = (
        [f"{name}{k}" for k in range(n)] for name, n in (("u", D.shape[1]), ("y", len(D)))
    )
    return minimal_realisation(Matrices(A, B, C, D, 0, (), inputs, outputs, "small")).state_space()


def test_what_is_not_moved_or_not_shown_is_left_out():
    A = np.diag([-1.0, -2.0, -3.0, -4.0])
    B, C = np.array([[1.0], [1.0], [0.0], [0.0]]), np.array([[1.0, 0.0, 1.0, 0.0]])
    small = least_of(A, B, C)
    assert small.nstates == 1
    assert small.poles() == pytest.approx([-1.0])


@pytest.mark.parametrize("seed", range(5))
def test_it_answers_alike_and_is_of_least_order(seed):
    rng = np.random.default_rng(seed)
    core = control.ss(
        np.diag(-rng.uniform(0.5, 5.0, 4)), rng.normal(size=(4, 2)), rng.normal(size=(2, 4)), 0
    )
    hidden = np.block(
        [
            [core.A, np.zeros((4, 2)), rng.normal(size=(4, 1))],
            [rng.normal(size=(2, 4)), -np.eye(2), rng.normal(size=(2, 1))],
            [np.zeros((1, 6)), -np.ones((1, 1))],
        ]
    )
    turn = np.linalg.qr(rng.normal(size=(7, 7)))[0]
    B = np.vstack([core.B, rng.normal(size=(2, 2)), np.zeros((1, 2))])
    C = np.hstack([core.C, np.zeros((2, 2)), rng.normal(size=(2, 1))])
    small = least_of(turn @ hidden @ turn.T, turn @ B, C @ turn.T)
    assert small.nstates == 4
    for s in (0.3j, 2.0 + 1.0j, 10.0j):
        assert small(s) == pytest.approx(core(s), rel=1e-6, abs=1e-9)


def test_orders_of_the_hovering_drone_are_those_of_its_chain():
    """Velocity, tilt, rate, lag and the estimate's filter along x; no place, no other axis."""
    system = linearize(inputs=["reference_v_x"], outputs=["v_x"], time="continuous", minimal=True)
    assert system.nstates == 5
    sampled = linearize(inputs=["reference_v_x"], outputs=["v_x"], minimal=True)
    assert sampled.dt == 1 / 128
    whole = linearize(inputs=["reference_v_x"], outputs=["v_x"])
    for w in (0.5, 5.0, 50.0):
        z = np.exp(1j * w / 128)
        assert complex(sampled(z)) == pytest.approx(complex(whole(z)), rel=1e-4)
