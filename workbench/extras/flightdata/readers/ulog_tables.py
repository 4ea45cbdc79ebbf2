"""The messages of a ULog as tables, one for each instance of a topic."""

import io
import struct
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.readers.topic_log import MessageTable

ULOG_FILE_HEADER_BYTES = 16
ULOG_MESSAGE_HEADER_BYTES = 3
"""Number of bytes before the first message, and before each message."""
MAX_ULOG_INSTANCES = 16


class UlogReader(io.BufferedReader):
    """A log in which pyulog cannot go back far enough to read it for ever.

    After an unknown message in the header, pyulog seeks back by the size that the message states.
    If the file ends before that size, pyulog would come to earlier messages, again and again.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._path = path
        self._last = 0

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        self._last = len(data)
        return data

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        if whence == io.SEEK_CUR and -offset > self._last + ULOG_MESSAGE_HEADER_BYTES:
            raise WorkbenchError(
                f"{self._path}: is damaged: at byte {self.tell()} a message ends beyond the end of "
                "the file"
            )
        return super().seek(offset, whence)


def _instance(topic: str, number: int) -> str:
    """Return the name of an instance of a topic."""
    return topic if number == 0 else f"{topic}_{number}"


def ulog_instances(tables: Mapping[str, MessageTable], topic: str) -> list[str]:
    """Return the names of the logged instances of a topic, in order."""
    return [name for i in range(MAX_ULOG_INSTANCES) if (name := _instance(topic, i)) in tables]


def ulog_tables(path: Path, found: Sequence[Any]) -> dict[str, MessageTable]:
    """Return the tables of all instances of topics, the subscriptions of each one joined."""
    grouped: dict[str, list[Any]] = defaultdict(list)
    for each in found:
        grouped[_instance(each.name, each.multi_id)].append(each)
    stamps = {topic: [_stamps(each.data) for each in group] for topic, group in grouped.items()}
    plain = all(
        len(group) == 1 and bool((np.diff(group[0]) > 0).all()) for group in stamps.values()
    )
    # The places in the file matter only if a clock steps back, or to join subscriptions.
    places = {} if plain else _message_offsets(path)
    tables = {}
    for topic, group in grouped.items():
        counts = [len(each) for each in stamps[topic]]
        found_places = [places.get(each.msg_id, np.empty(0)) for each in group]
        order = np.concatenate(
            [
                place if len(place) == count else np.arange(count)
                for place, count in zip(found_places, counts, strict=True)
            ]
        )
        rows = np.argsort(order, kind="stable")
        fields = [_fields(each.data) for each in group]
        tables[topic] = MessageTable(
            np.concatenate(stamps[topic]).astype(float)[rows],
            {
                name: np.concatenate(
                    [
                        each.get(name, np.full(count, np.nan))
                        for each, count in zip(fields, counts, strict=True)
                    ]
                )[rows]
                for name in dict.fromkeys(name for each in fields for name in each)
            },
            order[rows],
        )
    return tables


def _stamps(data: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the time stamps of the messages of a subscription [us]."""
    sampled = data.get("timestamp_sample")
    used = data["timestamp"] if sampled is None or not (sampled > 0).all() else sampled
    return np.asarray(used.astype(np.int64))


def _message_offsets(path: Path) -> dict[int, np.ndarray]:
    """Return where the messages of each subscription are in the file, by its number.

    pyulog keeps the order of the messages of a subscription, but not that of all.
    """
    data = path.read_bytes()
    places: dict[int, list[int]] = defaultdict(list)
    at = ULOG_FILE_HEADER_BYTES
    while at + ULOG_MESSAGE_HEADER_BYTES + 2 <= len(data):
        size, kind, number = struct.unpack_from("<HBH", data, at)
        if kind == ord("D"):
            places[number].append(at)
        at += ULOG_MESSAGE_HEADER_BYTES + size
    return {number: np.array(each) for number, each in places.items()}


def _fields(data: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the numeric fields of a topic, without times and padding."""
    return {
        field: np.asarray(values, dtype=float)
        for field, values in data.items()
        if "timestamp" not in field
        and not field.startswith("_padding")
        and np.asarray(values).dtype.kind in "fiub"
    }
