"""The heading that laws know."""

import math

import pytest
from pydrake.math import RollPitchYaw, RotationMatrix

from workbench.control.flight_state import level_heading


def test_the_heading_is_the_yaw_and_0_where_the_nose_is_vertical(case):
    for pitch, yaw in ((0.3, 0.0), (-1.2, 2.0), (0.0, -3.0)):
        R = RotationMatrix(RollPitchYaw(0.4, pitch, yaw)).matrix()
        with case(pitch, yaw):
            expected = (math.cos(yaw), math.sin(yaw), math.cos(pitch))
            assert level_heading(R.ravel().tolist()) == pytest.approx(expected)
    up = [0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]
    assert level_heading(up) == (1.0, 0.0, 0.0)
