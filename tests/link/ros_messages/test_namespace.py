"""The namespace of a vehicle, by the rules of ROS 2 for names (design.ros2.org, topic names)."""

import re

import pytest

from workbench.link.ros_messages.namespace import in_namespace, link_topic, ros_namespace


@pytest.mark.parametrize(
    ("vehicle", "namespace"),
    [
        ("dh_drone", "dh_drone"),
        ("x500_gimbal", "x500_gimbal"),
        ("3DR Iris+", "drone_3DR_Iris"),
        ("my__drone", "my_drone"),
        ("_hidden", "hidden"),
        ("", "drone"),
        ("无人机", "drone"),
        ("a/b:c", "a_b_c"),
    ],
)
def test_each_vehicle_has_a_name_that_ros_allows(vehicle, namespace):
    assert ros_namespace(vehicle) == namespace
    assert re.fullmatch(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", ros_namespace(vehicle))


def test_topics_of_the_drone_move_and_those_of_all_stay():
    assert in_namespace("/dh_drone/imu", "iris") == "/iris/imu"
    assert in_namespace("/tf", "iris") == "/tf"
    assert link_topic("/iris/imu", "iris") == "/dh_drone/imu"
    assert link_topic("/dh_drone/imu", "iris") == "/dh_drone/imu"  # of an earlier version
    assert link_topic("/clock", "iris") == "/clock"
