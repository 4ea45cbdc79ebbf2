"""The motion between two instants beside a motion in closed form."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis

from workbench.dynamics.motion_between import (
    body_rate,
    mean_specific_force,
    motion_between,
    motions_between,
    point_motion,
)

PERIOD, GRAVITY = 1 / 128, 9.81
P_BS = (0.1, -0.2, 0.05)
W = np.array([1.0, -2.0, 0.5])
"""Angular velocity, the same in W and B [rad/s]."""
A = np.array([3.0, 1.0, -4.0])
"""Of the base [m/s²]."""


def state(time: float) -> list[float]:
    """Return that of a body which turns evenly and accelerates evenly (13)."""
    rate = float(np.linalg.norm(W))
    q = AngleAxis(rate * time, W / rate).quaternion().wxyz()
    return [*q, *(0.5 * A * time**2), *W, *(A * time)]


@pytest.fixture
def ends():
    return tuple(np.array(point_motion(state(time), P_BS)) for time in (0.0, PERIOD))


def test_between_two_instants_a_point_moves_as_its_body_does(ends, case):
    found = np.zeros(14)
    for share in (0.0, 0.25, 0.5, 0.9, 1.0):
        motion_between(*ends, PERIOD, share, found)
        expected = np.array(point_motion(state(share * PERIOD), P_BS))
        with case(share):
            assert found[:7] == pytest.approx(expected[:7], abs=1e-9)
            assert found[7:] == pytest.approx(expected[7:], abs=1e-5)
            assert body_rate(found) == pytest.approx(W, abs=1e-4)
    ends_of_parts, middles = motions_between(*ends, PERIOD, 4, 0.25)
    for part in range(4):
        for row, share in ((ends_of_parts[part], part + 1.0), (middles[part], part + 0.5)):
            motion_between(*ends, PERIOD, 0.25 * share, found)
            assert row == pytest.approx(found, abs=1e-12)


def test_the_mean_specific_force_is_that_of_the_change_of_velocity(ends):
    middle = np.array(point_motion(state(0.5 * PERIOD), P_BS))
    R = AngleAxis(0.5 * PERIOD * np.linalg.norm(W), W / np.linalg.norm(W)).rotation()
    arm = R @ P_BS
    expected = R.T @ (A + np.cross(W, np.cross(W, arm)) + [0.0, 0.0, GRAVITY])
    found = mean_specific_force(ends[0], middle, ends[1], PERIOD, GRAVITY)
    assert found == pytest.approx(expected, abs=1e-3)
