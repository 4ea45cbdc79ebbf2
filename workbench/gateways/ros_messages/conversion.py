"""Frames of the link as messages of ROS 2: which topics they become, of which types.

Axes and names follow REP-103 and REP-105: x east, y north, z up in `world`, x forward, y left, z up
in the body; quaternions go x, y, z, w. Time is that of the simulation.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from workbench.gateways.ros_messages import making
from workbench.gateways.ros_messages.making import WORLD, Make, header
from workbench.link import drone_topics as numbers
from workbench.link.topics import CODES, PREFIX, Field, Topic

Values = Mapping[str, Any]


MANY = 256
"""From so many numbers of one field on, they are an array."""


class Channel(NamedTuple):
    """A topic of ROS 2, and the type of its messages, as std_msgs/msg/Header."""

    topic: str
    type: str


@dataclass(frozen=True)
class Conversion:
    """What a topic of the link becomes.

    Attributes:
        topic: of the link.
        made: of a frame of it: topics of ROS 2, and what makes their messages.
    """

    topic: Topic
    made: tuple[tuple[Channel, Make], ...]

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Topics and types of the messages that it makes."""
        return tuple(channel for channel, _ in self.made)

    def messages(self, t_ns: int, payload: bytes) -> list[tuple[Channel, Values]]:
        """Return the messages of a frame: their channels, and their values by field.

        Values are numbers, texts, bytes, tuples, and mappings for messages within.

        Args:
            t_ns: simulated time in the frame's header [ns].
            payload: of the frame.

        Raises:
            ValueError: if the payload has not just the topic's size.
        """
        values = self.read(payload)
        return [(channel, make(t_ns, values)) for channel, make in self.made]

    def read(self, payload: bytes) -> Values:
        """Return the fields of a payload by name, as `made` wants them.

        Raises:
            ValueError: if the payload has not just the topic's size.
        """
        if len(payload) != self.topic.packer.size or not self._places:
            return self.topic.unpack(payload)
        if self._records is not None:
            record = np.frombuffer(payload, self._records)[0]
            return {name: record[name] for name, _ in self._places}
        flat = self.topic.packer.unpack(payload)
        return {name: flat[place] for name, place in self._places}

    @cached_property
    def _places(self) -> tuple[tuple[str, int | slice], ...]:
        """Names and places of the numbers, which are read faster so; none where there is a text."""
        at, places = 0, []
        for field in self.topic.fields:
            if field.type == "char":
                return ()
            places.append((field.name, at if field.count == 1 else slice(at, at + field.count)))
            at += field.count
        return tuple(places)

    @cached_property
    def _records(self) -> np.dtype | None:
        """What numpy calls a payload with thousands of numbers, which it reads faster."""
        if all(field.count < MANY for field in self.topic.fields):
            return None
        return np.dtype(
            [(each.name, f"<{CODES[each.type]}", _shape(each)) for each in self.topic.fields]
        )


def _shape(field: Field) -> tuple[int, ...]:
    """Return what numpy calls the shape of a field."""
    return () if field.count == 1 else (field.count,)


def conversion(topic: Topic) -> Conversion:
    """Return what a topic of the link becomes; a topic that is not known here becomes nothing."""
    made = []
    if topic.id in _OURS:
        made.append((Channel(topic.name, f"dh_drone_msgs/msg/{_OURS[topic.id]}"), _ours(topic)))
    for name, kind, maker in _STANDARD.get(topic.id, ()):
        made.append((Channel(name, kind), maker(topic)))
    return Conversion(topic, tuple(made))


def _ours(topic: Topic) -> Make:
    """Return what makes a message of ours, whose fields are named as the link's."""
    if not any(field.name == "stamp" for field in topic.fields):
        return lambda t_ns, values: {"header": header(t_ns, WORLD), **values}
    head = making.sensor_header(topic)
    return lambda t_ns, values: {"header": head(values), **values}


_OURS = {
    numbers.TIME: "DroneTime",
    numbers.POSITION: "PositionData",
    numbers.VELOCITY: "VelocityData",
    numbers.ACCELERATION: "AccelerationData",
    numbers.FORCE_TORQUE: "ForceTorqueData",
    numbers.DRONE_STATE: "DroneState",
    numbers.ON_OFF: "OnOffState",
    numbers.COMMAND: "CommandVelocity",
    numbers.LIDAR: "LidarSummary",
    numbers.ROTORS: "RotorData",
    numbers.WIND: "WindData",
    numbers.PARAMETERS: "ParameterChange",
    numbers.EVENTS: "Event",
    numbers.ESTIMATE: "EstimateData",
}
"""Our own types, by the number of their topic."""

_STANDARD: Mapping[int, tuple[tuple[str, str, Callable[[Topic], Make]], ...]] = {
    numbers.POSITION: ((f"{PREFIX}pose", "geometry_msgs/msg/PoseStamped", making.pose),),
    numbers.VELOCITY: ((f"{PREFIX}twist", "geometry_msgs/msg/TwistStamped", making.twist),),
    numbers.IMU: ((f"{PREFIX}imu", "sensor_msgs/msg/Imu", making.imu),),
    numbers.GPS: (
        (f"{PREFIX}gps", "sensor_msgs/msg/NavSatFix", making.fix),
        (f"{PREFIX}gps_velocity", "geometry_msgs/msg/TwistStamped", making.fix_velocity),
    ),
    numbers.LIDAR_CLOUD: ((f"{PREFIX}lidar_cloud", "sensor_msgs/msg/PointCloud2", making.cloud),),
    numbers.MAGNETOMETER: (
        (f"{PREFIX}magnetometer", "sensor_msgs/msg/MagneticField", making.magnetic_field),
    ),
    numbers.ESTIMATE: (
        (f"{PREFIX}estimated_odometry", "nav_msgs/msg/Odometry", making.estimated_odometry),
    ),
    numbers.FRAMES: (("/tf", "tf2_msgs/msg/TFMessage", making.transforms),),
}
"""Topics and types of ROS 2 that are made of a topic, by its number."""
