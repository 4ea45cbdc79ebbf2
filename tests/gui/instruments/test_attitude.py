"""The mathematics of the artificial horizon against rotations worked by hand."""

import math

import pytest

from workbench.gui.home.attitude_card import Attitude, Horizon, attitude_of

HALF = math.radians(15.0)
"""Half of 30 degrees, for quaternions."""


def test_a_turn_about_the_left_axis_lowers_the_nose():
    # +30 degrees about y (left): x (forward) turns towards -z, as cos, 0, -sin.
    attitude = attitude_of((math.cos(HALF), 0.0, math.sin(HALF), 0.0))
    assert attitude.nose_up == pytest.approx(math.radians(-30.0))
    assert attitude.bank == pytest.approx(0.0)


def test_a_turn_about_the_forward_axis_lowers_the_right_side():
    # +30 degrees about x (forward): y (left) turns towards z (up), so left goes up.
    attitude = attitude_of((math.cos(HALF), math.sin(HALF), 0.0, 0.0))
    assert attitude.bank == pytest.approx(math.radians(30.0))
    assert attitude.nose_up == pytest.approx(0.0)


def test_where_the_nose_points_does_not_tilt():
    attitude = attitude_of((math.cos(1.0), 0.0, 0.0, math.sin(1.0)))
    assert (attitude.nose_up, attitude.bank) == pytest.approx((0.0, 0.0))


def test_yaw_then_pitch_then_roll_come_back():
    # R = Rz(90) Ry(20) Rx(-40): as quaternions, multiplied by hand.
    a, b, c = math.radians(45.0), math.radians(10.0), math.radians(-20.0)
    cz, sz, cy, sy, cx, sx = (f(x) for x in (a, b, c) for f in (math.cos, math.sin))
    q = (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )
    attitude = attitude_of(q)
    assert attitude.nose_up == pytest.approx(math.radians(-20.0))
    assert attitude.bank == pytest.approx(math.radians(-40.0))


def test_upside_down_is_a_bank_of_half_a_turn():
    assert abs(attitude_of((0.0, 1.0, 0.0, 0.0)).bank) == pytest.approx(math.pi)


def test_an_orientation_that_is_no_number_has_no_attitude():
    assert attitude_of((math.nan, 0.0, 0.0, 0.0)) is None


def test_the_sky_leans_left_when_the_right_side_is_down():
    right, down = Attitude(0.0, math.radians(30.0)).sky
    assert (right, down) == pytest.approx((-0.5, -math.sqrt(0.75)))


def test_the_horizon_sinks_when_the_nose_rises():
    horizon = Horizon(Attitude(math.radians(16.0), 0.0), 100.0, math.radians(32.0))
    assert horizon.line == pytest.approx(-50.0)  # half of the view, so half of the radius
    assert horizon.place(horizon.line) == pytest.approx((0.0, 50.0))  # down on the screen


def test_a_place_aside_is_to_the_right_of_who_looks():
    level = Horizon(Attitude(0.0, 0.0), 100.0, 1.0)
    assert level.place(0.0, 10.0) == pytest.approx((10.0, 0.0))
    banked = Horizon(Attitude(0.0, math.radians(90.0)), 100.0, 1.0)  # sky on the left, right is up
    assert banked.place(0.0, 10.0) == pytest.approx((0.0, -10.0))


def test_a_rim_of_earth_is_left_when_the_nose_points_up():
    horizon = Horizon(Attitude(math.radians(85.0), 0.0), 100.0, math.radians(32.0))
    assert -100.0 < horizon.line < -80.0


def test_the_ladder_has_the_lines_that_are_seen():
    horizon = Horizon(Attitude(math.radians(30.0), 0.0), 100.0, math.radians(32.0))
    assert horizon.ladder() == (20, 30, 40)
    steep = Horizon(Attitude(math.radians(88.0), 0.0), 100.0, math.radians(32.0))
    assert steep.ladder() == (70, 80, 90)
