"""Read the log of a flight, also from a file cut short by a crash or a full disk."""

import json
import os
import re
import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from io import BytesIO
from pathlib import Path

import numpy as np
import yaml
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema
from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_files import read_plain
from workbench.link.topics import Topic, topic_from
from workbench.logs.contents import (
    ACTIONS,
    CONTROLLER,
    ESTIMATOR,
    FLIGHT,
    GAINS,
    IMPORTED,
    LAW,
    LAWS,
    SCENARIO,
    SETTINGS,
    STATE,
    TOPICS,
    VERSIONS,
    read_action,
    read_gains,
    read_scenario,
)
from workbench.logs.flight_record import Signal
from workbench.logs.series import LoggedTopic
from workbench.scenario.scenario import Action, Scenario

LARGEST_CHUNK = 64 * 1024 * 1024
"""Largest size of an uncompressed chunk [bytes]; a file that states more is damaged."""
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_BROKEN = (
    McapError,
    ValueError,
    KeyError,
    TypeError,
    OverflowError,
    struct.error,
    zstandard.ZstdError,
)
"""Errors from reading a damaged record."""
_MEMORY = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
"""Memory of this machine [bytes]; a log is read as a whole."""


@dataclass
class McapContents:
    """The contents of a file.

    Attributes:
        schemas: by their number.
        channels: by their number.
        attachments: by their name.
        metadata: by their name.
        messages: in file order: number of the channel, time [ns] and bytes.
        closed: whether the file is complete.
        damaged: number of records that could not be read.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: list[tuple[int, int, bytes]] = field(default_factory=list)
    closed: bool = False
    damaged: int = 0


def read_mcap(data: bytes, progress: Callable[[float], None] | None = None) -> McapContents:
    """Return the readable contents of an MCAP file, record by record from the beginning.

    A truncated file has no summary at its end, where the `mcap` package looks first, and the reader
    of that package stops at the first damaged record.

    Args:
        data: the bytes of the file, beginning with MCAP's magic bytes.
        progress: called with the share done, 0 .. 1.
    """
    found = McapContents()
    for opcode, begin, end in _records(data, len(MCAP0_MAGIC)):
        if opcode == Opcode.DATA_END:
            found.closed = True  # its summary repeats schemas and channels of a damaged chunk
        try:
            _take(found, opcode, data[begin:end])
        except _BROKEN:
            found.damaged += 1
        if progress:
            progress(end / len(data))
    return found


def _records(data: bytes, at: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each complete record."""
    while at + _HEAD.size <= len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        begin = at + _HEAD.size
        at = begin + length
        if at > len(data):
            return
        yield opcode, begin, at


def _take(found: McapContents, opcode: int, content: bytes) -> None:
    """Add a record to the contents."""
    stream = ReadDataStream(BytesIO(content))
    match opcode:
        case Opcode.CHUNK:
            _take_chunk(found, Chunk.read(stream))
        case Opcode.SCHEMA:
            schema = Schema.read(stream)
            found.schemas[schema.id] = schema
        case Opcode.CHANNEL:
            channel = Channel.read(stream)
            found.channels[channel.id] = channel
        case Opcode.MESSAGE:
            _take_message(found, content, 0, len(content))
        case Opcode.ATTACHMENT:
            attachment = Attachment.read(stream)
            found.attachments[attachment.name] = attachment.data
        case Opcode.METADATA:
            metadata = Metadata.read(stream)
            found.metadata[metadata.name] = dict(metadata.metadata)


def _take_chunk(found: McapContents, chunk: Chunk) -> None:
    """Add the records of a chunk, all or none."""
    plain = _unpacked(chunk)
    if chunk.uncompressed_crc and zlib.crc32(plain) != chunk.uncompressed_crc:
        raise ValueError("the chunk is damaged")
    inside = McapContents(found.schemas, found.channels)
    for opcode, begin, end in _records(plain, 0):
        if opcode == Opcode.MESSAGE:
            _take_message(inside, plain, begin, end)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            _take(inside, opcode, plain[begin:end])
    found.messages += inside.messages


def _take_message(found: McapContents, content: bytes, begin: int, end: int) -> None:
    channel, _, t_ns, _ = _MESSAGE.unpack_from(content, begin)
    found.messages.append((channel, t_ns, content[begin + _MESSAGE.size : end]))


def _unpacked(chunk: Chunk) -> bytes:
    if not 0 <= chunk.uncompressed_size <= LARGEST_CHUNK:
        raise ValueError(f"a chunk of {chunk.uncompressed_size} bytes is too large")
    if chunk.compression == "zstd":
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


@dataclass(frozen=True, eq=False)
class Done:
    """An action in flight, with its time [s] and who did it."""

    by: str
    action: Action


