"""Small coordinates of joints beside the rotations of pydrake."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import AngleAxis, Quaternion

from workbench.design.linear.joint_coordinates import JointCoordinates

SMALL = np.array([0.3, 0.4, -0.2, 0.5, 1.0, 2.0, 3.0, -0.7])
"""An angle, a rotation vector with a place, a distance."""


def test_positions_have_the_rotation_of_their_vector_and_lead_back():
    coordinates = JointCoordinates((1, 7, 1))
    positions, _ = coordinates.positions(SMALL)
    turn = np.linalg.norm(SMALL[1:4])
    R = AngleAxis(turn, SMALL[1:4] / turn).rotation()
    assert Quaternion(positions[1:5]).rotation() == pytest.approx(R, abs=1e-12)
    assert positions[[0, 5, 6, 7, 8]] == pytest.approx(SMALL[[0, 4, 5, 6, 7]])
    assert coordinates.small(positions) == pytest.approx(SMALL, abs=1e-12)


def test_derivatives_are_those_of_a_small_rotation_that_is_added():
    coordinates, step = JointCoordinates((1, 7, 1)), 1e-6
    positions, derivatives = coordinates.positions(SMALL)
    for axis in range(3):
        turned = AngleAxis(step, np.eye(3)[axis]).quaternion().multiply(Quaternion(positions[1:5]))
        slope = (turned.wxyz() - positions[1:5]) / step
        assert derivatives[1:5, 1 + axis] == pytest.approx(slope, abs=1e-5)
    back = coordinates.inverse(derivatives) @ derivatives
    assert back == pytest.approx(np.eye(8), abs=1e-12)
