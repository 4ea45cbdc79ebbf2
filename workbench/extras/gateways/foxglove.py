"""Foxglove: a live WebSocket server for the Foxglove app, for display only.

It checks neither Origin nor Host and has no login, so anybody who can reach it sees the flight.
"""

import importlib
from collections.abc import Sequence
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, is_loopback
from workbench.link.drone_topics import CLOCK_SIGNAL
from workbench.link.ros_messages.cdr import encode
from workbench.link.ros_messages.conversion import Conversion, conversion
from workbench.link.ros_messages.library import schema_text
from workbench.link.ros_messages.namespace import in_namespace, ros_namespace
from workbench.link.sample import Sample
from workbench.link.signal import RosChannel
from workbench.link.topics import Topic

if TYPE_CHECKING:
    import foxglove

FOXGLOVE_PORT = 8765
"""Default port of Foxglove."""


class Foxglove:
    """An outlet that offers topics as ROS 2 messages to the Foxglove app.

    Args:
        name: of the vehicle.
        address: that it listens at; port 0 for a free one.
        anybody: whether it may accept connections from other computers.

    Attributes:
        address: that it listens at.

    Raises:
        WorkbenchError: if the extra is not installed, or the address is not local or is in use.
    """

    def __init__(self, name: str, address: Address, anybody: bool) -> None:
        check_reach(address, anybody)
        self._foxglove = load_foxglove()
        self._namespace = ros_namespace(name)
        self._context = self._foxglove.Context()
        try:
            self._server = self._foxglove.start_server(
                name=f"{name}, watch only",
                host=address.host,
                port=address.port,
                capabilities=[self._foxglove.websocket.Capability.Time],
                context=self._context,
            )
        except (OSError, RuntimeError) as error:
            raise WorkbenchError(
                f"cannot listen at {address}: {error}; name another address with --listen"
            ) from None
        self.address = Address(address.host, self._server.port)
        self._ways: dict[int, _TopicConversion] = {}

    def announce(self, topics: Sequence[Topic]) -> None:
        """Offer topics before their first message."""
        for topic in topics:
            self._way(topic)

    def deliver(self, sample: Sample) -> None:
        """Send a sample to all viewers."""
        if sample.definition.id == CLOCK_SIGNAL.id:
            self._server.broadcast_time(sample.t_ns)
        way = self._way(sample.definition)
        if not any(channel.base.has_sinks() for channel in way.channels):
            return
        made = way.conversion.messages(sample.t_ns, sample.payload)
        for channel, (kind, values) in zip(way.channels, made, strict=True):
            channel.log(encode(kind.type, values), log_time=sample.t_ns)

    def close(self) -> None:
        """End the server."""
        for number in list(self._ways):
            self._withdraw(number)
        self._server.stop()

    def _way(self, topic: Topic) -> "_TopicConversion":
        """Return conversion and channels of a topic; a restarted server may have other topics."""
        way = self._ways.get(topic.id)
        if way is None or way.conversion.topic is not topic:
            self._withdraw(topic.id)
            made = conversion(topic)
            way = _TopicConversion(made, [self._channel(topic, each) for each in made.channels])
            self._ways[topic.id] = way
        return way

    def _withdraw(self, number: int) -> None:
        """Offer a topic no longer."""
        way = self._ways.pop(number, None)
        for channel in way.channels if way else ():
            channel.close()

    def _channel(self, topic: Topic, channel: RosChannel) -> "foxglove.Channel":
        schema = self._foxglove.Schema(
            name=channel.type, encoding="ros2msg", data=schema_text(channel.type).encode()
        )
        return self._foxglove.Channel(
            in_namespace(channel.topic, self._namespace),
            schema=schema,
            message_encoding="cdr",
            context=self._context,
            metadata={"link_topic": topic.name},
        )


class _TopicConversion(NamedTuple):
    """The conversion of a topic, and its channels."""

    conversion: Conversion
    channels: list["foxglove.Channel"]


def check_reach(address: Address, anybody: bool) -> None:
    """Check that only permitted viewers can connect.

    Raises:
        WorkbenchError: if other computers could connect without permission.
    """
    if not (anybody or is_loopback(address.host)):
        raise WorkbenchError(
            f"Foxglove's server has no login, and others may reach {address.host}: listen on "
            "127.0.0.1, or add --anybody if all of them may watch"
        )


def load_foxglove() -> ModuleType:
    """Return the package.

    Raises:
        WorkbenchError: if it is not installed.
    """
    try:
        return importlib.import_module("foxglove")
    except ImportError:
        raise WorkbenchError(
            "the live view in Foxglove needs the package foxglove-sdk: `pip install foxglove-sdk`"
        ) from None
