"""A topic of a log as arrays over time, with a column for each number of its messages."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros_messages.cdr import Codec, Column, Layout
from workbench.gateways.ros_messages.definitions import split_schema
from workbench.logs.flight_record import Signal, Span

_STAMP = "header.stamp."
_POINTS = "sensor_msgs/msg/PointCloud2"
_POINT_TYPES = {1: "i1", 2: "u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 7: "<f4", 8: "<f8"}
"""Types of a PointField."""


@dataclass(frozen=True, eq=False)
class LoggedTopic:
    """The messages of one topic.

    Attributes:
        name: such as /dh_drone/velocity_data.
        short: name without the prefix /dh_drone/.
        type: of its messages, such as dh_drone_msgs/msg/VelocityData.
        schema: definition of that type.
        t_ns: time of each message [ns].
        messages: in CDR.
        gaps: begin and end [s] by signal, for an imported log, where a topic may combine streams of
            several rates.
    """

    name: str
    short: str
    type: str
    schema: str
    t_ns: Sequence[int]
    messages: Sequence[bytes]
    gaps: Mapping[str, Sequence[Span]] | None = None

    @property
    def time(self) -> np.ndarray:
        """Time of each message [s]."""
        return np.array(self.t_ns, dtype=np.int64) * 1e-9

    def between(self, begin: float, end: float) -> "LoggedTopic":
        """Return the messages of a time span [s]."""
        kept = np.flatnonzero((self.time >= begin) & (self.time <= end)).tolist()
        return replace(
            self, t_ns=[self.t_ns[i] for i in kept], messages=[self.messages[i] for i in kept]
        )

    @cached_property
    def stamps(self) -> np.ndarray:
        """Times of the contents of the messages, from their headers [s].

        Raises:
            WorkbenchError: if they have no such headers.
        """
        if not self.messages:
            return np.zeros(0)
        codec = Codec(tuple(split_schema(self.type, self.schema).values()))
        try:
            places = {each.path: each.offset for each in codec.layout_of(self.messages[0]).columns}
            seconds, rest = (places[f"{_STAMP}{name}"] for name in ("sec", "nanosec"))
            taken = [
                struct.unpack_from("<i", each, seconds) + struct.unpack_from("<I", each, rest)
                for each in self.messages
            ]
        except (KeyError, ValueError, OverflowError, struct.error) as error:
            raise WorkbenchError(f"{self.name}: cannot be decoded: {error}") from error
        return (np.array(taken, dtype=np.int64) @ [1_000_000_000, 1]) * 1e-9

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
        time = self.time
        try:
            columns = self._columns()
        except (KeyError, ValueError, OverflowError, struct.error) as error:
            raise WorkbenchError(f"{self.name}: cannot be decoded: {error}") from error
        return {
            path: Signal(f"{self.short}.{path}", unit, time, values)
            for path, (unit, values) in columns.items()
        }

    @cached_property
    def points(self) -> dict[str, Signal]:
        """The points of all clouds by field, with one value for each point; {} for other topics.

        Lengths are in m, in the sensor frame; each point has the time of its cloud.

        Raises:
            WorkbenchError: if a message cannot be decoded.
        """
        if self.type != _POINTS:
            return {}
        codec = Codec(tuple(split_schema(self.type, self.schema).values()))
        try:
            clouds = [_points(codec.layout_of(message), message) for message in self.messages]
            points = np.concatenate(clouds)
        except (KeyError, ValueError, TypeError, struct.error) as error:
            raise WorkbenchError(f"{self.name}: cannot be decoded: {error}") from error
        time = np.repeat(self.time, [len(cloud) for cloud in clouds])
        return {
            name: Signal(f"{self.short}.{name}", "m" if name in "xyz" else "", time, points[name])
            for name in points.dtype.names or ()
        }

    def _columns(self) -> dict[str, tuple[str, np.ndarray]]:
        if not self.messages:
            return {}
        codec = Codec(tuple(split_schema(self.type, self.schema).values()))
        layout = codec.layout_of(self.messages[0])
        table = _table(layout, self.messages)
        if table is not None:
            return {
                path: (column.unit, _plain(table[column.path][:, index]))
                for column in _wanted(layout)
                for index, path in enumerate(_paths(column))
            }
        return self._one_by_one(codec)

    def _one_by_one(self, codec: Codec) -> dict[str, tuple[str, np.ndarray]]:
        """Return the columns of messages that differ in length."""
        units: dict[str, str] = {}
        rows: list[dict[str, object]] = []
        for message in self.messages:
            layout = codec.layout_of(message)
            row: dict[str, object] = {}
            for column in _wanted(layout):
                code = f"<{column.count}{column.code}"
                values = struct.unpack_from(code, message, column.offset)
                paths = _paths(column)
                units.update(dict.fromkeys(paths, column.unit))
                row.update(zip(paths, map(_text, values), strict=True))
            rows.append(row)
        return {path: (unit, _gathered(rows, path)) for path, unit in units.items()}


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


def _points(layout: Layout, message: bytes) -> np.ndarray:
    """Return the points of a PointCloud2 as a structured array.

    Raises:
        ValueError: if its description of itself is invalid.
    """
    places = {column.path: column for column in layout.columns}

    def value(path: str) -> Any:
        column = places[path]
        return struct.unpack_from(f"<{column.count}{column.code}", message, column.offset)[0]

    if value("is_bigendian"):
        raise ValueError("its points are big-endian")
    numbers = [path.split(".")[1] for path in places if path.endswith(".datatype")]
    kind = np.dtype(
        {
            "names": [value(f"fields.{each}.name").decode() for each in numbers],
            "formats": [_POINT_TYPES[value(f"fields.{each}.datatype")] for each in numbers],
            "offsets": [value(f"fields.{each}.offset") for each in numbers],
            "itemsize": value("point_step"),
        }
    )
    data = places.get("data")  # missing if no ray hit anything
    count = value("width") * value("height")
    return np.frombuffer(message, kind, count, data.offset) if data else np.zeros(0, kind)


def _table(layout: Layout, messages: Sequence[bytes]) -> np.ndarray | None:
    """Return messages as a structured array; None if their layouts differ."""
    size = len(messages[0])
    if any(len(message) != size for message in messages):
        return None
    columns = [*_wanted(layout)]
    lengths = [f"length {index}" for index in range(len(layout.lengths))]
    kind = np.dtype(
        {
            "names": [*(column.path for column in columns), *lengths],
            "formats": [*map(_format, columns), *("<u4" for _ in lengths)],
            "offsets": [*(column.offset for column in columns), *(at for at, _ in layout.lengths)],
            "itemsize": size,
        }
    )
    table = np.frombuffer(b"".join(messages), kind)
    for name, (_, length) in zip(lengths, layout.lengths, strict=True):
        if not np.all(table[name] == length):
            return None
    return table


def _wanted(layout: Layout) -> list[Column]:
    """Return the columns that become series."""
    return [
        column
        for column in layout.columns
        if column.code != "V" and _STAMP not in column.path and not _is_header(column.path)
    ]


def _is_header(path: str) -> bool:
    return path.endswith("header.frame_id")


def _format(column: Column) -> tuple[str, tuple[int, ...]]:
    """Return the numpy format of a column: as many elements as it has values, one for a text."""
    if column.code == "s":
        return f"S{max(column.count, 1)}" if column.count else "S1", (1,)
    return f"<{column.code}" if column.code != "?" else "?", (column.count,)


def _paths(column: Column) -> list[str]:
    """Return a name for each value of a column."""
    if not column.array:
        return [column.path]
    return [f"{column.path}.{index}" for index in range(column.count)]


def _plain(values: np.ndarray) -> np.ndarray:
    """Return a column by itself, texts decoded."""
    if values.dtype.kind == "S":
        return np.array([_text(value) for value in values], dtype=object)
    return values.copy()


def _text(value: object) -> object:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _gathered(rows: list[dict[str, object]], path: str) -> np.ndarray:
    """Return a column of rows, where some may lack it."""
    found = [row.get(path) for row in rows]
    if any(isinstance(value, str) for value in found):
        return np.array(["" if value is None else value for value in found], dtype=object)
    return np.array([np.nan if value is None else value for value in found])
