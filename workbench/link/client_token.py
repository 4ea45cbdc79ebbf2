"""The token that a client shows: that of its role, from a file that only its owner may read."""

import os
import stat
from pathlib import Path

from workbench.errors import WorkbenchError
from workbench.link.authentication import LARGEST_FILE
from workbench.link.backplane import Role


def read_token(path: Path | str, role: Role) -> str:
    """Return the token of a role from a server's token file, or from a copy of that one line.

    Whoever only watches needs no file with the token to fly.

    Raises:
        WorkbenchError: if the file cannot be read, is open to others, or has no such line.
    """
    for line in _private_lines(Path(path)):
        name, colon, token = line.partition(":")
        if colon and name.strip() == role.value and token.strip():
            return token.strip()
    raise WorkbenchError(
        f"{path}: has no line `{role.value}: TOKEN`: ask the server's owner for it"
    )


def _private_lines(path: Path) -> list[str]:
    try:
        # Looked at when open: a name can come to mean another file. A pipe must not make us wait.
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        with os.fdopen(number, "rb") as stream:
            mode = os.fstat(number).st_mode
            if not stat.S_ISREG(mode) or mode & 0o077:
                raise WorkbenchError(f"{path}: others may read it: run chmod 600 {path}")
            return stream.read(LARGEST_FILE).decode("utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise WorkbenchError(f"{path}: byte {error.start} is not UTF-8") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise WorkbenchError(f"{path}: cannot be read: {reason}") from None
