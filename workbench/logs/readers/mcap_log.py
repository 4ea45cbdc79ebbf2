"""Read our own logs, in MCAP, also files cut short by a crash or a full disk.

The reader of the `mcap` package looks at the summary first, which a truncated file lacks, and stops
at the first damaged record. Here a file is read record by record, a chunk at a time.
"""

import dataclasses
import json
import re
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import yaml
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError
from workbench.common.flight import MAX_LOG_TIME_S
from workbench.common.plain_files import open_file_size, open_plain
from workbench.common.yaml_files import MAX_YAML_BYTES, reject_costly_yaml
from workbench.link.ros_messages.namespace import link_topic, ros_namespace
from workbench.logs.contents import (
    CONTROLLER_METADATA,
    ESTIMATOR_METADATA,
    FLIGHT_METADATA,
    GAINS_ATTACHMENT,
    IMPORTED_ATTACHMENT,
    JOINTS_METADATA,
    LAW_ATTACHMENT,
    LAW_ATTACHMENT_PREFIX,
    SCENARIO_ATTACHMENT,
    SETTINGS_METADATA,
    VERSIONS_METADATA,
    read_gains,
)
from workbench.logs.logged_topic import LoggedTopic
from workbench.logs.readers.messages import Messages, read_topic
from workbench.logs.readers.packed import max_unpacked_bytes, too_large
from workbench.logs.record import LogRecord

MAX_MCAP_RECORD_BYTES = 64 * 1024 * 1024
"""Largest size of a record, and of an unpacked chunk [bytes]; one that states more is damaged."""
MAX_MCAP_SCHEMA_BYTES = 4_000_000
"""Largest size of the definition of a topic's messages [bytes]."""
MAX_MCAP_TOPICS = 2000
MAX_LOG_TIME_NS = round(MAX_LOG_TIME_S * 1e9)
_RECORD_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQ")
"""Beginning of a chunk: times of its first and last message, and its unpacked size."""
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_MESSAGE_RECORD_HEAD = struct.Struct("<BQHIQQ")
"""Beginning of a message with its head; schemas and channels are longer than that."""
_TOPIC_NAME_PATTERN = re.compile(r"[A-Za-z0-9_/]+")
_DAMAGE_ERRORS = (
    McapError,
    ValueError,
    KeyError,
    TypeError,
    OverflowError,
    struct.error,
    zstandard.ZstdError,
)
"""Errors from reading a damaged record."""


