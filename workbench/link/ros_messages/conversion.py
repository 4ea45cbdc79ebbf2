"""Convert frames of the link to ROS 2 messages: their topics and types.

Axes and names follow REP-103 and REP-105: x east, y north, z up in `world`, x forward, y left, z up
in the body; quaternions are x, y, z, w. Time is simulated time.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from workbench.link.drone_topics import drone_signals
from workbench.link.ros_messages.making import MessageMaker
from workbench.link.signal import RosChannel
from workbench.link.topics import PREFIX, STRUCT_CODES, Topic

MessageValues = Mapping[str, Any]


MIN_ARRAY_VALUES = 256
"""Number of values of a field from which on it is read as a numpy array."""


@dataclass(frozen=True)
class Conversion:
    """The conversion of a topic of the link.

    Attributes:
        topic: of the link.
        made: ROS 2 topics, and functions that make their messages from a frame.
    """

    topic: Topic
    made: tuple[tuple[RosChannel, MessageMaker], ...]

    @property
    def channels(self) -> tuple[RosChannel, ...]:
        """Topics and types of the ROS 2 messages."""
        return tuple(channel for channel, _ in self.made)

    def messages(self, t_ns: int, payload: bytes) -> list[tuple[RosChannel, MessageValues]]:
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

    def read(self, payload: bytes) -> MessageValues:
        """Return the fields of a payload by name, as the functions in `made` need them.

        Raises:
            ValueError: if the payload does not have the size of the topic.
        """
        if self._records is None or len(payload) != self.topic.packer.size:
            return self.topic.unpack(payload)
        record = np.frombuffer(payload, self._records)[0]
        return {each.name: record[each.name] for each in self.topic.fields}

    @cached_property
    def _records(self) -> np.dtype | None:
        """The dtype of a payload with thousands of numbers, which numpy reads faster, else None."""
        if all(field.count < MIN_ARRAY_VALUES for field in self.topic.fields):
            return None
        return np.dtype(
            [
                (each.name, f"<{STRUCT_CODES[each.type]}", () if each.count == 1 else (each.count,))
                for each in self.topic.fields
            ]
        )


def conversion(topic: Topic) -> Conversion:
    """Return the conversion of a topic of the link; an unknown topic has no messages."""
    made = tuple(
        (channel, channel.make(topic))
        for row in drone_signals()
        if row.id == topic.id and PREFIX + row.name == topic.name
        for channel in row.channels
    )
    return Conversion(topic, made)
