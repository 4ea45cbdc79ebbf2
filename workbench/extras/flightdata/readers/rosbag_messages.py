"""The messages of a bag of ROS 2, in MCAP or in SQLite (.db3), the default of ROS 2 Humble."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError
from workbench.link.ros_messages.library import schema_text, type_names

SQLITE_MAGIC = b"SQLite format 3\0"
_RECORD_HEAD_BYTES = 9
"""Opcode and length of the first record of an MCAP file, which has profile and library."""


class BagMessage(NamedTuple):
    """A message of a bag.

    Attributes:
        topic: its name.
        kind: type of the messages of the topic.
        definition: of the type; "" if it is not known.
        t_ns: time of the bag [ns].
        data: in CDR.
    """

    topic: str
    kind: str
    definition: str
    t_ns: int
    data: bytes


def is_rosbag(head: bytes) -> bool:
    """Return whether a file begins as a bag of ROS 2 that the workbench did not write."""
    if head.startswith(SQLITE_MAGIC):
        return True
    begin = len(MCAP0_MAGIC) + _RECORD_HEAD_BYTES
    if not head.startswith(MCAP0_MAGIC):
        return False
    texts = []
    for _ in range(2):
        length = int.from_bytes(head[begin : begin + 4], "little")
        texts.append(head[begin + 4 : begin + 4 + length])
        begin += 4 + length
    profile, library = texts
    return profile == Profile.ROS2.encode() and not library.startswith(b"workbench")


def bag_messages(path: Path) -> Iterator[BagMessage]:
    """Yield the messages of a bag in the order of the file.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    try:
        with path.open("rb") as file:
            packed = file.read(len(SQLITE_MAGIC)) == SQLITE_MAGIC
        yield from (_sqlite_messages if packed else _mcap_messages)(path)
    except (McapError, sqlite3.Error, OSError, ValueError, OverflowError) as error:
        raise WorkbenchError(f"{path}: cannot be read as a bag of ROS 2: {error}") from error


def _mcap_messages(path: Path) -> Iterator[BagMessage]:
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            known = schema is not None and schema.encoding == SchemaEncoding.ROS2
            if known and channel.message_encoding == MessageEncoding.CDR:
                text = schema.data.decode("utf-8", "replace")
                yield BagMessage(channel.topic, schema.name, text, message.log_time, message.data)


def _sqlite_messages(path: Path) -> Iterator[BagMessage]:
    """Yield the messages of a bag in SQLite; those before ROS 2 Iron define no types."""
    uri = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
    with closing(sqlite3.connect(uri, uri=True)) as base:
        base.execute("PRAGMA trusted_schema=OFF")
        tables = {name for (name,) in base.execute("SELECT name FROM sqlite_master")}
        definitions = {name: schema_text(name) for name in type_names()}
        if "message_definitions" in tables:
            definitions |= dict(
                base.execute(
                    "SELECT topic_type, encoded_message_definition FROM message_definitions "
                    "WHERE encoding = 'ros2msg'"
                )
            )
        topics = {
            number: (str(name), str(kind))
            for number, name, kind in base.execute(
                "SELECT id, name, type FROM topics WHERE serialization_format = 'cdr'"
            )
        }
        for number, t_ns, data in base.execute(
            "SELECT topic_id, timestamp, data FROM messages ORDER BY id"
        ):
            if number in topics and isinstance(t_ns, int) and isinstance(data, bytes):
                name, kind = topics[number]
                yield BagMessage(name, kind, str(definitions.get(kind, "")), t_ns, data)
