"""The push that brings a model to a log, and a memory that the log tells: run as plain Python."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.extras.flightdata.predict import driven
from workbench.extras.flightdata.predict.driven import correct_push, make_run_law

PERIOD, MASS = 1 / 128, 1.3
INERTIA = np.array([[0.020, 0.003, -0.002], [0.003, 0.030, 0.004], [-0.002, 0.004, 0.045]])


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Records whose fields are read without a compiler."""
    monkeypatch.setattr(driven, "get_field", getattr)
    monkeypatch.setattr(driven, "get_lane", lambda body, field, lane: body[field])


def state_of(R_WB, w, v):
    x, y, z, q_w = R_WB.as_quat()
    return np.array([q_w, x, y, z, 1.0, 2.0, 3.0, *w, *v])


def test_a_push_is_what_mass_and_the_whole_inertia_need_for_the_velocities_of_the_log():
    """f = m dv / T in W, and m = J dw / T in B; the log comes back to where the period began."""
    random = np.random.default_rng(2)
    R_WB, w, v, w_now, v_now = Rotation.random(random_state=5), *random.normal(size=(4, 3))
    upper = INERTIA[np.triu_indices(3)]
    body = {"mass": MASS, "inertia": tuple(upper)}
    push = np.zeros(9)
    correct_push(
        push,
        SimpleNamespace(state=state_of(R_WB, w_now, v_now), target=state_of(R_WB, w, v)),
        SimpleNamespace(state=state_of(R_WB, -w, -v)),
        body,
        0,
        PERIOD,
    )
    moment = INERTIA @ R_WB.inv().apply(w - w_now) / PERIOD
    np.testing.assert_allclose(push, [*(MASS * (v - v_now) / PERIOD), 0.0, 0.0, 0.0, *moment])


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_attitude_that_the_log_has_turned_by_a_little_is_closed_either_way_it_is_written(sign):
    """A quaternion and its negative are one attitude: the turn is 0.01 rad, and no whole one."""
    begun, still = Rotation.random(random_state=6), np.zeros(3)
    turn = np.array([0.006, -0.008, 0.0])
    now = Rotation.from_rotvec(turn) * begun
    target = state_of(now, still, still)
    target[:4] *= sign
    push = np.zeros(9)
    correct_push(
        push,
        SimpleNamespace(state=state_of(now, still, still), target=target),
        SimpleNamespace(state=state_of(begun, still, still)),
        {"mass": MASS, "inertia": tuple(INERTIA[np.triu_indices(3)])},
        0,
        PERIOD,
    )
    moment = INERTIA @ now.inv().apply(turn) / driven.CLOSING_TIME_S / PERIOD
    np.testing.assert_allclose(push, [*np.zeros(6), *moment], rtol=1e-4, atol=1e-12)


def test_an_integral_takes_its_share_of_what_a_memory_differs_by_over_its_gain(monkeypatch):
    """Of 2 more, half is the integral's, behind a gain of 4: 0.25; what is not told stays."""
    monkeypatch.setattr(driven, "make_law_update", lambda controller: lambda flight, clock: None)
    listen = make_run_law(SimpleNamespace(key="none"))
    flight = SimpleNamespace(
        known=np.zeros(13), reference=np.zeros(8), memory=np.array([1.0, 10.0, 5.0])
    )
    told = np.array([[3.0, 7.0], [np.nan, np.nan]])
    places = np.array([[0.0, 1.0, 4.0, 0.5], [2.0, -1.0, 1.0, 1.0]])
    found = np.zeros((2, 3))
    listen([flight], None, np.zeros((2, 13)), np.zeros((2, 8)), np.ones(2), told, places, found)
    np.testing.assert_allclose(found, [[3.0, 10.25, 7.0]] * 2)
