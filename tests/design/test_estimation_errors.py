"""Errors of estimates made up from drawn errors: what was put in must come out.

Attitudes are made by pydrake.math, which the code under test does not use; NEES of errors drawn
from their covariance is chi-square distributed by its definition.
"""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RotationMatrix
from scipy.stats import chi2, kstest

from workbench.common.resources import find_model
from workbench.design.estimation_errors import (
    estimate_errors,
    judge_estimate,
    nees,
    over_truth,
)
from workbench.estimation.run import EstimateHistory
from workbench.plant.loading import load_vehicle
from workbench.plant.sensors import Imu
from workbench.session.recording import Recording

P_BI = np.array([0.3, -0.2, 0.1])
"""The IMU lies far from the origin, so that its lever counts [m]."""


@pytest.fixture(scope="module")
def vehicle():
    found = load_vehicle(find_model("dh_drone"))
    sensors = tuple(
        dataclasses.replace(each, p_BS=tuple(P_BI)) if isinstance(each, Imu) else each
        for each in found.sensors
    )
    return dataclasses.replace(found, sensors=sensors)


@pytest.fixture(scope="module")
def drawn():
    """Return errors of attitude, place and velocity of the IMU, and their covariance."""
    rng = np.random.default_rng(5)
    n = 2000
    root = 0.01 * rng.normal(size=(9, 9))
    return rng.normal(size=(n, 9)) @ root.T, root @ root.T


@pytest.fixture(scope="module")
def recording(vehicle, drawn):
    errors, P = drawn
    n = len(errors)
    rng = np.random.default_rng(6)
    sizes = {"state": 13, "acceleration": 6, "thrusts": 4, "reference": 8, "speeds": 4}
    sizes |= {"commands": 4, "wind": 3, "mode": 9, "charge": 1}
    raw = {name: rng.normal(size=(n, size)) for name, size in sizes.items()}
    truth = Recording.from_signals(vehicle, 0.01 * np.arange(n), raw)
    estimate = np.empty((n, 13))
    for i, (d, p, v) in enumerate(zip(*np.split(errors, 3, axis=1), strict=True)):
        R_true = RotationMatrix(Quaternion(wxyz=truth.q_WB[i]))
        angle = np.linalg.norm(d)
        R = R_true @ RotationMatrix(AngleAxis(angle, d / angle)).inverse()
        w = truth.w_WB[i] - 0.1 * d
        arm, known_arm = R_true.matrix() @ P_BI, R.matrix() @ P_BI
        estimate[i, 0:4] = R.ToQuaternion().wxyz()
        estimate[i, 4:7] = truth.p_WB[i] + arm - p - known_arm
        estimate[i, 7:10] = w
        swing = np.cross(truth.w_WB[i], arm)
        estimate[i, 10:13] = truth.v_WB[i] + swing - v - np.cross(w, known_arm)
    return dataclasses.replace(
        truth,
        estimate=estimate,
        deviations=np.tile(np.append(np.sqrt(np.diag(P)), np.zeros(6)), (n, 1)),
        covariance=np.tile(P[np.triu_indices(9)], (n, 1)),
        innovations=np.full((n, 20), np.nan),
    )


def test_the_error_is_the_one_that_was_put_in(recording, drawn):
    found = estimate_errors(recording)
    assert found.attitude_B == pytest.approx(drawn[0][:, :3], abs=1e-12)
    assert found.angular_velocity == pytest.approx(0.1 * drawn[0][:, :3], abs=1e-12)
    rows = {state.name: state for state in judge_estimate(recording).states}
    for name, size in zip(("roll", "pitch", "yaw"), drawn[0][:, :3].T, strict=True):
        assert rows[name].rms == pytest.approx(np.std(size), rel=2e-3)
        assert rows[name].worst == pytest.approx(np.abs(size).max())
        assert rows[name].unit == "rad"
    x = recording.p_WB[:, 0] - recording.estimate[:, 4]
    assert rows["x"].rms == pytest.approx(math.sqrt(np.mean(x**2)))
    w_z = recording.w_WB[:, 2] - recording.estimate[:, 9]
    assert rows["w_z"].worst == pytest.approx(np.abs(w_z).max())


def test_nees_of_drawn_errors_is_chi_square(recording, drawn):
    """The lever of the IMU and all correlations count."""
    errors, P = drawn
    found = nees(recording)
    assert found == pytest.approx(np.sum(errors * np.linalg.solve(P, errors.T).T, axis=1), rel=1e-6)
    assert kstest(found, chi2(9).cdf).pvalue > 0.01
    judged = judge_estimate(recording).nees
    assert (judged.lower, judged.upper) == pytest.approx((2.70039, 19.02277), abs=1e-4)  # tables
    assert judged.within == pytest.approx(0.95, abs=0.02)
    assert judged.mean == pytest.approx(9.0, abs=0.4)


def test_innovations_count_channel_by_channel(recording):
    told = np.full_like(recording.innovations, np.nan)
    told[:1000, 12] = np.random.default_rng(1).normal(scale=0.2, size=1000)  # the barometer's
    told[:1000, 13] = 0.04
    told[::2, 14], told[::2, 15] = 0.3, 0.01  # three sigma: the magnetometer's
    found = judge_estimate(dataclasses.replace(recording, innovations=told)).innovations
    assert [(each.channel, each.count) for each in found] == [
        ("barometer", 1000),
        ("magnetometer", 1000),
    ]
    assert found[0].within == pytest.approx(0.95, abs=0.02)
    assert found[1].within == 0.0
    assert [each.surprises for each in found[:2]] == [False, True]
    assert found[0].scale == pytest.approx(1.0, abs=0.05)


def test_what_an_estimator_does_not_know_is_not_judged(recording):
    unknown = dataclasses.replace(recording, covariance=np.full((len(recording.time), 45), np.nan))
    found = judge_estimate(unknown)
    assert found.nees is None
    assert found.innovations == ()
    assert len(found.states) == 12
    on_truth = dataclasses.replace(recording, estimate=np.empty((2000, 0)))
    assert judge_estimate(on_truth) is None
    assert nees(on_truth) is None


def test_between_two_states_the_truth_turns_and_moves_evenly():
    """A third of a quarter turn about x, and only where the truth is known."""
    half = math.sqrt(0.5)
    states = np.array([[1.0, 0.0, 0.0, 0.0, *range(9)], [half, half, 0.0, 0.0, *range(3, 12)]])
    time = np.array([0.9, 1.0, 2.0, 4.0, 4.1])
    names = ("estimate", "biases", "deviations", "covariance", "innovations")
    history = EstimateHistory(time, **{name: np.zeros((5, 1)) for name in names})
    found = over_truth(history, np.array([1.0, 4.0]), states, (0.0, 0.0, 0.0))
    assert found.time.tolist() == [1.0, 2.0, 4.0]
    turns = [0.0, math.radians(30.0), math.radians(90.0)]
    expected = [[math.cos(0.5 * turn), math.sin(0.5 * turn), 0.0, 0.0] for turn in turns]
    assert found.q_WB == pytest.approx(np.array(expected), abs=1e-12)
    moved = np.hstack([found.p_WB, found.w_WB, found.v_WB])
    assert moved == pytest.approx(np.arange(9) + np.array([[0.0], [1.0], [3.0]]))
