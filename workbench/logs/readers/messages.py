"""Messages in CDR, and their contents as columns."""

import struct
from array import array
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.link.ros_messages import cdr
from workbench.link.ros_messages.cdr import Codec, MessageLayout
from workbench.link.ros_messages.definitions import split_schema
from workbench.logs.logged_topic import LoggedTopic, MessageColumn

MAX_TOPIC_COLUMNS = 50_000
"""Largest number of columns of a topic."""
_STAMP_PREFIX = "header.stamp."
_STAMP_FIELDS = (f"{_STAMP_PREFIX}sec", f"{_STAMP_PREFIX}nanosec")
_CLOUD_TYPE = "sensor_msgs/msg/PointCloud2"
_POINT_TYPES = {1: "i1", 2: "u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 7: "<f4", 8: "<f8"}
"""Types of a PointField."""


class Messages:
    """The messages of a topic, without an object for each.

    Attributes:
        t_ns: time of each message [ns].
        sizes: of each message [bytes].
        data: all messages.
    """

    def __init__(self) -> None:
        self.t_ns = array("q")
        self.sizes = array("I")
        self.data = bytearray()

    def add(self, t_ns: int, message: memoryview) -> None:
        """Add a message of a time [ns]."""
        self.t_ns.append(t_ns)
        self.sizes.append(len(message))
        self.data += message


class _Rows(NamedTuple):
    """Messages of one layout: which ones (k), their bytes (k, size), and a structured array (k)."""

    rows: np.ndarray
    layout: MessageLayout
    plain: np.ndarray
    table: np.ndarray


def read_topic(name: str, kind: str, schema: str, messages: Messages) -> LoggedTopic:
    """Return a topic with the contents of its messages.

    Args:
        name: of the topic.
        kind: type of the messages, such as dh_drone_msgs/msg/VelocityData.
        schema: definition of that type.
        messages: the messages.
    """
    t_ns = np.array(messages.t_ns, dtype=np.int64)
    try:
        codec = Codec(tuple(split_schema(kind, schema).values()))
        found = list(_messages_by_layout(codec, messages))
        columns = _columns_of_rows(found, len(t_ns))
        seconds, rest = (columns.pop(field, None) for field in _STAMP_FIELDS)
        stamps = None
        if seconds is not None and rest is not None:
            stamps = seconds.values.astype(np.int64) * 1_000_000_000 + rest.values.astype(np.int64)
        if kind != _CLOUD_TYPE:
            return LoggedTopic(name, kind, t_ns, columns, stamps)
        cloud, sizes = _cloud_points(found, len(t_ns))
        return LoggedTopic(name, kind, t_ns, columns, stamps, cloud, sizes)
    except (
        WorkbenchError,
        KeyError,
        ValueError,
        TypeError,
        OverflowError,
        RecursionError,
        struct.error,
    ) as error:
        return LoggedTopic(name, kind, t_ns, {}, damage=str(error) or type(error).__name__)


def _messages_by_layout(codec: Codec, messages: Messages) -> Iterator[_Rows]:
    """Yield the messages by their layouts, all of one layout at once."""
    sizes = np.frombuffer(messages.sizes, dtype=f"u{messages.sizes.itemsize}")
    ends = np.cumsum(sizes, dtype=np.int64)
    begins, data = ends - sizes, memoryview(messages.data)
    order = np.argsort(sizes, kind="stable")
    cuts = np.flatnonzero(np.diff(sizes[order])) + 1
    for rows in np.split(order, cuts) if len(order) else ():
        size = int(sizes[rows[0]])
        spans = zip(begins[rows].tolist(), ends[rows].tolist(), strict=True)
        whole = len(rows) == len(sizes)
        plain = data if whole else b"".join(data[begin:end] for begin, end in spans)
        left = np.frombuffer(plain, np.uint8).reshape(len(rows), size)
        while len(rows):
            layout = codec.layout_of(left[0].tobytes())
            kind = _structure(layout, size)
            table, same = left.view(kind)[:, 0], np.ones(len(rows), bool)
            for name, (_, length) in zip(_lengths(layout), layout.lengths, strict=True):
                same &= table[name] == length
            if same.all():
                yield _Rows(rows, layout, left, table)
                break
            plain = left[same]
            yield _Rows(rows[same], layout, plain, plain.view(kind)[:, 0])
            rows, left = rows[~same], left[~same]


def _structure(layout: MessageLayout, size: int) -> np.dtype:
    """Return the numpy type of messages of a layout, with their lengths as fields, too."""
    if (
        sum(max(1, each.count) for each in layout.columns if each.code not in "sV")
        > MAX_TOPIC_COLUMNS
    ):
        raise ValueError(f"a message has more than {MAX_TOPIC_COLUMNS} numbers")
    columns = [each for each in layout.columns if each.code != "V"]
    lengths = _lengths(layout)
    return np.dtype(
        {
            "names": [*(column.path for column in columns), *lengths],
            "formats": [*map(_numpy_format, columns), *("<u4" for _ in lengths)],
            "offsets": [*(column.offset for column in columns), *(at for at, _ in layout.lengths)],
            "itemsize": size,
        }
    )


def _lengths(layout: MessageLayout) -> list[str]:
    """Return the names of the fields of the lengths of a layout."""
    return [f"length {index}" for index in range(len(layout.lengths))]


def _numpy_format(column: cdr.LayoutColumn) -> tuple[str, tuple[int, ...]]:
    """Return the numpy format of a column: as many elements as it has values, one for a text."""
    if column.code == "s":
        return f"S{max(column.count, 1)}" if column.count else "S1", (1,)
    return f"<{column.code}" if column.code != "?" else "?", (column.count,)


def _columns_of_rows(found: Sequence[_Rows], count: int) -> dict[str, MessageColumn]:
    """Return a column for each value of the messages, and those of the time in the header."""
    units: dict[str, str] = {}
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for each in found:
        for column in filter(_wanted, each.layout.columns):
            values = each.table[column.path]
            for index, path in enumerate(_paths(column)):
                units.setdefault(path, column.unit)
                parts.setdefault(path, []).append((each.rows, _decoded_column(values[:, index])))
        if len(parts) > MAX_TOPIC_COLUMNS:
            raise ValueError(f"it has more than {MAX_TOPIC_COLUMNS} fields")
    return {
        path: MessageColumn(units[path], _gathered(each, count)) for path, each in parts.items()
    }


def _wanted(column: cdr.LayoutColumn) -> bool:
    """Return whether a column becomes a series, or is the time in the header of the message."""
    if column.path in _STAMP_FIELDS:
        return True
    header = _STAMP_PREFIX in column.path or column.path.endswith("header.frame_id")
    return column.code != "V" and not header


def _paths(column: cdr.LayoutColumn) -> list[str]:
    """Return a name for each value of a column."""
    if not column.array:
        return [column.path]
    return [f"{column.path}.{index}" for index in range(column.count)]


def _decoded_column(values: np.ndarray) -> np.ndarray:
    """Return a column by itself, texts decoded."""
    if values.dtype.kind != "S":
        return values
    known, places = np.unique(values, return_inverse=True)
    texts = [value.decode("utf-8", "replace") for value in known.tolist()]
    return np.asarray(np.array(texts, dtype=object)[places])


def _gathered(parts: Sequence[tuple[np.ndarray, np.ndarray]], count: int) -> np.ndarray:
    """Return the values of all messages from those of some; one that is missing is NaN or ""."""
    rows, values = parts[0]
    if len(parts) == 1 and len(rows) == count:
        return values.copy()
    text = values.dtype.kind == "O"
    missing = sum(len(each) for each, _ in parts) < count
    kind = np.float64 if missing and not text else values.dtype
    found = np.full(count, "" if text else np.nan, kind) if missing else np.empty(count, kind)
    for rows, values in parts:
        found[rows] = values
    return found


def _cloud_points(
    found: Sequence[_Rows], count: int
) -> tuple[dict[str, MessageColumn], np.ndarray]:
    """Return the points of all clouds by field, and their number in each cloud."""
    clouds = {
        row: _points_of(each.layout, message.tobytes())
        for each in found
        for row, message in zip(each.rows.tolist(), each.plain, strict=True)
    }
    points = [clouds[row] for row in range(count)]
    kinds = {each.dtype for each in points}
    if len(kinds) > 1:
        raise ValueError("its clouds have different fields")
    sizes = np.array([len(each) for each in points], dtype=np.int64)
    names = next(iter(kinds)).names or ()
    return {
        name: MessageColumn(
            "m" if name in ("x", "y", "z") else "", np.concatenate([each[name] for each in points])
        )
        for name in names
    }, sizes


def _points_of(layout: MessageLayout, message: bytes) -> np.ndarray:
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
    formats = [_POINT_TYPES[value(f"fields.{each}.datatype")] for each in numbers]
    step = value("point_step")
    if sum(np.dtype(each).itemsize for each in formats) > step:
        raise ValueError("the fields of its points overlap")
    kind = np.dtype(
        {
            "names": [value(f"fields.{each}.name").decode() for each in numbers],
            "formats": formats,
            "offsets": [value(f"fields.{each}.offset") for each in numbers],
            "itemsize": step,
        }
    )
    data = places.get("data")  # missing if no ray hit anything
    count = value("width") * value("height")
    return np.frombuffer(message, kind, count, data.offset) if data else np.zeros(0, kind)
