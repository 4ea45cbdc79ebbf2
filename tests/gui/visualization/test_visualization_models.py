"""Frames, clouds, depth pictures and events, against values by hand."""

import math

import numpy as np
import pytest

from workbench.gui.charts.colour_scale import colour_table, colour_words, colours_of
from workbench.gui.cloud_rays import rays_from
from workbench.gui.poses import Viewpoint, poses_in_parent, poses_in_world, turned
from workbench.gui.signals import events_in
from workbench.gui.visualization.sensor_pages import (
    BEYOND,
    TOO_NEAR,
    TOP,
    depth_colours,
    depth_text,
    paint_points,
    scale_of,
)
from workbench.link.backplane import Published
from workbench.link.drone_topics import EVENTS, PARAMETERS, Outfit, drone_topics

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

    assert Pose(np.zeros(3), turned(*angles)).roll_pitch_yaw() == pytest.approx(angles)


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
    seen = TOP.project(np.array([[10.0, 0, 0], [0, 10.0, 5.0]]), 400, 400)
    assert seen[0, :2] == pytest.approx([200, 100])
    assert seen[1, :2] == pytest.approx([100, 200])
    assert seen[1, 2] < seen[0, 2]  # what is higher is nearer to the eye


def test_from_the_side_z_is_up():
    side = Viewpoint(turn=math.pi / 2, tilt=0.0, width=40.0)
    seen = side.project(np.array([[5.0, 0, 2.0]]), 400, 200)
    assert seen[0, :2] == pytest.approx([250, 80])


def test_the_nearest_point_is_on_top():
    seen = np.array([[5.0, 5.0, 1.0], [5.0, 5.0, -1.0], [900.0, 5.0, 0.0]])
    picture = paint_points(seen, np.array([1, 2, 3], dtype=np.uint32), 0, 20, 10, 2)
    assert picture[5, 5] == 2
    assert np.count_nonzero(picture) == 4


def test_colours_get_brighter_all_the_way():
    table = colour_table()
    light = [0.2126 * (c >> 16 & 255) + 0.7152 * (c >> 8 & 255) + 0.0722 * (c & 255) for c in table]
    assert (np.diff(np.array(light, dtype=float)) > -0.6).all()
    lanes = np.stack([table >> 16 & 255, table >> 8 & 255, table & 255], axis=-1)[::5] / 255.0
    linear = np.where(lanes <= 0.04045, lanes / 12.92, ((lanes + 0.055) / 1.055) ** 2.4)
    assert np.all(np.diff(linear @ [0.2126, 0.7152, 0.0722]) > 0.0)  # relative luminance, sRGB
    assert colours_of(np.array([-5.0, 9.0]), 0.0, 1.0, table).tolist() == [table[0], table[-1]]


def test_depth_beyond_range_and_too_near_are_told_apart():
    depth = np.array([[1.0, 2.0, np.inf], [-np.inf, np.nan, 1.5]], dtype=np.float32)
    colours = depth_colours(depth, (1.0, 2.0), colour_table())
    assert colours[0, 2] == BEYOND
    assert colours[1, 0] == TOO_NEAR
    assert colours[0, 0] == colour_table()[0]
    assert depth_text(2.345) == "2.35 m"
    assert depth_text(math.inf) == "nothing within range"
    assert depth_text(-math.inf) == "nearer than it measures"


def test_the_scale_has_round_ends():
    assert scale_of(np.array([[1.23, 8.9, np.inf]])) == (0.0, 10.0)
    assert scale_of(np.full((2, 2), np.inf)) == (0.0, 1.0)


def test_bytes_become_colours():
    assert colour_words(np.array([[[1, 2, 3]]], dtype=np.uint8)).tolist() == [[0xFF010203]]


def test_events_and_parameters_are_picked_out():
    topics = {topic.id: topic for topic in drone_topics(Outfit(rotors=4, fast=100.0, slow=20.0))}
    found = events_in(
        [
            Published(2_000_000_000, 0, ((EVENTS, topics[EVENTS].pack([1, "battery low"])),)),
            Published(3_000_000_000, 0, ((PARAMETERS, topics[PARAMETERS].pack(["kp_roll", 2.5])),)),
        ]
    )
    assert found == [
        (2.0, "warning", "battery low"),
        (3.0, "parameter", "kp_roll = 2.5"),
    ]
