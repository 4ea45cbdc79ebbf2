"""Oracle: percentages by hand."""

import math

import pytest

from workbench.control.controller_file import load_controller
from workbench.gains.gain_change import diff_gains

MISSING = {**load_controller().table.defaults(), "kd_roll": 30.0}


def test_rows_are_in_the_tables_order_with_units_and_percent():
    rows = diff_gains(
        {"kp_roll": 100.0, "kp_velocity_z": 4.0}, {"kp_velocity_z": 5.0, "kp_roll": 50.0}, MISSING
    )
    assert [tuple(row) for row in rows] == [
        ("kp_velocity_z", "1/s", 4.0, 5.0, 25.0),
        ("kp_roll", "1/s^2", 100.0, 50.0, -50.0),
    ]


def test_what_one_lacks_comes_from_the_rule():
    assert [tuple(row) for row in diff_gains({"kd_roll": 15.0}, {"max_tilt": 0.35}, MISSING)] == [
        ("kd_roll", "1/s", 15.0, 30.0, 100.0),
        ("max_tilt", "rad", 0.7, 0.35, -50.0),
    ]


@pytest.mark.parametrize(
    ("a", "b", "percent"), [(0.0, 0.0, 0.0), (0.0, 1.0, math.nan), (-2.0, -1.0, 50.0)]
)
def test_percent_at_nought_and_below(a, b, percent):
    (row,) = diff_gains({"wind_x": a}, {"wind_x": b}, MISSING)
    assert row.percent == pytest.approx(percent, nan_ok=True)
