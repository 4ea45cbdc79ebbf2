"""Convert frames of the link to ROS 2 messages: their topics and types.

Axes and names follow REP-103 and REP-105: x east, y north, z up in `world`, x forward, y left, z up
in the body; quaternions are x, y, z, w. Time is simulated time.
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
"""Number of values of a field from which on it is read as a numpy array."""


class Channel(NamedTuple):
    """A ROS 2 topic, and the type of its messages, such as std_msgs/msg/Header."""

    topic: str
    type: str


@dataclass(frozen=True)
class Conversion:
    """The conversion of a topic of the link.

    Attributes:
        topic: of the link.
        made: ROS 2 topics, and functions that make their messages from a frame.
    """

    topic: Topic
    made: tuple[tuple[Channel, Make], ...]

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Topics and types of the ROS 2 messages."""
        return tuple(channel for channel, _ in self.made)

    def messages(self, t_ns: int, payload: bytes) -> list[tuple[Channel, Values]]:
        """Return the messages of a frame: their channels, and their values by field.

        Values are numbers, texts, bytes, tuples, and mappings for nested messages.

        Args:
            t_ns: simulated time in the frame's header [ns].
            payload: of the frame.

        Raises:
            ValueError: if the payload does not have the size of the topic.
        """
        values = self.read(payload)
        return [(channel, make(t_ns, values)) for channel, make in self.made]

    def read(self, payload: bytes) -> Values:
        """Return the fields of a payload by name, as the functions in `made` need them.

        Raises:
            ValueError: if the payload does not have the size of the topic.
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
        """Names and indices of the fields, for faster reading; empty if a field is a text."""
        at, places = 0, []
        for field in self.topic.fields:
            if field.type == "char":
                return ()
            places.append((field.name, at if field.count == 1 else slice(at, at + field.count)))
            at += field.count
        return tuple(places)

    @cached_property
    def _records(self) -> np.dtype | None:
        """The dtype of a payload with thousands of numbers, which numpy reads faster, else None."""
        if all(field.count < MANY for field in self.topic.fields):
            return None
        return np.dtype(
            [(each.name, f"<{CODES[each.type]}", _shape(each)) for each in self.topic.fields]
        )


def _shape(field: Field) -> tuple[int, ...]:
    """Return the shape of a field in a dtype."""
    return () if field.count == 1 else (field.count,)


def conversion(topic: Topic) -> Conversion:
    """Return the conversion of a topic of the link; an unknown topic has no messages."""
    made = []
    if topic.id in _OURS:
        made.append((Channel(topic.name, f"dh_drone_msgs/msg/{_OURS[topic.id]}"), _ours(topic)))
    for name, kind, maker in _STANDARD.get(topic.id, ()):
        made.append((Channel(name, kind), maker(topic)))
    return Conversion(topic, tuple(made))


def _ours(topic: Topic) -> Make:
    """Return the maker of a message of our own type, with the field names of the link."""
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
"""Our own message types by topic number."""

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
"""Standard ROS 2 topics and types made from a topic, by topic number."""
