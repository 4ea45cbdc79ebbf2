"""The token that a client shows: that of its role, from a file that only its owner may read."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.link.authentication import private_text
from workbench.link.operations import Role


def read_token(path: Path | str, role: Role) -> str:
    """Return the token of a role from a server's token file, or from a copy of that one line.

    Whoever only watches needs no file with the token to fly.

    Raises:
        WorkbenchError: if the file cannot be read, is open to others, or has no such line.
    """
    for line in private_text(Path(path)).splitlines():
        name, colon, token = line.partition(":")
        if colon and name.strip() == role.value and token.strip():
            return token.strip()
    raise WorkbenchError(
        f"{path}: has no line `{role.value}: TOKEN`: ask the server's owner for it"
    )
