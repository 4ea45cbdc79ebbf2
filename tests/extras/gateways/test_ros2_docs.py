"""What docs/ros2.md says is there is there."""

import ast
import re
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from workbench.extras.gateways.ros2_orders import ORDER_TYPES
from workbench.extras.gateways.ros2_publishing import (
    CLOCK_CHANNEL,
    DESCRIPTION_CHANNEL,
    FIXED_TRANSFORMS_CHANNEL,
    ODOMETRY_CHANNEL,
    PARAMETER_EVENTS_CHANNEL,
)
from workbench.link.drone_topics import drone_topics
from workbench.link.message_json import FLIGHT_OPERATIONS
from workbench.link.picture import PictureLayout, Pinhole
from workbench.link.ros_messages.conversion import conversion
from workbench.link.signal import TopicOptions

PAGE = (Path(__file__).parents[3] / "docs" / "ros2.md").read_text(encoding="utf-8")
ALL = TopicOptions(
    rotors=4,
    fast=200.0,
    slow=10.0,
    rates={"imu": 200.0, "gps": 10.0, "lidar": 10.0, "magnetometer": 50.0, "estimate": 200.0}
    | {"depth_camera": 5.0},
    picture=PictureLayout(Pinhole(4, 3, 4.0, 4.0, 1.5, 1.0), "camera_optical", has_colour=True),
    rays=4,
    scan={"azimuths": [0.0, 0.1, 2], "elevations": [0.0, 0.1, 2], "frame": "lidar_link"},
    frames=(("world", "base_link"),),
    joints=("arm",),
    setpoints=("position",),
    contacts=("base_link",),
    cables=("sling",),
)


def rows(heading):
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return set(re.findall(r"^\| `(\S+)` \| `(\S+)` \|", section, re.MULTILINE))


def test_the_table_has_each_topic_with_its_type():
    made = {channel for topic in drone_topics(ALL) for channel in conversion(topic).channels}
    others = {CLOCK_CHANNEL, ODOMETRY_CHANNEL, DESCRIPTION_CHANNEL, FIXED_TRANSFORMS_CHANNEL}
    others |= {PARAMETER_EVENTS_CHANNEL}
    assert rows("Topics") == {each[:2] for each in made | others}


def test_the_table_of_commands_has_each_topic_that_is_read():
    assert rows("Fly") == set(ORDER_TYPES)


def test_the_table_of_services_has_each_operation():
    section = PAGE.split("\n## Services and parameters\n")[1].split("\n## ")[0]
    named = re.findall(r"`(?:/dh_drone/)?(\w+)`", section.split("| service |")[1])
    assert set(FLIGHT_OPERATIONS) <= set(named)


def test_the_node_publishes_what_is_read():
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    made = [
        (call.args[1].value, call.args[0].id)
        for call in ast.walk(ast.parse(code))
        if isinstance(call, ast.Call) and ast.unparse(call.func) == "node.create_publisher"
    ]
    read = {(topic, name.rpartition("/")[2]) for topic, name in ORDER_TYPES}
    assert len(made) == 2 and set(made) <= read
