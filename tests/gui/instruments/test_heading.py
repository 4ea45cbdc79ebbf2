"""Headings against the compass, and the tape that shows them."""

import math

import pytest

from workbench.gui.home.heading_tape import HeadingTape
from workbench.gui.instruments.heading import compass_point, direction_of, heading_of, mark_text


@pytest.mark.parametrize(
    ("yaw", "heading", "point"),
    [
        (0.0, 90.0, "E"),
        (90.0, 0.0, "N"),
        (180.0, 270.0, "W"),
        (-90.0, 180.0, "S"),
        (45.0, 45.0, "NE"),
    ],
)
def test_yaw_from_east_to_north_is_a_heading_from_north_clockwise(yaw, heading, point):
    found = heading_of(math.radians(yaw))
    assert found == pytest.approx(heading, abs=1e-9)
    assert compass_point(found) == point


def test_a_heading_is_never_a_whole_turn():
    for yaw in (math.pi / 2 + 1e-17, math.pi / 2 + 1e-15, 5 * math.pi / 2, -7 * math.pi / 2):
        assert 0.0 <= heading_of(yaw) < 360.0


def test_a_vector_to_the_south_west_has_its_direction():
    assert direction_of(-1.0, -1.0) == pytest.approx(225.0)


def test_the_tape_has_points_and_numbers():
    assert [mark_text(each) for each in (-45, 0, 30, 360, 405)] == ["NW", "N", "030", "N", "NE"]


def test_the_tape_shows_the_heading(qtbot, workspace):
    tape = HeadingTape(workspace.look)
    qtbot.addWidget(tape)
    assert tape.spoken == "no heading yet"
    tape.show_yaw(math.radians(100.0))
    assert tape.heading == pytest.approx(350.0)
    assert tape.spoken == "heading 350 degrees, N"
    tape.resize(240, 32)
    before = tape.grab().toImage()
    tape.show_yaw(math.radians(60.0))
    assert tape.grab().toImage() != before
    tape.show_yaw(math.nan)
    assert tape.spoken == "no heading yet"


def test_the_tape_is_the_same_on_both_sides_of_north(qtbot, workspace):
    tape = HeadingTape(workspace.look)
    qtbot.addWidget(tape)
    tape.resize(360, 32)
    tape.show_yaw(math.radians(90.0))
    north = tape.grab().toImage()
    tape.show_yaw(math.radians(90.0 + 360.0))
    assert tape.grab().toImage() == north
