"""Reads MCAP files as far as they are whole, record by record from the beginning.

A file that was cut has no summary at its end, where the `mcap` package looks first; and its reader
ends with the first record that is damaged.
"""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema

from workbench.logs.mcap_writer import MAGIC

LARGEST_CHUNK = 64 * 1024 * 1024
"""Bytes of a chunk, unpacked; a file that says more is not believed."""
_HEAD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_BROKEN = (McapError, ValueError, KeyError, TypeError, struct.error, zstandard.ZstdError)
"""What reading a damaged record may raise."""


class Logged(NamedTuple):
    """A message: its channel's number, its time [ns], and its bytes."""

    channel: int
    t_ns: int
    data: bytes


@dataclass
class McapContents:
    """What was found in a file.

    Attributes:
        schemas: by their number.
        channels: by their number.
        attachments: by their name.
        metadata: by their name.
        messages: in the order of the file.
        closed: whether the file has its end.
        damaged: records that could not be read.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: list[Logged] = field(default_factory=list)
    closed: bool = False
    damaged: int = 0


def read_mcap(data: bytes, progress: Callable[[float], None] | None = None) -> McapContents:
    """Return what can be read of an MCAP file.

    Args:
        data: the file's bytes, beginning with MCAP's magic bytes.
        progress: takes the share done, 0 .. 1.
    """
    found = McapContents()
    for opcode, begin, end in _records(data, len(MAGIC)):
        if opcode in (Opcode.DATA_END, Opcode.FOOTER):
            found.closed = True
            break
        try:
            _take(found, opcode, data[begin:end])
        except _BROKEN:
            found.damaged += 1
        if progress:
            progress(end / len(data))
    return found


def _records(data: bytes, at: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, begin and end of each record that is whole."""
    while at + _HEAD.size <= len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        begin = at + _HEAD.size
        at = begin + length
        if at > len(data):
            return
        yield opcode, begin, at


def _take(found: McapContents, opcode: int, content: bytes) -> None:
    """Add a record to what was found."""
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
    found.messages.append(Logged(channel, t_ns, content[begin + _MESSAGE.size : end]))


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
