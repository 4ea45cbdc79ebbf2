"""The map of the path: its frame, its trail, and what is painted."""

import math

import pytest

from workbench.gui.charts.ticks import round_step
from workbench.gui.home.path_map import PathMap
from workbench.gui.home.trail import MAX_TRAIL_POINTS, Trail
from workbench.gui.instruments.map_frame import (
    MIN_MAP_REACH_M,
    MapPlace,
    SteadyFrame,
    SteadyScale,
    round_bar,
)
from workbench.plant.worlds.outline import Outline

HOME = MapPlace(0.0, 0.0)


def test_north_is_up_and_east_is_right(shown):
    """5 m are half of the shorter side, 50 pixels."""
    shown.resize(200, 100)
    shown.begin(MapPlace(10.0, 20.0))
    shown.grab()
    reach = shown.frame.reach
    for east, north, x, y in ((0.0, 0.0, 100, 50), (reach, 0.0, 150, 50), (0.0, reach, 100, 0)):
        at = shown.position_of(10.0 + east, 20.0 + north)
        assert (at.x(), at.y()) == (pytest.approx(x, abs=2), pytest.approx(y, abs=2))


@pytest.mark.parametrize(
    ("longest", "bar"), [(0.41, 0.2), (0.5, 0.5), (7.9, 5.0), (12.0, 10.0), (800.0, 500.0)]
)
def test_the_scale_bar_is_the_longest_round_length_that_fits(longest, bar):
    assert round_bar(longest) == pytest.approx(bar)


def test_reaches_are_one_two_or_five():
    assert [round_step(each, 1) for each in (0.9, 1.0, 1.1, 2.5, 7.0, 20.0, 21.0)] == [
        1.0,
        1.0,
        2.0,
        5.0,
        10.0,
        20.0,
        50.0,
    ]


def test_a_scale_narrows_only_after_a_while():
    scale = SteadyScale(2.0)
    assert scale.take(30.0, 0.0) == 50.0
    assert scale.take(3.0, 1.0) == 50.0
    assert scale.take(30.0, 2.0) == 50.0  # and the while begins anew
    assert scale.take(3.0, 3.0) == 50.0
    assert scale.take(3.0, 5.1) == 5.0


def test_a_scale_does_not_go_back_and_forth_at_a_step():
    scale = SteadyScale(2.0)
    seen = {scale.take(wanted, time) for time, wanted in enumerate((5.1, 4.9) * 20)}
    assert seen == {10.0}


def test_a_scale_stays_where_the_content_would_fill_a_smaller_one():
    scale = SteadyScale(2.0)
    scale.take(5.1, 0.0)
    assert {scale.take(4.9, float(time)) for time in range(1, 60)} == {10.0}
    assert scale.take(3.4, 60.0) == 10.0
    assert scale.take(3.4, 62.0) == 5.0  # 3.4 is less than 0.7 of 5


def test_the_frame_holds_all_with_room_and_stays_while_it_fits():
    steady = SteadyFrame()
    steady.reset(HOME)
    assert steady.frame.reach == MIN_MAP_REACH_M
    frames = []
    for tick in range(400):
        drone = MapPlace(0.1 * tick, 0.05 * tick)
        frame = steady.take([HOME, drone], 0.1 * tick)
        frames.append(frame)
        for place in (HOME, drone):
            assert abs(place.east - frame.middle.east) <= 0.9 * frame.reach
            assert abs(place.north - frame.middle.north) <= 0.9 * frame.reach
    assert len(set(frames)) < 30  # of 400 places


def test_a_trail_has_few_points_however_long_it_is():
    trail = Trail()
    trail.add((0.1 * k, 0.05 * k, 0.0) for k in range(20_000))
    assert MAX_TRAIL_POINTS / 4 < len(trail.points) <= MAX_TRAIL_POINTS
    assert trail.points[0] == (0.0, 0.0, 0.0)
    assert trail.points[-1][1] == pytest.approx(0.05 * 19_999, abs=20.0)


