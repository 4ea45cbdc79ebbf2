"""The artificial horizon against rotations worked by hand."""

import math

import pytest

from workbench.gui.home.attitude_indicator import (
    Attitude,
    AttitudeIndicator,
    attitude_of,
    ladder_degrees,
)

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


@pytest.fixture
def seen(workspace, qtbot):
    """Return a function that shows an attitude, and tells what is at a place of the window.

    The place is in halves of the radius, to the right and down from the centre.
    """
    indicator = AttitudeIndicator(workspace.look)
    qtbot.addWidget(indicator)
    indicator.resize(404, 404)
    radius = (202.0 - 2.0) / 1.1
    names = {workspace.look.colour(name).rgb(): name for name in ("sky", "earth")}

    def at(nose_up, bank, right, down):
        indicator.show_attitude(Attitude(math.radians(nose_up), math.radians(bank)))
        image = indicator.grab().toImage()
        place = (round(202.0 + 0.5 * radius * each) for each in (right, down))
        return names.get(image.pixel(*place), "else")

    return at


def test_the_sky_leans_left_when_the_right_side_is_down(seen):
    """At 60 degrees, the zenith is at 60 degrees to the left of up: half up, 0.87 to the left."""
    assert seen(0.0, 60.0, -1.3 * math.sqrt(0.75), -1.3 * 0.5) == "sky"
    assert seen(0.0, 60.0, 1.3 * math.sqrt(0.75), 1.3 * 0.5) == "earth"
    assert seen(0.0, 60.0, 1.3 * 0.5, -1.3 * math.sqrt(0.75)) == "else"  # the horizon itself
    assert seen(0.0, -60.0, 1.3 * math.sqrt(0.75), -1.3 * 0.5) == "sky"


def test_the_horizon_sinks_when_the_nose_rises(seen):
    """By half of the view, 16 of 32 degrees, so by half of the radius."""
    for nose, down, expected in (
        *((0.0, -0.2, "sky"), (0.0, 0.2, "earth")),
        *((16.0, 0.9, "sky"), (16.0, 1.1, "earth")),
        *((-16.0, -1.1, "sky"), (-16.0, -0.9, "earth")),
    ):
        assert seen(nose, 0.0, 0.7, down) == expected, (nose, down)


def test_a_rim_of_earth_or_sky_is_left_when_the_nose_points_up_or_down(seen):
    assert seen(85.0, 0.0, 0.0, 1.9) == "earth"
    assert seen(85.0, 0.0, 0.6, 1.5) == "sky"
    assert seen(-85.0, 0.0, 0.2, -1.88) == "sky"


def test_the_ladder_has_the_lines_that_are_seen():
    """Within 0.62 of 32 degrees: 19.8."""
    assert ladder_degrees(math.radians(30.0)) == (15, 20, 25, 30, 35, 40, 45)
    assert ladder_degrees(math.radians(88.0)) == (70, 75, 80, 85, 90)
    assert ladder_degrees(0.0) == (-15, -10, -5, 5, 10, 15)
