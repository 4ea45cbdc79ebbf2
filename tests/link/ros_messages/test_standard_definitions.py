"""Standard messages against rosbags, which has ROS 2's definitions and a decoder of its own."""

import dataclasses

import numpy as np
import pytest
from rosbags import typesys as rosbags

from workbench.link import drone_topics as numbers
from workbench.link.drone_topics import drone_signals, drone_topics
from workbench.link.picture import PictureLayout, Pinhole
from workbench.link.ros_messages.cdr import encode
from workbench.link.ros_messages.conversion import conversion
from workbench.link.ros_messages.library import included, schema_text
from workbench.link.signal import ROS_PACKAGE, TopicOptions

STORES = [rosbags.Stores.ROS2_HUMBLE, rosbags.Stores.ROS2_JAZZY]
OPTIONS = TopicOptions(
    rotors=4,
    fast=128.0,
    slow=21.0,
    rates={"imu": 200.0, "gps": 10.0, "lidar": 10.0, "magnetometer": 50.0, "estimate": 128.0}
    | {"depth_camera": 5.0},
    picture=PictureLayout(Pinhole(3, 2, 4.0, 5.0, 1.0, 0.5), "camera_optical", True),
    rays=2,
    scan={"frame": "lidar_link", "azimuths": [0.0, 1.0, 2], "elevations": [0.0, 0.0, 1]},
    frames=(("world", "base_link"), ("base_link", "imu_link")),
    moving=("base_link",),
    joints=("arm",),
)
STANDARD = sorted(
    {
        each.name
        for row in drone_signals()
        for channel in row.channels
        for each in included(channel.type)
        if not each.name.startswith(ROS_PACKAGE)
    }
)


@pytest.mark.parametrize("store", STORES, ids=lambda each: each.value)
def test_each_standard_definition_has_the_type_hash_of_ros(store, case):
    """RIHS01 of REP-2016 covers names and types of all fields, nested ones, too."""
    theirs = rosbags.get_typestore(store)
    assert "sensor_msgs/msg/BatteryState" in STANDARD and "tf2_msgs/msg/TFMessage" in STANDARD
    for name in STANDARD:
        with case(name):
            ours = rosbags.get_typestore(rosbags.Stores.EMPTY)
            ours.register(rosbags.get_types_from_msg(schema_text(name), name))
            assert ours.hash_rihs01(name) == theirs.hash_rihs01(name)


def test_each_standard_message_is_read_by_rosbags(case):
    """Field by field, from values that are all different."""
    store = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
    seen = set()
    for topic in drone_topics(OPTIONS):
        if topic.id == numbers.FRAMES_SIGNAL.id:
            values = [[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0] * 2]
        else:
            values = [
                "x" if f.type == "char" else 1 if f.count == 1 else [*range(1, f.count + 1)]
                for f in topic.fields
            ]
        for channel, message in conversion(topic).messages(7_000_000_002, topic.pack(values)):
            if channel.type.startswith(ROS_PACKAGE):
                continue
            with case(channel):
                read = store.deserialize_cdr(encode(channel.type, message), channel.type)
                assert_same(read, message)
                seen.add(channel.type)
    assert {name.rpartition("/")[2] for name in seen} == {
        *("PoseStamped", "TwistStamped", "Odometry", "Imu", "NavSatFix", "MagneticField"),
        *("PointCloud2", "BatteryState", "JointState", "TFMessage", "Image", "CameraInfo"),
    }


def assert_same(read, message):
    """Compare a message of rosbags with the values that were encoded."""
    if dataclasses.is_dataclass(read):
        for name, value in message.items():
            assert_same(getattr(read, name), value)
    elif isinstance(read, np.ndarray):
        sent = np.frombuffer(message, np.uint8) if isinstance(message, bytes) else message
        assert read == pytest.approx(np.asarray(sent), nan_ok=True)
    elif isinstance(read, list):
        assert len(read) == len(message)
        for one, other in zip(read, message, strict=True):
            assert_same(one, other)
    elif isinstance(read, float):
        assert read == pytest.approx(message, nan_ok=True)
    else:
        assert read == message
