"""Numbers and layouts of the topics: once published they stay, as clients were built on them."""

import dataclasses

import pytest

from workbench.link.drone_topics import drone_topics
from workbench.link.picture import PictureLayout, Pinhole, picture_stride
from workbench.link.signal import TopicOptions
from workbench.link.topics import Delivery, TopicDirection
from workbench.link.wire import MAX_PAYLOAD_BYTES

FULL = TopicOptions(
    6,
    204.8,
    8.0,
    rates={"imu": 204.8, "gps": 5.0, "lidar": 10.0, "magnetometer": 51.2, "estimate": 204.8}
    | {"depth_camera": 5.0},
    rays=360,
    scan={"rows": 1},
    frames=[("W", "B"), ("B", "S")],
    joints=["arm"],
    picture=PictureLayout(Pinhole(7, 1, 5.0, 5.0, 3.0, 0.0), "optical", has_colour=True),
    setpoints=["position"],
    contacts=["body", "foot"],
    cables=["sling"],
)
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
    20: "battery",
    21: "joint_states",
    22: "depth_image",
    23: "colour_image",
    24: "joint_setpoints",
    25: "contact_forces",
    26: "tensions",
}
SIZES = {1: 16, 2: 36, 3: 24, 4: 24, 5: 24, 6: 28, 7: 4, 8: 24, 9: 48, 10: 44, 11: 32, 15: 12}
SIZES |= {
    12: 8 + 4 * 360,
    13: 2 * 28,
    14: 2 * 6 * 4,
    16: 56,
    17: 244,
    18: 20,
    19: 84,
    20: 16,
    21: 8,
    22: 8 + 16,  # 14 bytes of pixels, in whole numbers of four
    23: 8 + 24,  # 21 bytes
    24: 4,
    25: 2 * 12,
    26: 4,
}


def test_numbers_names_and_sizes_stay():
    topics = drone_topics(FULL)
    assert {topic.id: topic.name.removeprefix("/dh_drone/") for topic in topics} == NUMBERS
    assert {topic.id: topic.packer.size for topic in topics} == SIZES


def test_the_command_has_the_limits_of_the_drone():
    [command] = [
        t for t in drone_topics(TopicOptions(4, 100, 8, limits=(5.0, 2.0, 0.3))) if t.id == 8
    ]
    assert command.direction is TopicDirection.BOTH
    assert [each.high for each in command.fields] == [None, 15, 5.0, 5.0, 2.0, 0.3]
    assert [each.low for each in command.fields] == [None, 1, -5.0, -5.0, -2.0, -0.3]


def test_only_the_command_may_be_sent_by_a_client():
    assert [t.id for t in drone_topics(FULL) if t.direction is not TopicDirection.OUT] == [8]


def test_events_and_parameters_count_each():
    assert [t.id for t in drone_topics(FULL) if t.delivery is Delivery.EVENT] == [16, 17]


@pytest.mark.parametrize(
    ("without", "gone"),
    [
        *(("imu", {9}), ("gps", {10}), ("lidar", {11, 12}), ("frames", {13})),
        *(("magnetometer", {18}), ("estimate", {19}), ("depth_camera", {22, 23})),
    ],
)
def test_a_drone_without_a_sensor_has_not_its_topic(without, gone):
    rates = {kind: rate for kind, rate in FULL.rates.items() if kind != without}
    frames = () if without == "frames" else FULL.frames
    topics = drone_topics(dataclasses.replace(FULL, rates=rates, frames=frames))
    assert {topic.id for topic in topics} == set(NUMBERS) - gone


def test_names_differ_and_every_number_has_a_unit():
    for topic in drone_topics(FULL):
        names = [each.name for each in topic.fields]
        assert len(set(names)) == len(names)
        assert all(each.unit or each.type == "char" or topic.id == 16 for each in topic.fields)
        assert topic.packer.size <= MAX_PAYLOAD_BYTES


def test_the_largest_cloud_fits_a_frame():
    topics = drone_topics(TopicOptions(4, 200, 8, rates={"lidar": 10.0}, rays=16_000))
    assert max(topic.packer.size for topic in topics) <= MAX_PAYLOAD_BYTES


def test_pictures_fit_a_frame_in_as_many_pixels_as_there_is_room(case):
    """65,536 bytes with the stamp: 21,842 pixels of three bytes, in whole numbers of four."""
    for width, height, stride in [
        (1, 1, 1),
        (21_842, 1, 1),
        (21_843, 1, 2),
        (320, 240, 2),
        (640, 480, 4),
        (1920, 1080, 10),
    ]:
        with case(width, height):
            assert picture_stride(width, height) == stride
            pinhole = Pinhole(width, height, 1.0, 1.0, 0.0, 0.0).thinned(stride)
            assert pinhole[:2] == (len(range(0, width, stride)), len(range(0, height, stride)))
            layout = PictureLayout(pinhole, "optical", True)
            options = TopicOptions(4, 200, 8, rates={"depth_camera": 5.0}, picture=layout)
            assert max(each.packer.size for each in drone_topics(options)) <= MAX_PAYLOAD_BYTES


def test_a_camera_without_colour_has_only_depth():
    assert FULL.picture
    grey = dataclasses.replace(FULL, picture=FULL.picture._replace(has_colour=False))
    assert {topic.id for topic in drone_topics(grey)} == set(NUMBERS) - {23}
