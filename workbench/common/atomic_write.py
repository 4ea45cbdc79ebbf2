"""Text files that are there as a whole: the old one until the new one is safe on the disk."""

import os
import uuid
from pathlib import Path

from workbench.common.errors import WorkbenchError


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
