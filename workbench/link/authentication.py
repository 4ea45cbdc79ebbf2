"""Authentication: tokens in a file, and how a client shows that it has one."""

import hashlib
import hmac
import os
import re
import secrets
import stat
from dataclasses import dataclass, field
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.link.message_json import LONGEST_TOKEN
from workbench.link.messages import Login, Role

MIN_TOKEN_CHARS = 16
MAX_TOKEN_FILE_BYTES = 4096
_TOKEN_LINE_PATTERN = re.compile(r"(view|command):\s*(\S+)")


@dataclass(frozen=True, slots=True)
class Tokens:
    """The tokens of a server.

    Attributes:
        view: token to watch.
        command: token to fly.
    """

    view: str = field(repr=False)
    command: str = field(repr=False)

    def of(self, role: Role) -> str:
        """Return the token of a role."""
        return self.command if role is Role.COMMAND else self.view


def new_token() -> str:
    """Return 24 random bytes as 48 hexadecimal digits, which no command takes for an option."""
    return secrets.token_hex(24)


def new_nonce() -> str:
    """Return 16 random bytes as 32 hexadecimal digits, never used before."""
    return secrets.token_hex(16)


def shows_token(login: Login, token: str, server_nonce: str) -> bool:
    """Return whether a login has the token of its role, or an older client's proof of it.

    Args:
        login: of the client, with a role.
        token: of that role.
        server_nonce: from hello, 32 hexadecimal digits.
    """
    if login.token:
        return is_same_proof(login.token, token)
    assert login.role is not None
    return is_same_proof(login.proof, login_proof(token, login.role, server_nonce, login.nonce))


def login_proof(token: str, role: Role, server_nonce: str, client_nonce: str) -> str:
    """Return the proof of an older client for login, 64 hexadecimal digits.

    Args:
        token: of the role.
        role: the requested one.
        server_nonce: from hello, 32 hexadecimal digits.
        client_nonce: from login, 32 hexadecimal digits.
    """
    nonces = bytes.fromhex(server_nonce) + bytes.fromhex(client_nonce)
    text = b"DH1 login" + Role(role).value.encode() + nonces
    return hmac.new(token.encode(), text, hashlib.sha256).hexdigest()


def is_same_proof(one: str, other: str) -> bool:
    """Return whether two tokens or proofs are equal, in constant time."""
    return hmac.compare_digest(one.encode(), other.encode())


def read_tokens(path: Path | str) -> Tokens:
    """Read a token file with lines `view: TOKEN` and `command: TOKEN`; # begins a comment.

    Raises:
        WorkbenchError: if it does not exist, others than its owner may access it, or it does not
            have two different printable tokens of `MIN_TOKEN_CHARS` characters or more.
    """
    found: dict[str, str] = {}
    for number, line in enumerate(private_text(Path(path)).splitlines(), start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        match = _TOKEN_LINE_PATTERN.fullmatch(text)
        if match is None or match[1] in found:  # never show the line: it may be a token
            raise WorkbenchError(
                f"{path}:{number}: expected one line `view: TOKEN` and one `command: TOKEN`"
            )
        if len(match[2]) < MIN_TOKEN_CHARS:
            raise WorkbenchError(
                f"{path}:{number}: the {match[1]} token has {len(match[2])} characters: "
                f"give it {MIN_TOKEN_CHARS} or more"
            )
        if len(match[2].encode()) > LONGEST_TOKEN or not match[2].isprintable():
            raise WorkbenchError(
                f"{path}:{number}: a token has at most {LONGEST_TOKEN} bytes, all printable"
            )
        found[match[1]] = match[2]
    missing = [name for name in ("view", "command") if name not in found]
    if missing:
        raise WorkbenchError(f"{path}: add a line `{missing[0]}: TOKEN`")
    if is_same_proof(found["view"], found["command"]):
        raise WorkbenchError(f"{path}: both tokens are the same: everybody who may watch could fly")
    return Tokens(found["view"], found["command"])


def write_tokens(path: Path | str) -> Tokens:
    """Write a token file with two random tokens, readable only by its owner.

    Raises:
        WorkbenchError: if the file exists, or cannot be written.
    """
    tokens = Tokens(new_token(), new_token())
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            with os.fdopen(number, "w", encoding="utf-8") as stream:
                stream.write(f"view: {tokens.view}\ncommand: {tokens.command}\n")
        except OSError:
            Path(path).unlink(missing_ok=True)
            raise
    except FileExistsError as error:
        raise WorkbenchError(f"{path}: exists already: use it, or remove it first") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error
    return tokens


def read_token(path: Path | str, role: Role) -> str:
    """Return the token of a role from the token file of a server, or from a copy of its one line.

    A client that only watches needs no file with the token to fly.

    Raises:
        WorkbenchError: if the file cannot be read, others may access it, or it has no such line.
    """
    for line in private_text(Path(path)).splitlines():
        name, colon, token = line.partition(":")
        if colon and name.strip() == role.value and token.strip():
            return token.strip()
    raise WorkbenchError(
        f"{path}: has no line `{role.value}: TOKEN`: ask the server's owner for it"
    )


def private_text(path: Path) -> str:
    """Return the text of a file that only its owner may read.

    Raises:
        WorkbenchError: if it cannot be read, others may access it, or it is too large.
    """
    try:
        # Checked on the open file, as another file may take the name. Opening a pipe must not
        # block.
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        with os.fdopen(number, "rb") as stream:
            status = os.fstat(number)
            if not stat.S_ISREG(status.st_mode):
                raise WorkbenchError(f"{path}: a token file must be a plain file")
            if status.st_mode & 0o077:
                raise WorkbenchError(
                    f"{path}: others may read it (mode {status.st_mode & 0o777:04o}): "
                    f"run chmod 600 {path}"
                )
            text = stream.read(MAX_TOKEN_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise WorkbenchError(f"{path}: cannot be read: {reason}") from error
    if len(text) > MAX_TOKEN_FILE_BYTES:
        raise WorkbenchError(f"{path}: a token file has at most {MAX_TOKEN_FILE_BYTES} bytes")
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError as error:
        raise WorkbenchError(f"{path}: byte {error.start} is not UTF-8") from error
