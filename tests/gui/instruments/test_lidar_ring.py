"""The ring of a lidar: rays worked by hand, and what is painted of them."""

import math

import numpy as np
import pytest

from workbench.gui.home.lidar_card import LidarRing
from workbench.gui.instruments.ring_scan import (
    EMPTY_RING,
    RING_SECTORS,
    BearingRing,
    RingScan,
    sector_bearings,
    side_of,
)
from workbench.gui.poses import rotation_of
from workbench.link.topics import Field, Topic, TopicDirection

LEVEL = (0.0, 0.0, -1.0)
COLUMNS = 4
"""Rays ahead, left, behind and right."""


def cloud_topic(elevations=(0.0, 0.0, 1), p_BS=(0.0, 0.0, 0.0), R_BS=None, columns=COLUMNS):
    return Topic(
        12,
        "/dh_drone/lidar_cloud",
        TopicDirection.OUT,
        10.0,
        (
            Field("stamp", "int64", "ns"),
            Field("ranges", "float32", "m", "S", columns * elevations[2]),
        ),
        about={
            "azimuths": [0.0, 2.0 * math.pi / columns, columns],
            "elevations": list(elevations),
            "p_BS": list(p_BS),
            "R_BS": R_BS or [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            "range": [0.3, 30.0],
        },
    )


def ring_of(topic, ranges, height=10.0, down_B=LEVEL):
    return RingScan(topic).ring(topic.pack([0, ranges]), height, down_B)


def test_ranges_stand_at_their_bearings():
    ring = ring_of(cloud_topic(), [5.0, 2.0, math.inf, 7.0])
    quarter = RING_SECTORS // 4
    assert ring.distances[0] == pytest.approx(5.0)
    assert ring.distances[quarter] == pytest.approx(2.0)  # left
    assert math.isinf(ring.distances[2 * quarter])
    assert ring.distances[3 * quarter] == pytest.approx(7.0)
    assert ring.nearest == pytest.approx(2.0)
    assert ring.bearing == pytest.approx(math.pi / 2)
    assert np.isfinite(ring.distances).sum() == 3


def test_a_lidar_mounted_to_the_left_looks_there():
    # Sensor x is body y: the ray ahead of the sensor goes to the left of the drone.
    turned = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    ring = ring_of(cloud_topic(R_BS=turned), [3.0, math.inf, math.inf, math.inf])
    assert ring.bearing == pytest.approx(math.pi / 2)
    assert side_of(ring.bearing) == "left"


def test_of_several_layers_the_nearest_counts_and_distances_are_level():
    up = math.radians(60.0)
    topic = cloud_topic(elevations=(0.0, up, 2))
    ring = ring_of(topic, [9.0, 9.0, 9.0, 9.0, 4.0, 30.0, 30.0, 30.0])
    assert ring.nearest == pytest.approx(4.0)
    assert ring.elevation == pytest.approx(up)
    assert ring.distances[0] == pytest.approx(2.0)  # 4 m at 60 degrees
    assert ring.distances[RING_SECTORS // 4] == pytest.approx(9.0)


def test_the_ground_is_no_obstacle():
    down = math.radians(-30.0)
    topic = cloud_topic(elevations=(down, -down, 2))
    # 2 m up, a ray 30 degrees down meets the ground after 4 m; after 3 m it is still 0.5 m up.
    ranges = [4.0, 3.0, 4.0, 4.0] + [math.inf] * 4
    ring = ring_of(topic, ranges, height=2.0)
    assert ring.nearest == pytest.approx(3.0)
    assert np.isfinite(ring.distances).sum() == 1


def test_the_ground_is_as_far_from_a_lidar_as_that_is_above_it():
    # On a mast of 0.5 m, 2 m up: the ground is 5 m along a ray 30 degrees down, and not at 4 m.
    down = math.radians(-30.0)
    topic = cloud_topic(elevations=(down, -down, 2), p_BS=(0.2, 0.0, 0.5))
    ring = ring_of(topic, [5.0, 4.0, 5.0, 5.0] + [math.inf] * 4, height=2.0)
    assert ring.nearest == pytest.approx(4.0)
    assert np.isfinite(ring.distances).sum() == 1


def test_the_ground_is_found_in_a_bank():
    # Right side down by 30 degrees: the ray to the right goes down, from 2 m it is 4 m long.
    down_B = (0.0, -0.5, -math.sqrt(0.75))
    ring = ring_of(cloud_topic(), [4.0, 4.0, 4.0, 4.0], height=2.0, down_B=down_B)
    assert math.isinf(ring.distances[3 * RING_SECTORS // 4])
    assert np.isfinite(ring.distances).sum() == 3


def test_what_is_nearer_than_the_lidar_can_tell_is_at_its_least_range():
    ring = ring_of(cloud_topic(), [-math.inf, 2.0, 2.0, 2.0])
    assert ring.nearest == pytest.approx(0.3)


def test_a_scan_without_a_return_is_empty():
    assert ring_of(cloud_topic(), [math.inf] * 4) is EMPTY_RING


def test_sides_are_said_in_words():
    said = [side_of(math.radians(each)) for each in (0, 45, 90, 135, 180, -135, -90, -45)]
    assert said == [
        "ahead",
        "ahead left",
        "left",
        "behind left",
        "behind",
        "behind right",
        "right",
        "ahead right",
    ]


def test_the_ring_of_a_flight_finds_what_the_snapshot_says_is_nearest(canned):
    topics = {topic.id: topic for topic in canned.views[0].topics}
    view = canned.views[-1]
    clouds = [
        payload
        for published in canned.published
        for each in published
        for number, payload in each.payloads
        if number == 12
    ]
    now = view.snapshot
    ring = RingScan(topics[12]).ring(clouds[-1], now.p_WB[2], -rotation_of(now.q_WB)[2])
    assert ring.nearest >= now.lidar.nearest - 1e-3  # which may be the ground
    assert np.isfinite(ring.distances).sum() > RING_SECTORS / 2  # there is a room around


@pytest.fixture
def shown(qtbot, workspace):
    made = LidarRing(workspace.look)
    qtbot.addWidget(made)
    made.resize(220, 220)
    return made


def wall(bearing, distance):
    """Return a ring with one obstacle that is three sectors wide."""
    distances = np.full(RING_SECTORS, np.inf)
    index = round(bearing / (2.0 * math.pi) * RING_SECTORS)
    for each in (index - 1, index, index + 1):
        distances[each % RING_SECTORS] = distance
    return BearingRing(distances, distance, bearing, 0.0)


def ink_at(shown, x, y):
    """Return whether there is ink near a place from the middle, to the right and down."""
    image = shown.grab().toImage()
    ink = shown.look.colour("ink").name()
    near = [(x + i, y + j) for i in range(-3, 4) for j in range(-3, 4)]
    return any(
        image.pixelColor(image.width() // 2 + i, image.height() // 2 + j).name() == ink
        for i, j in near
    )


def test_what_is_on_the_left_is_painted_on_the_left(shown):
    # 4 m of a ring that reaches 5 m and is 108.5 pixels wide, beside the mark of the nearest.
    ring = wall(math.radians(90.0), 2.4)
    far = wall(math.radians(90.0), 2.4).distances.copy()
    far[RING_SECTORS // 4 + 10 : RING_SECTORS // 4 + 13] = 4.0
    shown.show_ring(BearingRing(far, ring.nearest, ring.bearing, 0.0), False, 0.0)
    assert shown.reach == 5.0
    angle = math.radians(90.0 + 33.0)
    x, y = -math.sin(angle) * 4.0 / 5.0 * 108.5, -math.cos(angle) * 4.0 / 5.0 * 108.5
    assert ink_at(shown, round(x), round(y))
    assert not ink_at(shown, round(-x), round(y))


def test_it_reaches_farther_at_once_and_less_far_after_a_while(shown):
    shown.show_ring(wall(0.0, 12.0), False, 0.0)
    assert shown.reach == 50.0
    shown.show_ring(wall(0.0, 2.0), False, 0.1)
    assert shown.reach == 50.0
    shown.show_ring(wall(0.0, 1.9), False, 3.0)
    assert shown.reach == 10.0


def test_a_warning_is_said_and_has_a_shape(shown):
    ring = wall(math.radians(-90.0), 1.2)
    shown.show_ring(ring, False, 0.0)
    calm = shown.grab().toImage()
    shown.show_ring(ring, True, 0.1)
    assert shown.spoken == "nearest 1.2 metres right, near"
    assert shown.grab().toImage() != calm


def test_the_same_scan_is_not_painted_again(shown, monkeypatch):
    ring = wall(0.0, 2.0)
    shown.show_ring(ring, False, 0.0)
    updates = []
    monkeypatch.setattr(shown, "update", lambda *_: updates.append(1))
    shown.show_ring(ring, False, 0.1)
    assert not updates


def test_the_sectors_begin_ahead():
    assert sector_bearings()[0] == 0.0
