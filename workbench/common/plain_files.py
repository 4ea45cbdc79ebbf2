"""Files that are read: plain ones, whole, and no larger than makes sense."""

import os
import stat
import uuid
from pathlib import Path

from workbench.common.errors import WorkbenchError


def read_plain(path: Path | str, most: int | None = None, first: int | None = None) -> bytes:
    """Return the content of a file, or its beginning.

    A pipe or a device is refused: a pipe may have no writer, and a device may never end.

    Args:
        path: the file.
        most: bytes that it may have; any number without it.
        first: bytes to read; all without it.

    Raises:
        WorkbenchError: if there is none, or it is no plain file, too large, or cannot be read.
    """
    try:
        # Looked at when open, as a name can come to mean another file; a pipe would wait here.
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        with os.fdopen(number, "rb") as stream:
            status = os.fstat(number)
            if not stat.S_ISREG(status.st_mode):
                what = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or a device"
                raise WorkbenchError(f"{path}: is {what}: name a plain file")
            if most is not None and status.st_size > most:
                raise WorkbenchError(f"{path}: is larger than {_size(most)}")
            return stream.read(most if first is None else first)
    except FileNotFoundError:
        raise WorkbenchError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise WorkbenchError(f"{path}: is a folder: name a plain file") from None
    except (OSError, ValueError, MemoryError) as error:
        reason = getattr(error, "strerror", None) or error or "it does not fit into memory"
        raise WorkbenchError(f"{path}: cannot be read: {reason}") from error


def _size(most: int) -> str:
    """Return a number of bytes, for people."""
    return f"{most // 1_000_000} MB" if most > 1_000_000 else f"{most // 1000} kB"


def write_atomically(path: Path, text: str | bytes) -> None:
    """Write a file; whatever fails, a file that was there stays as it was.

    The text goes to a file beside it, which then takes its name. Of a symbolic link the target is
    replaced, and a file's permissions are kept.

    Args:
        path: the file.
        text: its new content; of a text the bytes in UTF-8.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    partial = None
    try:
        target = path.resolve()
        partial = target.with_name(f".{uuid.uuid4().hex}.part")
        with partial.open("xb") as stream:
            stream.write(text if isinstance(text, bytes) else text.encode("utf-8"))
            stream.flush()
            os.fsync(stream.fileno())
        if target.exists():
            partial.chmod(target.stat().st_mode)
        partial.replace(target)
    except (OSError, RuntimeError) as error:  # links in a circle are a RuntimeError
        reason = getattr(error, "strerror", None) or error
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)
