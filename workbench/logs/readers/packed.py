"""Read log files, also compressed with gzip, within limits of size."""

import codecs
import io
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import open_file_size, open_plain, read_plain

MAX_WHOLE_LOG_BYTES = 1_000_000_000
"""Size limit of a log that is read as a whole, and of its content if it is compressed [bytes]."""
FREE_UNPACKED_BYTES = 64_000_000
MAX_UNPACKED_RATIO = 20
"""Any compressed content may have `FREE_UNPACKED_BYTES` bytes, and `MAX_UNPACKED_RATIO` for each
byte of the file."""
MAX_TABLE_LINE_CHARS = 1_000_000
"""Size limit of a line of a table [characters]."""
TABLE_ENCODING = "utf-8-sig"
WINDOWS_BYTES = "workbench-windows-1252"
"""How bytes that are not UTF-8 are decoded: as spreadsheets write them on Windows."""
GZIP_MAGIC = b"\x1f\x8b"
_READ_BLOCK_BYTES = 1 << 18


def _windows_characters(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeDecodeError)
    return error.object[error.start : error.end].decode("cp1252", "replace"), error.end


codecs.register_error(WINDOWS_BYTES, _windows_characters)


def max_unpacked_bytes(size: int) -> int:
    """Return the size limit of the content of a compressed file of a size [bytes]."""
    return FREE_UNPACKED_BYTES + MAX_UNPACKED_RATIO * size


class PackedFile:
    """The content of a file, decompressed if it is a gzip file; a part of it at a time.

    A truncated gzip file is read as far as possible.

    Attributes:
        path: the file.
        remark: whether the file is truncated or damaged, when all of it was read; else "".
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.remark = ""

    def blocks(self) -> Iterator[bytes]:
        """Yield the content.

        Raises:
            WorkbenchError: if it cannot be read, or is too large.
        """
        with open_plain(self.path, MAX_WHOLE_LOG_BYTES) as file:
            begin = file.read(_READ_BLOCK_BYTES)
            if begin.startswith(GZIP_MAGIC):
                for _ in self._unpacked(file, begin):
                    pass  # all that is too large is refused before anything is made of it
                file.seek(len(begin))
                yield from self._unpacked(file, begin)
                return
            while begin:
                yield begin
                begin = file.read(_READ_BLOCK_BYTES)

    def lines(self) -> Iterator[str]:
        """Yield the lines of a text, without their ends.

        Raises:
            WorkbenchError: as for `blocks`, or if a line is longer than any table's.
        """
        stream = io.BufferedReader(_BlockStream(self.blocks()), _READ_BLOCK_BYTES)
        with io.TextIOWrapper(stream, TABLE_ENCODING, WINDOWS_BYTES) as text:
            while line := text.readline(MAX_TABLE_LINE_CHARS):
                if len(line) == MAX_TABLE_LINE_CHARS:
                    raise WorkbenchError(
                        f"{self.path}: has a line of more than "
                        f"{MAX_TABLE_LINE_CHARS // 1_000_000} MB: it "
                        "is not a table"
                    )
                yield line.removesuffix("\n")

    def _unpacked(self, file: BinaryIO, rest: bytes) -> Iterator[bytes]:
        size, most = 0, min(max_unpacked_bytes(open_file_size(file)), MAX_WHOLE_LOG_BYTES)
        try:
            while rest.startswith(GZIP_MAGIC):  # a gzip file may have several members
                unpack = zlib.decompressobj(wbits=31)
                while not unpack.eof:
                    rest = rest or file.read(_READ_BLOCK_BYTES)
                    part = unpack.decompress(rest, _READ_BLOCK_BYTES)
                    if not part and not rest:
                        self.remark = "the packed file ends before its content does: it was cut"
                        return
                    rest = unpack.unconsumed_tail
                    size += len(part)
                    if size > most:
                        raise WorkbenchError(too_large(self.path, most, "gunzip"))
                    yield part
                rest = unpack.unused_data
                if len(rest) < len(GZIP_MAGIC):
                    rest += file.read(_READ_BLOCK_BYTES)
        except zlib.error as error:
            if size == 0:
                raise WorkbenchError(f"{self.path}: cannot be unpacked: {error}") from error
            self.remark = f"the packed file is damaged behind {size} bytes of its content"


class _BlockStream(io.RawIOBase):
    """A stream of blocks."""

    def __init__(self, blocks: Iterator[bytes]) -> None:
        self._blocks = blocks
        self._rest = memoryview(b"")

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: memoryview, /) -> int:  # type: ignore[override]
        while not self._rest:
            block = next(self._blocks, None)
            if block is None:
                return 0
            self._rest = memoryview(block)
        count = min(len(buffer), len(self._rest))
        buffer[:count], self._rest = self._rest[:count], self._rest[count:]
        return count


def too_large(path: Path, most: int, program: str) -> str:
    """Return the sentence about a compressed file with too much content.

    Args:
        path: the file.
        most: the limit [bytes].
        program: what unpacks it.
    """
    return (
        f"{path}: unpacks to more than {most // 1_000_000} MB, far more than a log of its size: if "
        f"you trust it, unpack it first ({program})"
    )


def log_stem(path: Path) -> str:
    """Return the name of a log without its endings."""
    name = path.name.removesuffix(".gz")
    return name.rpartition(".")[0] or name


def read_head(path: Path, size: int) -> bytes:
    """Return the first bytes of a file, decompressed if it is a gzip file.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    data = read_plain(path, first=max(4096, size))
    if not data.startswith(GZIP_MAGIC):
        return data[:size]
    try:
        return zlib.decompressobj(wbits=31).decompress(data, size)
    except zlib.error as error:
        raise WorkbenchError(f"{path}: cannot be unpacked: {error}") from error
