"""Frames, clouds, depth pictures and events, against values by hand."""

import math

import numpy as np
import pytest

from workbench.gui.charts.colour_scale import colour_table, colours_of
from workbench.gui.cloud_rays import rays_from
from workbench.gui.poses import Viewpoint, poses_in_parent, poses_in_world, rotation_from_angles
from workbench.gui.signals import events_in
from workbench.gui.visualization.camera_page import (
    OUT_OF_RANGE_COLOUR,
    TOO_NEAR_COLOUR,
    depth_colours,
    depth_range,
    depth_text,
)
from workbench.gui.visualization.cloud_view import TOP_VIEWPOINT, paint_points
from workbench.gui.visualization.layouts import LAYOUT_PRESETS, fitting_board
from workbench.gui.visualization.log_bar import LogClock
from workbench.link.backplane import Published
from workbench.link.drone_topics import EVENTS_SIGNAL, PARAMETERS_SIGNAL, drone_topics
from workbench.link.signal import TopicOptions

HALF = math.sqrt(0.5)


def test_a_child_turns_with_its_parent():
    numbers = [1, 2, 3, HALF, 0, 0, HALF, *(1, 0, 0, 1, 0, 0, 0)]  # a quarter turn about z
    pairs = (("world", "body"), ("body", "arm"))
    found = poses_in_world(pairs, poses_in_parent(numbers))
    assert found["arm"].p == pytest.approx([1, 3, 3])
    assert found["arm"].roll_pitch_yaw() == pytest.approx((0, 0, math.pi / 2))


@pytest.mark.parametrize("angles", [(0.1, -0.2, 0.3), (-1.0, 0.5, 3.0), (0.0, 0.0, -2.0)])
def test_angles_make_a_matrix_and_come_back(angles):
    from workbench.gui.poses import Pose

    assert Pose(np.zeros(3), rotation_from_angles(*angles)).roll_pitch_yaw() == pytest.approx(
        angles
    )


def test_rays_go_layer_by_layer():
    about = {
        "azimuths": [0.0, math.pi / 2, 4],
        "elevations": [0.0, math.pi / 6, 2],
        "p_BS": [0.0, 0.0, 0.5],
        "R_BS": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "range": [0.1, 30.0],
    }
    rays = rays_from(about)
    points = rays.points_B(np.array([2, np.inf, -np.inf, 4, 2, np.inf, np.inf, np.inf]))
    assert points == pytest.approx(
        np.array([[2, 0, 0.5], [0, -4, 0.5], [2 * math.cos(math.pi / 6), 0, 1.5]])
    )


def test_from_the_top_x_is_up_and_y_is_left():
    seen = TOP_VIEWPOINT.project(np.array([[10.0, 0, 0], [0, 10.0, 5.0]]), 400, 400)
    assert seen[0, :2] == pytest.approx([200, 100])
    assert seen[1, :2] == pytest.approx([100, 200])
    assert seen[1, 2] < seen[0, 2]  # what is higher is nearer to the eye


def test_from_the_side_z_is_up():
    side = Viewpoint(turn=math.pi / 2, tilt=0.0, width=40.0)
    seen = side.project(np.array([[5.0, 0, 2.0]]), 400, 200)
    assert seen[0, :2] == pytest.approx([250, 80])


def test_the_nearest_point_is_on_top():
    seen = np.array([[5.0, 5.0, 1.0], [5.0, 5.0, -1.0], [900.0, 5.0, 0.0]])
    colours = np.repeat(np.array([[1], [2], [3]], dtype=np.uint8), 3, axis=1)
    picture = paint_points(seen, colours, 20, 10, 2)
    assert picture[5, 5].tolist() == [2, 2, 2, 255]
    assert np.count_nonzero(picture[:, :, 3]) == 4


def test_colours_get_brighter_all_the_way():
    table = colour_table()
    assert (np.diff(table @ [0.2126, 0.7152, 0.0722]) > -0.6).all()
    lanes = table[::5] / 255.0
    linear = np.where(lanes <= 0.04045, lanes / 12.92, ((lanes + 0.055) / 1.055) ** 2.4)
    assert np.all(np.diff(linear @ [0.2126, 0.7152, 0.0722]) > 0.0)  # relative luminance, sRGB
    ends = colours_of(np.array([-5.0, 9.0]), 0.0, 1.0, table)
    assert ends.tolist() == table[[0, -1]].tolist()


def test_depth_beyond_range_and_too_near_are_told_apart():
    depth = np.array([[1.0, 2.0, np.inf], [-np.inf, np.nan, 1.5]], dtype=np.float32)
    colours = depth_colours(depth, (1.0, 2.0), colour_table())
    assert tuple(colours[0, 2]) == OUT_OF_RANGE_COLOUR
    assert tuple(colours[1, 0]) == TOO_NEAR_COLOUR
    assert (colours[0, 0] == colour_table()[0]).all()
    assert depth_text(2.345) == "2.35\N{NO-BREAK SPACE}m"
    assert depth_text(math.inf) == "nothing within range"
    assert depth_text(-math.inf) == "nearer than it measures"


def test_the_scale_has_round_ends():
    assert depth_range(np.array([[1.23, 8.9, np.inf]])) == (0.0, 10.0)
    assert depth_range(np.full((2, 2), np.inf)) == (0.0, 1.0)


def test_events_and_parameters_are_picked_out():
    topics = {
        topic.id: topic for topic in drone_topics(TopicOptions(rotors=4, fast=100.0, slow=20.0))
    }
    found = events_in(
        [
            Published(
                2_000_000_000,
                0,
                ((EVENTS_SIGNAL.id, topics[EVENTS_SIGNAL.id].pack([1, "battery low"])),),
            ),
            Published(
                3_000_000_000,
                0,
                ((PARAMETERS_SIGNAL.id, topics[PARAMETERS_SIGNAL.id].pack(["kp_roll", 2.5])),),
            ),
        ]
    )
    assert found == [
        (2.0, "warning", "battery low"),
        (3.0, "parameter", "kp_roll = 2.5"),
    ]


def test_charts_that_suit_a_log_are_chosen():
    flight = LAYOUT_PRESETS["Flight"]
    own = {name: "m" for chart in flight for name in chart.signals}
    assert fitting_board(flight, own) == flight
    px4 = dict.fromkeys(("estimate.roll", "attitude_setpoint.roll", "rate_setpoint.w_x"), "rad")
    assert fitting_board(flight, px4) == LAYOUT_PRESETS["Autopilot's log"]
    table = {"csv.a": "m", "csv.b": "rad", "csv.c": "m", "derived.speed": "m/s"}
    charts = fitting_board(flight, table)
    assert [(chart.title, chart.signals) for chart in charts] == [
        ("csv [m]", ("csv.a", "csv.c")),
        ("csv [rad]", ("csv.b",)),
    ]
    assert fitting_board(flight, {}) == flight


def test_a_log_that_loops_goes_on_from_its_own_begin():
    """From 10 to 14 s, at twice the speed: after 3 s it is 2 s beyond the begin again."""
    clock = LogClock(10.0, 14.0)
    clock.loops, clock.speed = True, 2.0
    clock.play()
    assert clock.time == 10.0
    clock.advance(3.0)
    assert (clock.time, clock.plays) == (12.0, True)
    clock.loops = False
    clock.advance(3.0)
    assert (clock.time, clock.plays) == (14.0, False)