@dataclass(frozen=True, eq=False)
class LogRecord:
    """A flight from its log.

    Attributes:
        path: of the log.
        vehicle: its name.
        physics_step: [s].
        versions: of the software that computed it, by name; see `versions`.
        scenario_text: the scenario flown, as YAML.
        settings: parameter values that replaced those of the scenario.
        values: all parameter values at the start.
        definitions: of the link's topics.
        topics: those with messages, by their short names, without the prefix /dh_drone/.
        remark: a sentence on what is missing, "" if nothing is.
        controller: name, file and sha256 of the control law; empty in logs of earlier versions.
        law: text of its file, "" in logs of earlier versions.
        estimator: name, file and sha256 of the user's own estimator; empty without one.
        laws: texts of laws that took over in flight, by the name in their action.
        imported: data of an imported log that are not in its messages, as JSON; "" for our own
            flights.
    """

    path: Path
    vehicle: str
    physics_step: float
    versions: Mapping[str, str]
    scenario_text: str
    settings: Mapping[str, float]
    values: Mapping[str, float]
    definitions: tuple[Topic, ...]
    topics: Mapping[str, LoggedTopic]
    remark: str
    controller: Mapping[str, str] = field(default_factory=dict)
    law: str = ""
    estimator: Mapping[str, str] = field(default_factory=dict)
    laws: Mapping[str, str] = field(default_factory=dict)
    imported: str = ""

    @property
    def duration(self) -> float:
        """Time of the last state [s], or of the last message in an imported log."""
        if self.imported:
            return max((topic.t_ns[-1] for topic in self.topics.values()), default=0) * 1e-9
        t_ns = self.state_ns
        return t_ns[-1] * 1e-9 if len(t_ns) else 0.0

    @property
    def state_ns(self) -> tuple[int, ...]:
        """Times of the exact states [ns]."""
        found = self.topics.get(_short(STATE.topic))
        return tuple(found.t_ns) if found else ()

    @cached_property
    def states(self) -> np.ndarray:
        """Exact states of the plant: q_WB, p_WB, w_WB, v_WB; (n, 13).

        Raises:
            WorkbenchError: if they have other fields in the log.
        """
        found = self.topics.get(_short(STATE.topic))
        if found is None:
            return np.zeros((0, 13))
        sizes = {"q_wb": 4, "p_wb": 3, "w_wb": 3, "v_wb": 3}
        names = [f"{name}.{index}" for name, size in sizes.items() for index in range(size)]
        missing = [name for name in names if name not in found.columns]
        if missing:
            raise WorkbenchError(
                f"{self.path}: its exact states have no {missing[0]}: it is damaged"
            )
        return np.column_stack([found.columns[name].values for name in names])

    @cached_property
    def done(self) -> tuple[Done, ...]:
        """All actions, in order.

        Raises:
            WorkbenchError: if this version of the workbench does not know an action.
        """
        found = self.topics.get(_short(ACTIONS.topic))
        if found is None:
            return ()
        try:
            columns = (found.columns[name].values for name in ("step", "by", "action"))
            return tuple(
                Done(str(by), read_action(int(step) * self.physics_step, str(text)))
                for step, by, text in zip(*columns, strict=True)
            )
        except (KeyError, ValueError, TypeError, AttributeError) as error:
            raise WorkbenchError(
                f"{self.path}: its record of commands cannot be read: {error}"
            ) from error

    def scenario(self) -> Scenario:
        """Return the scenario.

        Raises:
            WorkbenchError: if it is invalid for this version of the workbench.
        """
        if self.imported:
            raise WorkbenchError(
                f"{self.path}: comes from another program: it has no scenario to fly again"
            )
        try:
            return read_scenario(self.scenario_text)
        except (RuntimeError, TypeError, ValueError) as error:
            reason = " ".join(str(error).split())
            raise WorkbenchError(f"{self.path}: its scenario cannot be read: {reason}") from error

    def between(self, begin: float, end: float) -> "LogRecord":
        """Return the log with only the messages of a time span [s].

        Raises:
            WorkbenchError: if there are none.
        """
        topics = {name: topic.between(begin, end) for name, topic in self.topics.items()}
        kept = {name: topic for name, topic in topics.items() if topic.t_ns}
        if not kept:
            raise WorkbenchError(f"{self.path}: has nothing between {begin:g} and {end:g} s")
        return replace(self, topics=kept)

    def names(self) -> list[str]:
        """Return TOPIC.FIELD of every series."""
        return [series.name for topic in self.topics.values() for series in topic.columns.values()]

    def series(self, name: str) -> Signal:
        """Return a series by TOPIC.FIELD, such as velocity_data.v_x.

        Raises:
            WorkbenchError: if there is none; it suggests similar ones.
        """
        found = self.several(name)
        if len(found) > 1 or _short(name) != found[0].name:
            raise WorkbenchError(f"{name} has {len(found)} fields: name one, as {found[0].name}")
        return found[0]

    def several(self, name: str) -> list[Signal]:
        """Return the series of a TOPIC, of a TOPIC.FIELD, or of all components of a field.

        Raises:
            WorkbenchError: if there is none; it suggests similar ones.
        """
        topic, _, path = _short(name).partition(".")
        if topic not in self.topics:
            raise unknown_name("topic", topic, self.topics)
        columns = self.topics[topic].columns
        found = [
            series
            for each, series in columns.items()
            if not path or each == path or each.startswith(f"{path}.")
        ]
        if not found:
            raise unknown_name(f"field of {topic},", path, columns)
        return found


