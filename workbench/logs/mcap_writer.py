"""Write MCAP files: messages in chunks, each written as soon as it is full.

The writer of the `mcap` package takes five times as long per message, too long in flight. Records
other than messages and their index are those of the package.
"""

import os
import struct
import zlib
from array import array
from collections.abc import Mapping
from pathlib import Path

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
CHUNK_SIZE = 128 * 1024
"""Bytes of messages in a chunk, before it is compressed."""
COMPRESSION = 1
"""Compression level of zstd, the fastest."""
_MESSAGE = struct.Struct("<BQHIQQ")
_MESSAGE_CODE = int(Opcode.MESSAGE)
_MESSAGE_HEAD = 22
"""Bytes in the record of a message before its data, after opcode and length."""
_INDEX = struct.Struct("<BQHI")
_FOOTER = struct.Struct("<BQQQ")


class McapWriter:
    """An MCAP file that grows.

    Args:
        path: the file; an existing one is overwritten.
        library: name of the writer, for the header of the file.

    Raises:
        OSError: from any method, if the file cannot be written.
    """

    def __init__(self, path: Path, library: str) -> None:
        self._path = path
        self._file = path.open("wb", buffering=0)
        self._at = 0
        self._compressor = zstandard.ZstdCompressor(level=COMPRESSION)
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._counts: list[int] = [0]  # the number of a channel is its index
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._chunks: list[ChunkIndex] = []
        self._begin_chunk()
        self._write(MAGIC + _bytes(Header("ros2", library)))

    @property
    def size(self) -> int:
        """Bytes of complete records in the file."""
        return self._at

    def is_in_place(self) -> bool:
        """Return whether the path still refers to the file."""
        try:
            there = self._path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:  # unknown, and writing continues
            return True
        mine = os.fstat(self._file.fileno())
        return (there.st_dev, there.st_ino) == (mine.st_dev, mine.st_ino)

    def add_schema(self, name: str, text: str) -> int:
        """Add a type of ROS 2 messages, and return its number."""
        number = len(self._schemas) + 1
        self._schemas.append(Schema(number, text.encode(), "ros2msg", name))
        self._write(_bytes(self._schemas[-1]))
        return number

    def add_channel(self, topic: str, schema: int, metadata: Mapping[str, str]) -> int:
        """Add a topic with messages in CDR, and return its number."""
        number = len(self._counts)
        self._counts.append(0)
        self._channels.append(Channel(number, topic, "cdr", dict(metadata), schema))
        self._write(_bytes(self._channels[-1]))
        return number

    def attach(self, name: str, media_type: str, data: bytes, created: int) -> None:
        """Add an attachment; `created` is in nanoseconds since 1970."""
        record = _bytes(Attachment(created, created, name, media_type, data))
        index = AttachmentIndex(
            self._at, len(record), created, created, len(data), name, media_type
        )
        self._write(record)
        self._attachments.append(index)

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Add names and values."""
        record = _bytes(Metadata(name, dict(values)))
        index = MetadataIndex(self._at, len(record), name)
        self._write(record)
        self._metadata.append(index)

    def message(self, channel: int, t_ns: int, wall_ns: int, data: bytes) -> None:
        """Add a message of a simulated time [ns], published at a wall time [ns since 1970]."""
        chunk, count = self._chunk, self._counts[channel]
        index = self._indices.get(channel)
        if index is None:
            index = self._indices[channel] = array("Q")
        index.extend((t_ns, len(chunk)))
        self._counts[channel] = count + 1
        chunk += _MESSAGE.pack(
            _MESSAGE_CODE, _MESSAGE_HEAD + len(data), channel, count & 0xFFFFFFFF, t_ns, wall_ns
        )
        chunk += data
        if len(chunk) >= CHUNK_SIZE:
            self.end_chunk()

    def end_chunk(self) -> None:
        """Write the messages since the last chunk."""
        if not self._chunk:
            return
        plain, indices = bytes(self._chunk), self._indices
        times = [t_ns for index in indices.values() for t_ns in index[::2]]
        begin, end = min(times), max(times)
        data = self._compressor.compress(plain)
        record = _bytes(Chunk("zstd", data, end, begin, zlib.crc32(plain), len(plain)))
        at = self._at + len(record)
        parts, offsets = [record], {}
        for channel, index in indices.items():
            entries = index.tobytes()
            parts.append(
                _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + len(entries), channel, len(entries)) + entries
            )
            offsets[channel] = at
            at += len(parts[-1])
        index_length = at - self._at - len(record)
        chunk = ChunkIndex(
            len(record), self._at, "zstd", len(data), end, index_length, offsets, begin, len(plain)
        )
        self._write(b"".join(parts))
        self._chunks.append(chunk)
        self._begin_chunk()

    def finish(self) -> None:
        """Write the messages since the last chunk and the summary, and close the file."""
        self.end_chunk()
        self._write(_bytes(DataEnd(0)) + self._summary())
        self._file.close()

    def give_up(self) -> None:
        """Close the file with its complete records.

        Raises:
            OSError: if the incomplete rest cannot be cut off.
        """
        try:
            self._file.truncate(self._at)
        finally:
            self._file.close()

    def _summary(self) -> bytes:
        """Return the summary with its offsets and the footer, to follow DataEnd."""
        begin = self._at + len(_bytes(DataEnd(0)))
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas]),
            (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, [*self._chunks]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachments]),
            (Opcode.METADATA_INDEX, [*self._metadata]),
        ]
        data, offsets = b"", b""
        for opcode, records in groups:
            group = b"".join(map(_bytes, records))
            if group:
                offsets += _bytes(SummaryOffset(opcode, begin + len(data), len(group)))
            data += group
        offsets_begin = begin + len(data)
        data += offsets
        crc = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, 20, begin, offsets_begin), zlib.crc32(data))
        return data + _bytes(Footer(begin, offsets_begin, crc)) + MAGIC

    def _statistics(self) -> Statistics:
        counts = {number: count for number, count in enumerate(self._counts) if count}
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=counts,
            chunk_count=len(self._chunks),
            message_count=sum(counts.values()),
            message_end_time=max((each.message_end_time for each in self._chunks), default=0),
            message_start_time=min((each.message_start_time for each in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )

    def _begin_chunk(self) -> None:
        self._chunk = bytearray()
        self._indices: dict[int, array[int]] = {}

    def _write(self, data: bytes) -> None:
        """Write bytes to the system; only then they count."""
        rest = memoryview(data)
        while rest:
            rest = rest[self._file.write(rest) or 0 :]
        self._at += len(data)


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