def test_a_drone_that_stays_leaves_one_point():
    trail = Trail()
    trail.add((0.1 * k, 1.0, 1.0) for k in range(100))
    assert len(trail.points) == 1


def test_places_that_are_no_numbers_leave_no_trail():
    trail = Trail()
    assert not trail.add([(0.0, math.nan, 0.0), (0.1, 0.0, math.inf)])


@pytest.fixture
def shown(qtbot, workspace):
    made = PathMap(workspace.look)
    qtbot.addWidget(made)
    made.resize(200, 200)
    made.begin(HOME)
    return made


def count_colour(image, name, rows):
    return sum(image.pixelColor(x, y).name() == name for y in rows for x in range(image.width()))


def test_the_drone_is_painted_where_it_is(shown):
    shown.show_pose(MapPlace(0.0, 1.5), 0.0, [], 1.0)
    image = shown.grab().toImage()
    accent = shown.look.colour("accent").name()
    half = image.height() // 2
    north, south = range(0, half - 12), range(half + 12, image.height())
    assert count_colour(image, accent, north) > 10
    assert count_colour(image, accent, south) == 0


def test_obstacles_are_painted_where_they_stand_and_the_nearest_is_in_sight(shown):
    """One 7 m to the north: 10 m is the least round reach around it with a margin."""
    box = Outline("box", ((-1.0, 7.0), (1.0, 7.0), (1.0, 8.0), (-1.0, 8.0)), 0.0, 2.0)
    shown.begin(HOME, (box,))
    assert shown.frame.reach == 10.0
    image, bare = shown.grab().toImage(), shown.look.colour("field").name()
    # 10 px a metre: from 90 to 110 to the right, from 20 to 30 down
    for x, y, inside in ((95, 25, True), (107, 22, True), (85, 25, False), (95, 35, False)):
        assert (image.pixelColor(x, y).name() != bare) is inside, (x, y)


def painted(shown):
    """Return how many pixels of the trail's western half are neither ground nor grid."""
    image = shown.grab().toImage()
    bare = {shown.look.colour(name).name() for name in ("field", "line")}
    places = [(x, y) for x in range(25, 80) for y in range(54, 67)]
    return sum(image.pixelColor(x, y).name() not in bare for x, y in places)


def test_the_trail_thins_with_age(shown):
    east = [(0.1 * k, -1.6 + 0.02 * k, 0.8) for k in range(80)]
    shown.show_pose(MapPlace(0.4, 0.8), 0.0, east, 8.0)
    new = painted(shown)
    shown.show_pose(MapPlace(0.5, 0.8), 0.0, [], 40.0)
    recent = painted(shown)
    shown.show_pose(MapPlace(0.6, 0.8), 0.0, [], 400.0)
    old = painted(shown)
    assert new > 1.2 * recent > 1.2 * 1.2 * old > 0


def test_it_says_how_far_home_is(shown):
    shown.show_pose(MapPlace(3.0, 4.0), 0.0, [], 1.0)
    assert shown.spoken == "5.0 metres from home: 3.0 east, 4.0 north"


def test_a_place_that_is_no_number_changes_nothing(shown):
    shown.show_pose(MapPlace(1.0, 1.0), 0.0, [], 1.0)
    shown.show_pose(MapPlace(math.nan, 1.0), 0.0, [], 2.0)
    assert shown.place == MapPlace(1.0, 1.0)


def test_a_new_flight_begins_without_a_trail(shown):
    shown.show_pose(MapPlace(9.0, 9.0), 0.0, [(0.0, 5.0, 5.0)], 1.0)
    shown.begin(MapPlace(2.0, 3.0))
    assert shown.trail.points == []
    assert shown.frame.middle == MapPlace(2.0, 3.0)
    assert shown.spoken == "no position yet"
