"""Read a log of any known format: our own, or one that an extension reads."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.plain_files import read_plain
from workbench.logs.readers.log_reader import (
    LOG_HEAD_BYTES,
    OWN_LOG_ENDING,
    LogFile,
    LogReader,
    known_log_formats,
    log_readers,
    reader_of,
)
from workbench.logs.readers.mcap_log import read_mcap
from workbench.logs.readers.packed import GZIP_MAGIC, PackedFile, log_stem, read_head
from workbench.logs.record import LogRecord

OWN_LIBRARY = b"workbench "
"""What the first record of our own logs has as the name of their writer."""
MAX_UNPACKED_COPY_BYTES = 120_000_000
"""Size limit of the content of a compressed file that a library reads [bytes]."""


def read_any(
    file: LogFile, folder: Path, progress: Callable[[float], None] | None = None
) -> LogRecord | Flight:
    """Return a log, as a `LogRecord` if it is in MCAP.

    A mapping determines the reader, then the first bytes of our own logs, then the readers in
    order of their places.

    Args:
        file: the log, see `known_log_formats`; it may be compressed with gzip.
        folder: for temporary files.
        progress: called with the share done, 0 .. 1, if known.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    path, mapping, number = file
    head = read_head(path, LOG_HEAD_BYTES)
    own = head.startswith(MCAP0_MAGIC) or path.suffix == OWN_LOG_ENDING
    if own and head.startswith(MCAP0_MAGIC) and OWN_LIBRARY not in head:
        own = reader_of(path, head) is None  # perhaps a bag of another program
    if own and mapping is None and number in (None, 1):
        return read_workbench_log(path, folder, progress)
    reader = reader_of(path, head) if mapping is None else _mapped_reader(path)
    several = reader is not None and reader.has_several
    if number not in (None, 1) and not several:
        raise WorkbenchError(f"{path}: has one log: --log-number {number} is not one of them")
    if own and mapping is None:
        return read_workbench_log(path, folder, progress)
    if mapping is None and not head:
        raise WorkbenchError(f"{path}: is empty: name {known_log_formats()}")
    if reader is None:
        raise WorkbenchError(f"{path}: is not a known kind of log: name {known_log_formats()}")
    return _read_by(reader, file._replace(number=number if several else None), folder)


def read_workbench_log(
    path: Path, folder: Path, progress: Callable[[float], None] | None = None
) -> LogRecord:
    """Return a log of the workbench; arguments and errors are those of `read_any`."""
    with _unpacked_file(path, folder) as (plain, remark):
        found = read_mcap(plain, progress)
    return replace(found, path=path, remark="; ".join(filter(None, (remark, found.remark))))


def _mapped_reader(path: Path) -> LogReader:
    """Return the reader of tables with a mapping.

    Raises:
        WorkbenchError: if there is none.
    """
    for reader in log_readers():
        if reader.takes_mapping:
            return reader
    raise WorkbenchError(
        f"{path}: no reader of tables with a mapping is there: name {known_log_formats()}"
    )


def _read_by(reader: LogReader, file: LogFile, folder: Path) -> Flight:
    """Read a log of another program.

    Raises:
        WorkbenchError: if the package of the reader is not there, or the log cannot be read.
    """
    path, package = file.path, reader.package
    if package and find_spec(package) is None:
        raise WorkbenchError(
            f"{path}: the format {reader.format} needs the package {package}: "
            f"`pip install {package}`"
        )
    if not reader.needs_plain:
        return reader.read(file)
    with _unpacked_file(path, folder) as (plain, remark):
        found = reader.read(file._replace(path=plain))
    remarks = tuple(filter(None, (remark, *found.remarks)))
    return replace(found, name=log_stem(path), source=path, remarks=remarks)


@contextmanager
def _unpacked_file(path: Path, folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield the file itself, or its unpacked copy if it is compressed, and a remark.

    Raises:
        WorkbenchError: if it cannot be unpacked, or is too large.
    """
    if not read_plain(path, first=len(GZIP_MAGIC)).startswith(GZIP_MAGIC):
        yield path, ""
        return
    packed, copy, size = PackedFile(path), folder / "unpacked", 0
    with copy.open("wb") as stream:
        for block in packed.blocks():
            size += stream.write(block)
            if size > MAX_UNPACKED_COPY_BYTES:
                raise WorkbenchError(
                    f"{path}: unpacks to more than {MAX_UNPACKED_COPY_BYTES // 1_000_000} MB: "
                    "unpack it "
                    "first (gunzip)"
                )
    try:
        yield copy, packed.remark
    except WorkbenchError as error:
        raise WorkbenchError(str(error).replace(str(copy), str(path))) from error
