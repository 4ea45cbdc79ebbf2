"""Publish the topics of the drone as ROS 2 topics."""

from collections.abc import Iterable
from typing import Any, cast

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_dds import (
    MessageType,
    dds_topic,
    endpoint_qos,
    latched_qos,
    message_type,
)
from workbench.extras.gateways.ros2_definitions import (
    CLOCK_TYPE,
    PARAMETER_EVENT_TYPE,
    STRING_TYPE,
)
from workbench.extras.gateways.ros2_parameters import NODE_NAME, parameter_event
from workbench.link.drone_topics import (
    CLOCK_SIGNAL,
    FRAMES_SIGNAL,
    PARAMETERS_SIGNAL,
    POSITION_SIGNAL,
    VELOCITY_SIGNAL,
)
from workbench.link.ros_messages.conversion import Conversion, conversion
from workbench.link.ros_messages.making import ROS_BODY_FRAME, odometry, time_message
from workbench.link.ros_messages.namespace import in_namespace
from workbench.link.ros_messages.transforms import (
    base_frame,
    fixed_transforms_maker,
    moving_transforms_maker,
)
from workbench.link.sample import Sample
from workbench.link.signal import RosChannel
from workbench.link.topics import PREFIX, Topic, TopicDirection

ODOMETRY_CHANNEL = RosChannel(f"{PREFIX}odometry", "nav_msgs/msg/Odometry")
CLOCK_CHANNEL = RosChannel("/clock", CLOCK_TYPE)
PARAMETER_EVENTS_CHANNEL = RosChannel("/parameter_events", PARAMETER_EVENT_TYPE)
DESCRIPTION_CHANNEL = RosChannel(f"{PREFIX}robot_description", STRING_TYPE)
_TRANSFORMS_TYPE = "tf2_msgs/msg/TFMessage"
MOVING_TRANSFORMS_CHANNEL = RosChannel("/tf", _TRANSFORMS_TYPE, moving_transforms_maker)
FIXED_TRANSFORMS_CHANNEL = RosChannel("/tf_static", _TRANSFORMS_TYPE, fixed_transforms_maker)
LATCHED_CHANNELS = (FIXED_TRANSFORMS_CHANNEL, DESCRIPTION_CHANNEL)
"""Channels with a single message, which later readers get, too."""


class RosPublisher:
    """Writes samples of the link as ROS 2 messages.

    Args:
        participant: of the domain.
        namespace: of the drone, without slashes.

    Attributes:
        written: number of messages so far.
        dropped: number of messages dropped as a reader was too slow.
    """

    def __init__(self, participant: DomainParticipant, namespace: str) -> None:
        self.written = 0
        self.dropped = 0
        self._participant, self._namespace = participant, namespace
        self._writers: dict[RosChannel, tuple[MessageType, DataWriter]] = {}
        self._conversions: dict[int, Conversion] = {}
        self._last: dict[int, Sample] = {}
        self._body = ROS_BODY_FRAME

    @property
    def channels(self) -> tuple[RosChannel, ...]:
        """The present topics."""
        return tuple(self._writers)

    def announce(self, topics: Iterable[Topic]) -> None:
        """Create all topics at once, so that they are listed before the first message."""
        for topic in topics:
            if topic.direction is not TopicDirection.IN:
                self._learn(topic)
        self._writer(CLOCK_CHANNEL)
        self._writer(ODOMETRY_CHANNEL)
        self._writer(PARAMETER_EVENTS_CHANNEL)

    @property
    def writers(self) -> list[DataWriter]:
        """The writers of all topics."""
        return [writer for _, writer in self._writers.values()]

    def describe(self, urdf: str) -> None:
        """Publish the description of the drone, for RViz."""
        self._write(DESCRIPTION_CHANNEL, {"data": urdf})

    def write(self, sample: Sample) -> None:
        """Write all messages for a sample."""
        number = sample.definition.id
        found = self._conversions.get(number)
        if found is None or found.topic is not sample.definition:
            found = self._learn(sample.definition)
        for channel, values in found.messages(sample.t_ns, sample.payload):
            self._write(channel, values)
        # a latched message is written once
        if number == FRAMES_SIGNAL.id and FIXED_TRANSFORMS_CHANNEL in found.channels:
            moving = tuple(row for row in found.made if row[0] != FIXED_TRANSFORMS_CHANNEL)
            self._conversions[number] = Conversion(found.topic, moving)
        if number == CLOCK_SIGNAL.id:
            self._write(CLOCK_CHANNEL, {"clock": time_message(sample.t_ns)})
        if number == PARAMETERS_SIGNAL.id:
            name, value = str(sample["name"]), float(cast(float, sample["value"]))
            node = f"/{self._namespace}/{NODE_NAME}"
            event = parameter_event(sample.t_ns, node, name, value)
            self._write(PARAMETER_EVENTS_CHANNEL, event)
        if number in (POSITION_SIGNAL.id, VELOCITY_SIGNAL.id):
            self._last[number] = sample
            self._write_odometry(sample.t_ns)

    def _write_odometry(self, t_ns: int) -> None:
        """Write position and velocity in one message, as soon as both are known for a time."""
        position, velocity = self._last.get(POSITION_SIGNAL.id), self._last.get(VELOCITY_SIGNAL.id)
        if position and velocity and position.t_ns == velocity.t_ns:
            values = odometry(t_ns, position.values, velocity.values, self._body)
            self._write(ODOMETRY_CHANNEL, values)

    def _learn(self, topic: Topic) -> Conversion:
        found = conversion(topic)
        if topic.id == FRAMES_SIGNAL.id:
            split = (MOVING_TRANSFORMS_CHANNEL, FIXED_TRANSFORMS_CHANNEL)
            found = Conversion(topic, tuple((each, each.make(topic)) for each in split))
            self._body = base_frame(topic) or ROS_BODY_FRAME
        self._conversions[topic.id] = found
        for channel in found.channels:
            self._writer(channel)
        return found

    def _write(self, channel: RosChannel, values: Any) -> None:
        kind, writer = self._writer(channel)
        try:
            writer.write(kind.sample(values))
            self.written += 1
        except DDSException as error:
            if error.code != DDSException.DDS_RETCODE_TIMEOUT:
                raise WorkbenchError(f"{channel.topic} cannot be written: {error.msg}") from None
            self.dropped += 1

    def _writer(self, channel: RosChannel) -> tuple[MessageType, DataWriter]:
        found = self._writers.get(channel)
        if found is None:
            kind = message_type(channel.type)
            name = in_namespace(channel.topic, self._namespace)
            topic = dds_topic(self._participant, name, kind)
            qos = latched_qos() if channel in LATCHED_CHANNELS else endpoint_qos()
            found = kind, DataWriter(self._participant, topic, qos=qos)
            self._writers[channel] = found
        return found
