"""A topic of a log as arrays over time, with a column for each number of its messages."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.series import Series
from workbench.logs.array_files import ArrayReader, ArrayWriter


@dataclass(frozen=True, eq=False)
class MessageColumn:
    """One number or text of each message, or of each point of clouds.

    Attributes:
        unit: SI, "" if unknown.
        values: (n); NaN or "" if a message has no such field.
    """

    unit: str
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class LoggedTopic:
    """The messages of one topic.

    Attributes:
        name: such as /dh_drone/velocity_data.
        type: of its messages, such as dh_drone_msgs/msg/VelocityData.
        t_ns: time of each message (n) [ns].
        fields: all contents of the messages by name of the field, except headers and points.
        stamps_ns: times in the headers of the messages (n) [ns]; None if they have none.
        cloud: the points of all clouds by field (m).
        sizes: number of points of each cloud (n), for a topic of clouds.
        damage: why the messages cannot be decoded, else "".
    """

    name: str
    type: str
    t_ns: np.ndarray
    fields: Mapping[str, MessageColumn]
    stamps_ns: np.ndarray | None = None
    cloud: Mapping[str, MessageColumn] | None = None
    sizes: np.ndarray | None = None
    damage: str = ""

    @cached_property
    def short(self) -> str:
        """Name as used on the command line."""
        return short_topic_name(self.name)

    def described(self, arrays: ArrayWriter) -> dict[str, Any]:
        """Return the topic in JSON types, for `from_description`, and write its arrays."""

        def written(columns: Mapping[str, MessageColumn]) -> dict[str, Any]:
            return {path: [each.unit, arrays.add(each.values)] for path, each in columns.items()}

        return {
            "name": self.name,
            "type": self.type,
            "damage": self.damage,
            "t_ns": arrays.add(self.t_ns),
            "fields": written(self.fields),
            "stamps_ns": None if self.stamps_ns is None else arrays.add(self.stamps_ns),
            "cloud": None if self.cloud is None else written(self.cloud),
            "sizes": None if self.sizes is None else arrays.add(self.sizes),
        }

    @classmethod
    def from_description(cls, said: Mapping[str, Any], arrays: ArrayReader) -> "LoggedTopic":
        """Return the topic from its description.

        Raises:
            KeyError, TypeError, ValueError, AttributeError, OSError: if it is invalid.
        """

        def read(place: Any, length: int | None = None) -> np.ndarray:
            values = arrays.get(place)
            if length is not None and len(values) != length:
                raise ValueError(f"{len(values)} values for {length} messages or points")
            return values

        def columns(found: Mapping[str, Any], length: int) -> dict[str, MessageColumn]:
            return {path: MessageColumn(str(u), read(v, length)) for path, (u, v) in found.items()}

        t_ns = read(said["t_ns"])
        stamps, sizes = said["stamps_ns"], said["sizes"]
        counts = None if sizes is None else read(sizes, len(t_ns))
        return cls(
            name=str(said["name"]),
            type=str(said["type"]),
            damage=str(said["damage"]),
            t_ns=t_ns,
            fields=columns(said["fields"], len(t_ns)),
            stamps_ns=None if stamps is None else read(stamps, len(t_ns)),
            cloud=None if counts is None else columns(said["cloud"], int(counts.sum())),
            sizes=counts,
        )

    @cached_property
    def time(self) -> np.ndarray:
        """Time of each message [s]."""
        return np.asarray(self.t_ns * 1e-9)

    @property
    def stamps(self) -> np.ndarray:
        """Times of the contents of the messages, from their headers [s].

        Raises:
            WorkbenchError: if they have no such headers.
        """
        if self.stamps_ns is None:
            raise WorkbenchError(f"{self.name}: cannot be decoded: {self.damage or 'no headers'}")
        return np.asarray(self.stamps_ns * 1e-9)

    @cached_property
    def columns(self) -> dict[str, Series]:
        """All contents of the messages by name of the field, except headers and points.

        Raises:
            WorkbenchError: if a message cannot be decoded.
        """
        if self.damage:
            raise WorkbenchError(f"{self.name}: cannot be decoded: {self.damage}")
        return self._signals(self.fields, self.time)

    @cached_property
    def points(self) -> dict[str, Series]:
        """The points of all clouds by field, with one value for each point; {} for other topics.

        Lengths are in m, in the sensor frame; each point has the time of its cloud.
        """
        if self.cloud is None or self.sizes is None:
            return {}
        return self._signals(self.cloud, np.repeat(self.time, self.sizes))

    def _signals(self, columns: Mapping[str, MessageColumn], time: np.ndarray) -> dict[str, Series]:
        return {
            path: Series(f"{self.short}.{path}", column.unit, time, column.values)
            for path, column in columns.items()
        }


def short_topic_name(topic: str) -> str:
    """Return the name of a topic as used on the command line, without /dh_drone/."""
    return re.sub(r"^/(dh_drone/)?", "", topic)
