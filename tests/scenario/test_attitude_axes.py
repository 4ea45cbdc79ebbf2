"""Setpoints of attitude and rate beside rotations of pydrake."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.math import RollPitchYaw, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.scenario.attitude_axes import ATTITUDE_ROWS, find_attitude_axis


def attitude(roll, pitch, yaw):
    return RotationMatrix(RollPitchYaw(roll, pitch, yaw))


def test_a_positive_setpoint_tilts_the_thrust_into_its_direction(case):
    for row in ATTITUDE_ROWS:
        for yaw in (0.0, 0.7, -2.5):
            angles = [0.0, 0.0]
            angles[row.place] = 0.2
            x, y, _ = attitude(*angles, yaw).matrix()[:, 2]
            level = math.hypot(x, y)
            with case(row.name, yaw):
                expected = [x / level, y / level, 0.0]
                assert row.direction(yaw) == pytest.approx(expected, abs=1e-12)


def test_a_response_is_the_angle_or_the_rate_about_the_axis_of_the_body(case):
    draw = np.random.default_rng(2)
    angles = draw.uniform(-1.2, 1.2, (20, 3))
    rotations = [attitude(*each) for each in angles]
    q_WB = np.array([R.ToQuaternion().wxyz() for R in rotations])
    w_WB = draw.normal(size=(20, 3))
    w_B = np.array([R.matrix().T @ w for R, w in zip(rotations, w_WB, strict=True)])
    for row in ATTITUDE_ROWS:
        expected = (w_B if row.is_rate else angles)[:, row.place]
        with case(row.name):
            assert row.moved(q_WB, w_WB) == pytest.approx(expected, abs=1e-12)


def test_a_setpoint_leads_to_the_unit_of_its_point_and_back(case):
    degree = 57.29577951308232
    units = {"1": math.tan(0.3), "rad": 0.3, "deg": 0.3 * degree, "deg/s": 0.3 * degree}
    for row in ATTITUDE_ROWS:
        for unit, value in units.items():
            law = SimpleNamespace(file="law.py", points={row.point: unit})
            with case(row.name, unit):
                assert row.at_point(0.3, law) == pytest.approx(value)
                assert row.from_point(value, law) == pytest.approx(0.3)
                slope = (row.at_point(1e-6, law) - row.at_point(-1e-6, law)) / 2e-6
                assert row.slope_at_point(law) == pytest.approx(slope, rel=1e-6)


def test_a_step_from_a_hover_that_leans_may_tilt_by_less():
    roll, rate = find_attitude_axis("roll"), find_attitude_axis("roll_rate")
    roll.check_tilt(0.4, 1.0, 0.5)
    roll.check_tilt(0.4, 1.0, 0.5, hover=-0.3)
    with pytest.raises(
        WorkbenchError, match=r"from a hover of 0.2 rad would tilt the drone by 0.60"
    ):
        roll.check_tilt(0.4, 1.0, 0.5, hover=0.2)
    rate.check_tilt(-0.5, 0.9, 0.5)
    with pytest.raises(WorkbenchError, match=r"for 1.1 s would tilt the drone by 0.55 rad"):
        rate.check_tilt(-0.5, 1.1, 0.5)
