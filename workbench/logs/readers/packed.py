"""Read log files, also compressed with gzip, within limits of size."""

import zlib
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain

LARGEST = 1_000_000_000
"""Size limit of an uncompressed log [bytes]."""
GZIP = b"\x1f\x8b"


def read_packed(path: Path) -> tuple[bytes, str]:
    """Return the content of a file, decompressed if it is a gzip file, and a remark.

    A truncated gzip file is read as far as possible, and the remark states this; else it is "".

    Raises:
        WorkbenchError: if it cannot be read, or is larger than `LARGEST`.
    """
    data = read_plain(path, LARGEST)
    if not data.startswith(GZIP):
        return data, ""
    parts: list[bytes] = []
    size, rest, remark = 0, data, ""
    try:
        while rest.startswith(GZIP):  # a gzip file may have several members
            unpack = zlib.decompressobj(wbits=31)
            part = unpack.decompress(rest, LARGEST + 1 - size)
            size += len(part)
            parts.append(part)
            if size > LARGEST:
                raise WorkbenchError(f"{path}: it is larger than {LARGEST // 10**6} MB")
            if not unpack.eof:
                remark = "the packed file ends before its content does: it was cut"
            rest = unpack.unused_data
    except zlib.error as error:
        if size == 0:
            raise WorkbenchError(f"{path}: cannot be unpacked: {error}") from error
        remark = f"the packed file is damaged behind {size} bytes of its content"
    return b"".join(parts), remark


def stem(path: Path) -> str:
    """Return the name of a log without its endings."""
    name = path.name.removesuffix(".gz")
    return name.rpartition(".")[0] or name


def read_head(path: Path, size: int) -> bytes:
    """Return the first bytes of a file, decompressed if it is a gzip file.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    data = read_plain(path, first=4096)
    if not data.startswith(GZIP):
        return data[:size]
    try:
        return zlib.decompressobj(wbits=31).decompress(data, size)
    except zlib.error as error:
        raise WorkbenchError(f"{path}: cannot be unpacked: {error}") from error