def read_log(path: Path, progress: Callable[[float], None] | None = None) -> LogRecord:
    """Read a log as far as it is readable.

    Args:
        path: the file.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if it cannot be read, or is not a log of the workbench.
    """
    data = read_plain(path, _MEMORY // 2)
    if not data:
        raise WorkbenchError(f"{path}: is empty: the flight ended before anything was written")
    if not data.startswith(MCAP0_MAGIC):
        raise WorkbenchError(f"{path}: is not an MCAP file: name a log that the workbench wrote")
    found = read_mcap(data, progress)
    topics = _topics(found)
    try:
        if IMPORTED in found.attachments:
            return _imported(path, found, topics)
        flight = found.metadata[FLIGHT]
        return LogRecord(
            path=path,
            vehicle=flight["vehicle"],
            physics_step=float(flight["physics_step"]),
            versions=found.metadata[VERSIONS],
            scenario_text=found.attachments[SCENARIO].decode(),
            settings={name: float(value) for name, value in found.metadata[SETTINGS].items()},
            values=read_gains(found.attachments[GAINS].decode()),
            definitions=tuple(map(topic_from, json.loads(found.attachments[TOPICS]))),
            topics=topics,
            remark=_remark(found),
            controller=found.metadata.get(CONTROLLER, {}),
            law=found.attachments.get(LAW, b"").decode(),
            estimator=found.metadata.get(ESTIMATOR, {}),
            laws={
                name: data.decode()
                for name, data in found.attachments.items()
                if name.startswith(LAWS)
            },
        )
    except (KeyError, ValueError, TypeError, yaml.YAMLError) as error:
        why = (
            "is an MCAP file, but not a log of the workbench"
            if found.closed and not found.damaged
            else "ends or is damaged before the flight begins: nothing can be read"
        )
        raise WorkbenchError(f"{path}: {why}") from error


def _imported(path: Path, found: McapContents, topics: Mapping[str, LoggedTopic]) -> LogRecord:
    """Return an imported log, which has neither a scenario nor parameters of the workbench.

    Raises:
        KeyError, TypeError, ValueError: if it is invalid.
    """
    text = found.attachments[IMPORTED].decode()
    about = json.loads(text)
    remarks = [_remark(found), *map(str, about["remarks"])]
    gaps = {
        str(each["name"]): [(float(a), float(b)) for a, b in each["gaps"]]
        for each in about["signals"]
    }
    return LogRecord(
        path=path,
        vehicle=str(about["name"]),
        physics_step=0.0,
        versions=found.metadata.get(VERSIONS, {}),
        scenario_text="",
        settings={},
        values={},
        definitions=(),
        topics={
            name: LoggedTopic(
                each.name, name, each.type, each.schema, each.t_ns, each.messages, gaps
            )
            for name, each in topics.items()
        },
        remark="; ".join(filter(None, remarks)),
        imported=text,
    )


def _topics(found: McapContents) -> dict[str, LoggedTopic]:
    """Return the topics that have messages, by their short names, in the order of the file."""
    times: dict[int, list[int]] = defaultdict(list)
    messages: dict[int, list[bytes]] = defaultdict(list)
    for number, t_ns, data in found.messages:
        times[number].append(t_ns)
        messages[number].append(data)
    topics = {}
    for number, channel in found.channels.items():
        schema = found.schemas.get(channel.schema_id)
        if number in messages and schema is not None:
            short = _short(channel.topic)
            topics[short] = LoggedTopic(
                channel.topic,
                short,
                schema.name,
                schema.data.decode("utf-8", "replace"),
                times[number],
                messages[number],
            )
    return topics


def _remark(found: McapContents) -> str:
    """Return a sentence on what is missing."""
    last = max((t_ns for _, t_ns, _ in found.messages), default=0) * 1e-9
    parts = []
    if not found.closed:
        parts.append(
            f"the log was not closed and ends at {last:.3f} s: up to a chunk after that is missing"
        )
    if found.damaged:
        parts.append(f"{found.damaged} damaged parts were left out")
    return "; ".join(parts)


def _short(topic: str) -> str:
    """Return the name of a topic as used on the command line."""
    return re.sub(r"^/(dh_drone/)?", "", topic)
