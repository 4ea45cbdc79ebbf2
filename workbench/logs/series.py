"""A topic of a log as arrays over time, with a column for each number of its messages."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.array_files import ArrayReader, ArrayWriter
from workbench.logs.flight_record import Signal, Span, spans


@dataclass(frozen=True, eq=False)
class Column:
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
        short: name without the prefix /dh_drone/.
        type: of its messages, such as dh_drone_msgs/msg/VelocityData.
        t_ns: time of each message (n) [ns].
        fields: all contents of the messages by name of the field, except headers and points.
        stamps_ns: times in the headers of the messages (n) [ns]; None if they have none.
        cloud: the points of all clouds by field (m).
        sizes: number of points of each cloud (n), for a topic of clouds.
        gaps: begin and end [s] by signal, for an imported log, where a topic may combine streams of
            several rates.
        damage: why the messages cannot be decoded, else "".
    """

    name: str
    short: str
    type: str
    t_ns: np.ndarray
    fields: Mapping[str, Column]
    stamps_ns: np.ndarray | None = None
    cloud: Mapping[str, Column] | None = None
    sizes: np.ndarray | None = None
    gaps: Mapping[str, Sequence[Span]] | None = None
    damage: str = ""

    def described(self, arrays: ArrayWriter) -> dict[str, Any]:
        """Return the topic in JSON types, for `from_description`, and write its arrays."""

        def written(columns: Mapping[str, Column]) -> dict[str, Any]:
            return {path: [each.unit, arrays.add(each.values)] for path, each in columns.items()}

        return {
            "name": self.name,
            "short": self.short,
            "type": self.type,
            "damage": self.damage,
            "gaps": self.gaps,
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

        def columns(found: Any, length: int) -> dict[str, Column]:
            return {path: Column(str(u), read(v, length)) for path, (u, v) in found.items()}

        t_ns = read(said["t_ns"])
        stamps, sizes, gaps = said["stamps_ns"], said["sizes"], said["gaps"]
        counts = None if sizes is None else read(sizes, len(t_ns))
        return cls(
            name=str(said["name"]),
            short=str(said["short"]),
            type=str(said["type"]),
            damage=str(said["damage"]),
            gaps=None if gaps is None else {name: spans(each) for name, each in gaps.items()},
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

    def between(self, begin: float, end: float) -> "LoggedTopic":
        """Return the messages of a time span [s]."""
        kept = (self.time >= begin) & (self.time <= end)
        points = None if self.sizes is None else np.repeat(kept, self.sizes)
        return replace(
            self,
            t_ns=self.t_ns[kept],
            fields=_rows_of(self.fields, kept),
            stamps_ns=None if self.stamps_ns is None else self.stamps_ns[kept],
            cloud=None if points is None else _rows_of(self.cloud or {}, points),
            sizes=None if self.sizes is None else self.sizes[kept],
        )

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
    def columns(self) -> dict[str, Signal]:
        """All contents of the messages by name of the field, except headers and points.

        In an imported log each field is at its measured times, with a NaN in its gaps.

        Raises:
            WorkbenchError: if a message cannot be decoded.
        """
        rows = self.rows()
        if self.gaps is None:
            return rows
        return {path: _measured(each, self.gaps.get(each.name, ())) for path, each in rows.items()}

    def rows(self) -> dict[str, Signal]:
        """Return the same columns, with one value for each message.

        Raises:
            WorkbenchError: if a message cannot be decoded.
        """
        if self.damage:
            raise WorkbenchError(f"{self.name}: cannot be decoded: {self.damage}")
        return self._signals(self.fields, self.time)

    @cached_property
    def points(self) -> dict[str, Signal]:
        """The points of all clouds by field, with one value for each point; {} for other topics.

        Lengths are in m, in the sensor frame; each point has the time of its cloud.
        """
        if self.cloud is None or self.sizes is None:
            return {}
        return self._signals(self.cloud, np.repeat(self.time, self.sizes))

    def _signals(self, columns: Mapping[str, Column], time: np.ndarray) -> dict[str, Signal]:
        return {
            path: Signal(f"{self.short}.{path}", column.unit, time, column.values)
            for path, column in columns.items()
        }


def _rows_of(columns: Mapping[str, Column], kept: np.ndarray) -> dict[str, Column]:
    return {path: replace(each, values=each.values[kept]) for path, each in columns.items()}


def _measured(series: Signal, gaps: Sequence[Span]) -> Signal:
    """Return a series without the rows of other streams."""
    if series.values.dtype.kind != "f":
        return series
    kept = ~np.isnan(series.values)
    # Times here are whole nanoseconds, unlike the ends of gaps.
    within = np.searchsorted(series.time, [begin + 2e-9 for begin, _ in gaps])
    inside = [
        row
        for row, (_, end) in zip(within, gaps, strict=True)
        if row < len(kept) and series.time[row] < end - 2e-9
    ]
    kept[inside] = True
    return Signal(series.name, series.unit, series.time[kept], series.values[kept])
