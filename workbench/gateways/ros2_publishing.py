"""Publish the topics of the drone as ROS 2 topics."""

from collections.abc import Iterable
from typing import Any

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.topic import Topic as DdsTopic

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros2_dds import CLOCK, MessageType, message_type
from workbench.gateways.ros_messages.conversion import Channel, Conversion, conversion
from workbench.gateways.ros_messages.making import BODY, WORLD, odometry
from workbench.link.drone_topics import FRAMES, POSITION, TIME, VELOCITY
from workbench.link.sample import Sample
from workbench.link.topics import PREFIX, Direction, Topic

DEPTH = 10
ODOMETRY = Channel(f"{PREFIX}odometry", "nav_msgs/msg/Odometry")
CLOCK_CHANNEL = Channel("/clock", CLOCK)


def writer_qos() -> Qos:
    """Return the quality of service of writers: the default of ROS 2, so that every reader matches.

    Best-effort readers match a reliable writer, but not vice versa. A writer does not wait for slow
    readers: samples that do not fit are dropped.
    """
    return Qos(
        Policy.Reliability.Reliable(0),
        Policy.Durability.Volatile,
        Policy.History.KeepLast(DEPTH),
        # ROS 2 uses XCDR1, and readers of XCDR1 get no XCDR2 data, without any error.
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
    )


def dds_topic(participant: DomainParticipant, name: str, kind: MessageType) -> DdsTopic:
    """Return the DDS topic of a ROS 2 topic."""
    return DdsTopic(participant, f"rt{name}", kind.idl)


class Publishing:
    """Writes samples of the link as ROS 2 messages.

    Args:
        participant: of the domain.

    Attributes:
        written: number of messages so far.
        dropped: number of messages dropped as a reader was too slow.
    """

    def __init__(self, participant: DomainParticipant) -> None:
        self.written = 0
        self.dropped = 0
        self._participant = participant
        self._writers: dict[Channel, tuple[MessageType, DataWriter]] = {}
        self._conversions: dict[int, Conversion] = {}
        self._last: dict[int, Sample] = {}
        self._body = BODY

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The present topics."""
        return tuple(self._writers)

    def announce(self, topics: Iterable[Topic]) -> None:
        """Create all topics at once, so that they are listed before the first message."""
        for topic in topics:
            if topic.direction is not Direction.IN:
                self._learn(topic)
        self._writer(CLOCK_CHANNEL)
        self._writer(ODOMETRY)

    def write(self, sample: Sample) -> None:
        """Write all messages for a sample."""
        number = sample.definition.id
        found = self._conversions.get(number)
        if found is None or found.topic is not sample.definition:
            found = self._learn(sample.definition)
        for channel, values in found.messages(sample.t_ns, sample.payload):
            self._write(channel, values)
        if number == TIME:
            seconds, rest = divmod(sample.t_ns, 1_000_000_000)
            self._write(CLOCK_CHANNEL, {"clock": {"sec": seconds, "nanosec": rest}})
        if number in (POSITION, VELOCITY):
            self._last[number] = sample
            self._write_odometry(sample.t_ns)

    def _write_odometry(self, t_ns: int) -> None:
        """Write position and velocity in one message, as soon as both are known for a time."""
        position, velocity = self._last.get(POSITION), self._last.get(VELOCITY)
        if position and velocity and position.t_ns == velocity.t_ns:
            values = odometry(t_ns, position.values, velocity.values, self._body)
            self._write(ODOMETRY, values)

    def _learn(self, topic: Topic) -> Conversion:
        found = conversion(topic)
        self._conversions[topic.id] = found
        for channel in found.channels:
            self._writer(channel)
        if topic.id == FRAMES:
            frames: Any = topic.about.get("frames", ())
            self._body = next((child for parent, child in frames if parent == WORLD), BODY)
        return found

    def _write(self, channel: Channel, values: Any) -> None:
        kind, writer = self._writer(channel)
        try:
            writer.write(kind.sample(values))
            self.written += 1
        except DDSException as error:
            if error.code != DDSException.DDS_RETCODE_TIMEOUT:
                raise WorkbenchError(f"{channel.topic} cannot be written: {error.msg}") from None
            self.dropped += 1

    def _writer(self, channel: Channel) -> tuple[MessageType, DataWriter]:
        found = self._writers.get(channel)
        if found is None:
            kind = message_type(channel.type)
            topic = dds_topic(self._participant, channel.topic, kind)
            found = kind, DataWriter(self._participant, topic, qos=writer_qos())
            self._writers[channel] = found
        return found
