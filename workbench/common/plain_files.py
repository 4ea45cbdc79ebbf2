"""Read and write plain files of limited size."""

import os
import stat
import uuid
from pathlib import Path

from workbench.common.errors import WorkbenchError


def read_plain(path: Path | str, most: int | None = None, first: int | None = None) -> bytes:
    """Return the content of a file, or its beginning.

    Pipes and devices are rejected: a pipe may have no writer, and a device may never end.

    Args:
        path: the file.
        most: largest size [bytes]; None for no limit.
        first: number of bytes to read; None for all.

    Raises:
        WorkbenchError: if it does not exist, is not a plain file, is too large, or cannot be read.
    """
    try:
        # Checked on the open file, as another file may take the name; opening a pipe would block.
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
    """Return a number of bytes as text."""
    return f"{most // 1_000_000} MB" if most > 1_000_000 else f"{most // 1000} kB"


def write_atomically(path: Path, text: str | bytes) -> None:
    """Write a file atomically: on any failure an existing file stays unchanged.

    The text goes to a temporary file next to it, which is then renamed. For a symbolic link the
    target is replaced. Permissions of a file are kept.

    Args:
        path: the file.
        text: its new content; a text is encoded in UTF-8.

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