@dataclass
class McapContents:
    """The contents of a file.

    Attributes:
        schemas: by their number.
        channels: by their number.
        attachments: by their name.
        metadata: by their name.
        messages: by the number of their channel, in file order.
        closed: whether the file is complete.
        damaged: number of parts that could not be read.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: dict[int, Messages] = field(default_factory=lambda: defaultdict(Messages))
    closed: bool = False
    damaged: int = 0


def read_mcap(path: Path, progress: Callable[[float], None] | None = None) -> LogRecord:
    """Read a log as far as it is readable.

    Args:
        path: the file.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if it cannot be read, or is not a log of the workbench.
    """
    with open_plain(path) as file:
        magic = file.read(len(MCAP0_MAGIC))
        if not magic:
            raise WorkbenchError(f"{path}: is empty: the flight ended before anything was written")
        if magic != MCAP0_MAGIC:
            raise WorkbenchError(
                f"{path}: is not an MCAP file: name a log that the workbench wrote"
            )
        _check_unpacked_size(path, file)
        found = _contents(file, progress)
    try:
        return _record_of_contents(path, found)
    except (*_DAMAGE_ERRORS, yaml.YAMLError, RecursionError) as error:
        why = (
            "is an MCAP file, but not a log of the workbench"
            if found.closed and not found.damaged
            else "ends or is damaged before the flight begins: nothing can be read"
        )
        raise WorkbenchError(f"{path}: {why}") from error


def _check_unpacked_size(path: Path, file: BinaryIO) -> None:
    """Check what the chunks state before anything is unpacked; no chunk may have more than that.

    Raises:
        WorkbenchError: if it is more than any log of this size has.
    """
    total, most = 0, max_unpacked_bytes(open_file_size(file))
    for opcode, begin, _ in _records_of(file):
        if opcode == Opcode.CHUNK:
            file.seek(begin)
            head = file.read(_CHUNK_HEAD.size)
            size = _CHUNK_HEAD.unpack(head)[2] if len(head) == _CHUNK_HEAD.size else 0
            total += size if size <= MAX_MCAP_RECORD_BYTES else 0
    if total > most:
        raise WorkbenchError(too_large(path, most, "mcap decompress"))


def _records_of(file: BinaryIO) -> Iterator[tuple[int, int, int]]:
    """Yield kind, begin and end of each complete record of a file, which may be moved in between.

    Zeros, which a file system may leave behind the last record after a crash, end it.
    """
    at, size = len(MCAP0_MAGIC), open_file_size(file)
    while at + _RECORD_HEAD.size <= size:
        file.seek(at)
        opcode, length = _RECORD_HEAD.unpack(file.read(_RECORD_HEAD.size))
        begin = at + _RECORD_HEAD.size
        at = begin + length
        if at > size or opcode == 0:
            return
        yield opcode, begin, at


def _contents(file: BinaryIO, progress: Callable[[float], None] | None) -> McapContents:
    """Return the readable contents of a file."""
    found, size = McapContents(), open_file_size(file)
    for opcode, begin, end in _records_of(file):
        if opcode == Opcode.DATA_END:
            found.closed = True  # its summary repeats schemas and channels of a damaged chunk
        try:
            if end - begin > MAX_MCAP_RECORD_BYTES:
                raise ValueError(f"a record of {end - begin} bytes is too large")
            file.seek(begin)
            _take(found, opcode, file.read(end - begin))
        except _DAMAGE_ERRORS:
            found.damaged += 1
        if progress:
            progress(end / size)
    return found


def _take(found: McapContents, opcode: int, content: bytes) -> None:
    """Add a record to the contents."""
    match opcode:
        case Opcode.CHUNK:
            _take_chunk(found, Chunk.read(ReadDataStream(BytesIO(content))))
        case Opcode.ATTACHMENT:
            attachment = Attachment.read(ReadDataStream(BytesIO(content)))
            found.attachments[attachment.name] = attachment.data
        case Opcode.METADATA:
            metadata = Metadata.read(ReadDataStream(BytesIO(content)))
            found.metadata[metadata.name] = dict(metadata.metadata)
        case _:
            _take_small(found, opcode, memoryview(content))


def _take_small(found: McapContents, opcode: int, content: memoryview) -> None:
    """Add a record that may be in a chunk."""
    match opcode:
        case Opcode.MESSAGE:
            channel, _, t_ns, _ = _MESSAGE_HEAD.unpack_from(content)
            if t_ns > MAX_LOG_TIME_NS:
                raise ValueError("a time is damaged")
            found.messages[channel].add(t_ns, content[_MESSAGE_HEAD.size :])
        case Opcode.SCHEMA:
            if len(content) > MAX_MCAP_SCHEMA_BYTES:
                raise ValueError(f"a schema of {len(content)} bytes is too large")
            schema = Schema.read(ReadDataStream(BytesIO(content)))
            found.schemas[schema.id] = schema
        case Opcode.CHANNEL:
            channel = Channel.read(ReadDataStream(BytesIO(content)))
            if (
                not _TOPIC_NAME_PATTERN.fullmatch(channel.topic)
                or len(found.channels) >= MAX_MCAP_TOPICS
            ):
                raise ValueError("a topic's name is damaged, or there are too many")
            found.channels[channel.id] = channel


def _take_chunk(found: McapContents, chunk: Chunk) -> None:
    """Add the records of a chunk, as far as it is intact."""
    plain = _unpacked(chunk)
    if chunk.uncompressed_crc and zlib.crc32(plain) != chunk.uncompressed_crc:
        raise ValueError("the chunk is damaged")
    whole, at, size = memoryview(plain), 0, len(plain)
    unpack, shortest, head, message = (
        _MESSAGE_RECORD_HEAD.unpack_from,
        _MESSAGE_RECORD_HEAD.size,
        _RECORD_HEAD.size,
        Opcode.MESSAGE,
    )
    while at + shortest <= size:
        opcode, length, channel, _, t_ns, _ = unpack(plain, at)
        begin, at = at + head, at + head + length
        if at > size:
            return
        if opcode == message and at >= begin + shortest - head and t_ns <= MAX_LOG_TIME_NS:
            messages = found.messages[channel]  # as `add`, which would take as long again
            messages.t_ns.append(t_ns)
            messages.sizes.append(at - begin - shortest + head)
            messages.data += whole[begin + shortest - head : at]
            continue
        try:
            _take_small(found, opcode, whole[begin:at])
        except _DAMAGE_ERRORS:
            found.damaged += 1


def _unpacked(chunk: Chunk) -> bytes:
    if not 0 <= chunk.uncompressed_size <= MAX_MCAP_RECORD_BYTES:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes is too large")
    if chunk.compression == "zstd":
        stated = zstandard.frame_content_size(chunk.data)  # -1 if it states none
        if stated > chunk.uncompressed_size:  # zstandard would reserve so much
            raise ValueError("the chunk is damaged")
        unpacked = zstandard.ZstdDecompressor().decompress(
            chunk.data, max_output_size=max(chunk.uncompressed_size, 1)
        )
    elif chunk.compression == "":
        unpacked = chunk.data
    else:
        raise ValueError(f"chunks packed with {chunk.compression} are not ours")
    if len(unpacked) != chunk.uncompressed_size:
        raise ValueError("the chunk is damaged")
    return unpacked


def _record_of_contents(path: Path, found: McapContents) -> LogRecord:
    """Return the log with these contents.

    Raises:
        KeyError, TypeError, ValueError: if it is not a log of the workbench.
    """
    remark = _missing_remark(found)
    if IMPORTED_ATTACHMENT in found.attachments:
        return _imported(path, found, remark)
    flight, gains = found.metadata[FLIGHT_METADATA], found.attachments[GAINS_ATTACHMENT].decode()
    if len(gains) > MAX_YAML_BYTES:
        raise ValueError("its gains are too large")
    reject_costly_yaml(path / GAINS_ATTACHMENT, gains)
    return LogRecord(
        path=path,
        vehicle=flight["vehicle"],
        physics_step=float(flight["physics_step"]),
        versions=found.metadata[VERSIONS_METADATA],
        scenario_text=found.attachments[SCENARIO_ATTACHMENT].decode(),
        settings={name: float(value) for name, value in found.metadata[SETTINGS_METADATA].items()},
        values=read_gains(gains),
        topics=_topics_with_messages(found, flight["vehicle"]),
        remark=remark,
        controller=found.metadata.get(CONTROLLER_METADATA, {}),
        law=found.attachments.get(LAW_ATTACHMENT, b"").decode(),
        estimator=found.metadata.get(ESTIMATOR_METADATA, {}),
        laws={
            name: data.decode()
            for name, data in found.attachments.items()
            if name.startswith(LAW_ATTACHMENT_PREFIX)
        },
    )


def _imported(path: Path, found: McapContents, remark: str) -> LogRecord:
    """Return an imported log, which has neither a scenario nor parameters of the workbench.

    Raises:
        KeyError, TypeError, ValueError: if it is invalid.
    """
    text = found.attachments[IMPORTED_ATTACHMENT].decode()
    about = json.loads(text)
    return LogRecord(
        path=path,
        vehicle=str(about["name"]),
        physics_step=0.0,
        versions=found.metadata.get(VERSIONS_METADATA, {}),
        scenario_text="",
        settings={},
        values={},
        topics=_topics_with_messages(found, str(about["name"])),
        remark="; ".join(filter(None, [remark, *map(str, about["remarks"])])),
        imported=text,
    )


def _topics_with_messages(found: McapContents, vehicle: str) -> dict[str, LoggedTopic]:
    """Return the topics that have messages, by their short names, in the order of the file.

    Those in the vehicle's namespace get the names of the link, as in logs of earlier versions. The
    bytes of each topic are given up when it is decoded.
    """
    topics, namespace = {}, ros_namespace(vehicle)
    for number, channel in found.channels.items():
        schema = found.schemas.get(channel.schema_id)
        messages = found.messages.pop(number, None)
        if messages is None or schema is None:
            continue
        text = schema.data.decode("utf-8", "replace")
        name = link_topic(channel.topic, namespace)
        topic = read_topic(name, schema.name, text, messages)
        topics[topic.short] = _with_joint_units(topic, found.metadata.get(JOINTS_METADATA, {}))
    return topics


def _with_joint_units(topic: LoggedTopic, units: Mapping[str, str]) -> LoggedTopic:
    """Return a topic in which values of joints, as in "rad or m", have the unit of their joint."""

    def known(path: str, unit: str) -> str:
        turning, _, sliding = unit.partition(" or ")
        names = topic.fields.get(f"name.{path.rpartition('.')[2]}")
        joint = str(names.values[0]) if sliding and names and len(names.values) else ""
        return {"rad": turning, "m": sliding}.get(units.get(joint, ""), unit)

    fields = {
        path: dataclasses.replace(each, unit=known(path, each.unit))
        for path, each in topic.fields.items()
    }
    return dataclasses.replace(topic, fields=fields)


def _missing_remark(found: McapContents) -> str:
    """Return a sentence on what is missing."""
    parts = []
    if not found.closed:
        last = max((max(each.t_ns) for each in found.messages.values()), default=0) * 1e-9
        parts.append(
            f"the log was not closed and ends at {last:.3f} s: up to a chunk after that is missing"
        )
    if found.damaged:
        parts.append(f"{found.damaged} damaged parts were left out")
    return "; ".join(parts)
