"""Numbers and layouts of the topics: once published they stay, as clients were built on them."""

import dataclasses

import pytest

from workbench.link.drone_topics import Outfit, drone_topics
from workbench.link.topics import Delivery, Direction
from workbench.link.wire import LARGEST

FULL = Outfit(6, 204.8, 8.0, 204.8, 5.0, 10.0, 360, {"rows": 1}, [("W", "B"), ("B", "S")])
FULL = dataclasses.replace(FULL, magnetometer=51.2, estimate=True)
NUMBERS = {
    1: "time_data",
    2: "position_data",
    3: "velocity_data",
    4: "acceleration_data",
    5: "force_torque_data",
    6: "drone_state",
    7: "on_off_state",
    8: "command_velocity",
    9: "imu",
    10: "gps",
    11: "lidar",
    12: "lidar_cloud",
    13: "frames",
    14: "rotors",
    15: "wind",
    16: "parameters",
    17: "events",
    18: "magnetometer",
    19: "estimate",
}
SIZES = {1: 16, 2: 36, 3: 24, 4: 24, 5: 24, 6: 28, 7: 4, 8: 24, 9: 48, 10: 44, 11: 32, 15: 12}
SIZES |= {12: 8 + 4 * 360, 13: 2 * 28, 14: 2 * 6 * 4, 16: 56, 17: 244, 18: 20, 19: 84}


def test_numbers_names_and_sizes_stay():
    topics = drone_topics(FULL)
    assert {topic.id: topic.name.removeprefix("/dh_drone/") for topic in topics} == NUMBERS
    assert {topic.id: topic.packer.size for topic in topics} == SIZES


def test_the_command_has_the_limits_of_the_drone():
    [command] = [t for t in drone_topics(Outfit(4, 100, 8, limits=(5.0, 2.0, 0.3))) if t.id == 8]
    assert command.direction is Direction.BOTH
    assert [each.high for each in command.fields] == [None, 15, 5.0, 5.0, 2.0, 0.3]
    assert [each.low for each in command.fields] == [None, 1, -5.0, -5.0, -2.0, -0.3]


def test_only_the_command_may_be_sent_by_a_client():
    assert [t.id for t in drone_topics(FULL) if t.direction is not Direction.OUT] == [8]


def test_events_and_parameters_count_each():
    assert [t.id for t in drone_topics(FULL) if t.delivery is Delivery.EVENT] == [16, 17]


@pytest.mark.parametrize(
    ("without", "gone"),
    [
        *(("imu", {9}), ("gps", {10}), ("lidar", {11, 12}), ("frames", {13})),
        *(("magnetometer", {18}), ("estimate", {19})),
    ],
)
def test_a_drone_without_a_sensor_has_not_its_topic(without, gone):
    values = {"imu": 200.0, "gps": 5.0, "lidar": 10.0, "frames": [("W", "B")]}
    values |= {"magnetometer": 50.0, "estimate": 1.0}
    values[without] = [] if without == "frames" else 0.0
    topics = drone_topics(Outfit(4, 200, 8, rays=8, **values))
    assert {topic.id for topic in topics} == set(NUMBERS) - gone


def test_names_differ_and_every_number_has_a_unit():
    for topic in drone_topics(FULL):
        names = [each.name for each in topic.fields]
        assert len(set(names)) == len(names)
        assert all(each.unit or each.type == "char" or topic.id == 16 for each in topic.fields)
        assert topic.packer.size <= LARGEST


def test_the_largest_cloud_fits_a_frame():
    topics = drone_topics(Outfit(4, 200, 8, lidar=10.0, rays=16_000))
    assert max(topic.packer.size for topic in topics) <= LARGEST
