"""Measurements of a motor that are known by hand."""

import itertools
import math

import pytest

from workbench.plant.thrust_curve import read_thrust_curve

ROWS = ("3000,100,0.01", "6000,400,0.04", "9000,900,0.09")
"""rpm, thrust in g, torque in N·m: a parabola without noise."""


def test_rows_may_be_in_any_order(tmp_path, case):
    path = tmp_path / "motor.csv"
    for rows in itertools.permutations(ROWS):
        path.write_text("\n".join(["rpm,thrust_g,torque_Nm", *rows]))
        found = read_thrust_curve(path)
        with case(rows):
            assert found.motor_constant == pytest.approx(0.9 * 9.80665 / (300.0 * math.pi) ** 2)
            assert found.max_speed == pytest.approx(300.0 * math.pi)
            assert found.moment_constant == pytest.approx(0.09 / (0.9 * 9.80665))
