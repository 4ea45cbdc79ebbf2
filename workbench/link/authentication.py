"""Authentication: tokens in a file, and proofs of a token that do not reveal it."""

import hashlib
import hmac
import os
import re
import secrets
import stat
from dataclasses import dataclass, field, replace
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.link.messages import Role
from workbench.link.wire import HMAC_SIZE, Flag, Frame

SHORTEST_TOKEN = 16
LARGEST_FILE = 4096
_LINE = re.compile(r"(view|command):\s*(\S+)")


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


def new_nonce() -> str:
    """Return 16 random bytes as 32 hexadecimal digits, never used before."""
    return secrets.token_hex(16)


def login_proof(token: str, role: Role, server_nonce: str, client_nonce: str) -> str:
    """Return the proof of a client for login, 64 hexadecimal digits.

    Args:
        token: of the role.
        role: the requested one.
        server_nonce: from hello, 32 hexadecimal digits.
        client_nonce: from login, 32 hexadecimal digits.
    """
    nonces = bytes.fromhex(server_nonce) + bytes.fromhex(client_nonce)
    text = b"DH1 login" + Role(role).value.encode() + nonces
    return hmac.new(token.encode(), text, hashlib.sha256).hexdigest()


def session_key(token: str, server_nonce: str, client_nonce: str) -> bytes:
    """Return the key of 32 bytes for proofs of frames of this connection."""
    nonces = bytes.fromhex(server_nonce) + bytes.fromhex(client_nonce)
    return hmac.digest(token.encode(), b"DH1 session" + nonces, "sha256")


def frame_proof(key: bytes, signed_part: bytes) -> bytes:
    """Return the proof of 16 bytes that follows the payload of a frame.

    Args:
        key: of the session.
        signed_part: header and payload, with flag and length in the header as for a frame with
            proof.
    """
    return hmac.digest(key, signed_part, "sha256")[:HMAC_SIZE]


def prove(frame: Frame, key: bytes) -> Frame:
    """Return the frame with its proof."""
    marked = replace(frame, flags=frame.flags | Flag.HMAC)
    return replace(marked, proof=frame_proof(key, marked.signed_part()))


def is_proven(frame: Frame, key: bytes) -> bool:
    """Return whether a frame has a correct proof."""
    if not frame.flags & Flag.HMAC:
        return False
    return hmac.compare_digest(frame.proof, frame_proof(key, frame.signed_part()))


def is_same(one: str, other: str) -> bool:
    """Return whether two proofs are equal, in constant time."""
    return hmac.compare_digest(one.encode(), other.encode())


def read_tokens(path: Path | str) -> Tokens:
    """Read a token file with lines `view: TOKEN` and `command: TOKEN`; # begins a comment.

    Raises:
        WorkbenchError: if it does not exist, others than its owner may access it, or it does not
            have two different tokens of `SHORTEST_TOKEN` characters or more.
    """
    found: dict[str, str] = {}
    for number, line in enumerate(private_text(Path(path)).splitlines(), start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        match = _LINE.fullmatch(text)
        if match is None or match[1] in found:  # never show the line: it may be a token
            raise WorkbenchError(
                f"{path}:{number}: expected one line `view: TOKEN` and one `command: TOKEN`"
            )
        if len(match[2]) < SHORTEST_TOKEN:
            raise WorkbenchError(
                f"{path}:{number}: the {match[1]} token has {len(match[2])} characters: "
                f"give it {SHORTEST_TOKEN} or more"
            )
        found[match[1]] = match[2]
    missing = [name for name in ("view", "command") if name not in found]
    if missing:
        raise WorkbenchError(f"{path}: add a line `{missing[0]}: TOKEN`")
    if is_same(found["view"], found["command"]):
        raise WorkbenchError(f"{path}: both tokens are the same: everybody who may watch could fly")
    return Tokens(found["view"], found["command"])


def write_tokens(path: Path | str) -> Tokens:
    """Write a token file with two random tokens, readable only by its owner.

    Raises:
        WorkbenchError: if the file exists, or cannot be written.
    """
    tokens = Tokens(secrets.token_urlsafe(24), secrets.token_urlsafe(24))
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
            text = stream.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise WorkbenchError(f"{path}: cannot be read: {reason}") from error
    if len(text) > LARGEST_FILE:
        raise WorkbenchError(f"{path}: a token file has at most {LARGEST_FILE} bytes")
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError as error:
        raise WorkbenchError(f"{path}: byte {error.start} is not UTF-8") from error
