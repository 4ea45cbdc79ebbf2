"""What docs/ros2.md says is there is there."""

import ast
import re
from pathlib import Path

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from workbench.gateways.ros2_orders import CMD_VEL, COMMAND_VELOCITY, FLIGHT_OPERATION
from workbench.gateways.ros2_publishing import CLOCK_CHANNEL, ODOMETRY
from workbench.gateways.ros_messages.conversion import conversion
from workbench.link.drone_topics import Outfit, drone_topics

PAGE = (Path(__file__).parents[2] / "docs" / "ros2.md").read_text(encoding="utf-8")
ALL = Outfit(
    rotors=4,
    fast=200.0,
    slow=10.0,
    imu=200.0,
    gps=10.0,
    lidar=10.0,
    magnetometer=50.0,
    estimate=True,
    rays=4,
    scan={"azimuths": [0.0, 0.1, 2], "elevations": [0.0, 0.1, 2], "frame": "lidar_link"},
    frames=(("world", "base_link"),),
)


def rows(heading):
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    return set(re.findall(r"^\| `(\S+)` \| `(\S+)` \|", section, re.MULTILINE))


def test_the_table_has_each_topic_with_its_type():
    made = {channel for topic in drone_topics(ALL) for channel in conversion(topic).channels}
    assert rows("Topics") == {tuple(each) for each in made | {CLOCK_CHANNEL, ODOMETRY}}


def test_the_table_of_commands_has_each_topic_that_is_read():
    assert {topic for topic, _ in rows("Fly")} == {CMD_VEL, COMMAND_VELOCITY, FLIGHT_OPERATION}


def test_the_node_publishes_what_is_read():
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    made = [
        (call.args[1].value, call.args[0].id)
        for call in ast.walk(ast.parse(code))
        if isinstance(call, ast.Call) and ast.unparse(call.func) == "node.create_publisher"
    ]
    types = {topic: name.rpartition("/")[2] for topic, name in rows("Fly")}
    assert made == [(topic, types[topic]) for topic in (CMD_VEL, FLIGHT_OPERATION)]
