"""Read and write plain files of limited size."""

import os
import stat
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, BinaryIO

from workbench.common.errors import WorkbenchError

_MIN_READ_BYTES = 1_000_000
"""Bytes asked for at least, as some files of the system state a size of 0."""


@contextmanager
def open_plain(path: Path | str, most: int | None = None) -> Iterator[BinaryIO]:
    """Open a file to read it; errors of reading within the block are sentences, too.

    Pipes and devices are rejected: a pipe may have no writer, and a device may never end.

    Args:
        path: the file.
        most: largest size [bytes]; None for no limit.

    Raises:
        WorkbenchError: if it does not exist, is not a plain file, is too large, or cannot be read.
    """
    try:
        with os.fdopen(_opened(path, most), "rb") as stream:
            yield stream
    except FileNotFoundError:
        raise WorkbenchError(f"{path}: no such file") from None
    except (OSError, ValueError, MemoryError) as error:
        reason = getattr(error, "strerror", None) or error or "it does not fit into memory"
        raise WorkbenchError(f"{path}: cannot be read: {reason}") from error


def _opened(path: Path | str, most: int | None) -> int:
    """Return the descriptor of a plain file of limited size."""
    # Checked on the open file, as another file may take the name; opening a pipe would block.
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    try:
        status = os.fstat(number)
        if not stat.S_ISREG(status.st_mode):
            what = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or a device"
            raise WorkbenchError(f"{path}: is {what}: name a plain file")
        if most is not None and status.st_size > most:
            raise WorkbenchError(f"{path}: is larger than {_size(most)}")
    except BaseException:
        os.close(number)
        raise
    return number


def read_plain(path: Path | str, most: int | None = None, first: int | None = None) -> bytes:
    """Return the content of a plain file, or its beginning; see `open_plain`.

    Args:
        path: the file.
        most: largest size [bytes]; None for no limit.
        first: number of bytes to read; None for all.

    Raises:
        WorkbenchError: if it does not exist, is not a plain file, is too large, or cannot be read.
    """
    with open_plain(path, most) as stream:
        wanted = most if first is None else first
        if wanted is None:
            return stream.read()
        # `read` reserves all the memory that it is asked for, before it reads.
        return stream.read(min(wanted, max(open_file_size(stream), _MIN_READ_BYTES)))


def open_file_size(stream: IO[bytes]) -> int:
    """Return the size of an open file [bytes]."""
    return os.fstat(stream.fileno()).st_size


def read_plain_text(path: Path | str, most: int, encoding: str = "utf-8") -> str:
    """Return the text of a file, with each line ended by a line feed alone.

    Args:
        path: the file.
        most: largest size [bytes].
        encoding: of the file; utf-8-sig skips a byte order mark.

    Raises:
        WorkbenchError: see `read_plain`, or if it is not a text.
    """
    data = read_plain(path, most)
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        raise WorkbenchError(f"{path}: byte {error.start} is not a text in UTF-8") from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _size(most: int) -> str:
    """Return a number of bytes as text."""
    return f"{most // 1_000_000} MB" if most > 1_000_000 else f"{most // 1000} kB"


def write_atomically(path: Path, text: str | bytes) -> None:
    """Write a file atomically, see `atomic_file`.

    Args:
        path: the file.
        text: its new content; a text is encoded in UTF-8.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    with atomic_file(path) as stream:
        stream.write(text if isinstance(text, bytes) else text.encode("utf-8"))


def write_in_folder(path: Path, text: str | bytes) -> Path:
    """Write a file as `write_atomically` does, make its folder if needed, and return its path."""
    make_folder(path.parent)
    write_atomically(path, text)
    return path


def make_folder(folder: Path) -> None:
    """Make a folder and those above it, if they do not exist.

    Raises:
        WorkbenchError: if it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WorkbenchError(f"{folder}: cannot be made: {error.strerror}") from error


@contextmanager
def atomic_file(path: Path) -> Iterator[BinaryIO]:
    """Yield a stream for the new content of a file, which appears when the block ends.

    On any failure an existing file stays unchanged. Until the end the content is in a file without
    a name, so nothing remains of a process that is killed. For a symbolic link the target is
    replaced. Permissions of a file are kept.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    partial = None
    try:
        target = path.resolve()
        named = target.with_name(f".{uuid.uuid4().hex}.part")
        try:
            number = os.open(target.parent, getattr(os, "O_TMPFILE", 0) | os.O_WRONLY, 0o666)
        except OSError:  # macOS and some network filesystems have no files without names
            number = os.open(named, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
            partial = named
        with os.fdopen(number, "wb") as stream:
            yield stream
            stream.flush()
            os.fsync(number)
            if target.exists():
                os.fchmod(number, stat.S_IMODE(target.stat().st_mode))
            if partial is None:
                partial = named
                # With a folder's descriptor it is `linkat`, which follows /proc's link to the file.
                os.link(f"/proc/self/fd/{number}", partial, src_dir_fd=number)
        partial.replace(target)
    except (OSError, RuntimeError) as error:  # links in a circle are a RuntimeError
        reason = getattr(error, "strerror", None) or error
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)
