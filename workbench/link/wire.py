"""Frames as bytes: a header of 24 bytes and a payload, see docs/protocol.md."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag

FRAME_HEADER = struct.Struct("<2sBBHHIIq")
SEQ_SLICE = slice(8, 12)
"""Place of a frame's number in its header, little-endian."""
FRAME_MAGIC = b"DH"
PROTOCOL_VERSION = 1
MAX_PAYLOAD_BYTES = 64 * 1024
"""Largest number of bytes after a header."""
MAX_BYTES_BEFORE_LOGIN = 4 * 1024
"""The same, for a client before login."""
MAX_OPERATION_BYTES = 8 * 1024
"""The same, for a client's frame with an operation, as reading JSON is slow. Setting all live
parameters at once, with all digits, needs a quarter of it."""
PROOF_SIZE = 16
SKIPPABLE_BIT = 0x80
"""Bit of a kind that a receiver may skip if unknown."""


class FrameKind(IntEnum):
    """The kind of payload of a frame."""

    CONTROL = 0
    """An operation, in JSON."""
    DATA = 1
    """The fields of a topic, as a packed structure."""
    ACKNOWLEDGEMENT = 2
    """Empty: `seq` is that of the last processed frame."""


FRAME_KINDS = frozenset(int(each) for each in FrameKind)


class FrameFlag(IntFlag):
    """Bits of the flags in a header."""

    PROOF = 1
    """16 bytes follow the payload, and count in the length: an older client's proof of its token.
    They are dropped, and so is the flag."""
    ACKNOWLEDGE = 2
    """The last frame of a batch, which the receiver must acknowledge."""


_CONTROL_FRAME_KIND = int(FrameKind.CONTROL)
_PROOF = int(FrameFlag.PROOF)
"""A number, as an `IntFlag` takes longer than the rest of a frame."""


class WireError(Exception):
    """Received bytes are invalid, so the connection must end.

    Attributes:
        code: a word, for programs.
    """

    def __init__(self, code: str, said: str) -> None:
        super().__init__(said)
        self.code = code


@dataclass(frozen=True, slots=True)
class WireFrame:
    """One frame.

    Attributes:
        kind: see `FrameKind`; unknown kinds occur, too, if they may be skipped.
        topic: number of a topic, 0 for control.
        flags: see `FrameFlag`.
        seq: increases with each frame of a connection and direction.
        t_ns: simulated time [ns]; in a command, that of the state it acts on.
        payload: what follows the header.
    """

    kind: int
    topic: int
    flags: int
    seq: int
    t_ns: int
    payload: bytes

    def to_bytes(self) -> bytes:
        """Return the frame as bytes to send.

        Raises:
            WireError: if the frame is too long for receivers.
        """
        length = len(self.payload)
        if length > MAX_PAYLOAD_BYTES:
            raise _too_long(length, MAX_PAYLOAD_BYTES)
        head = FRAME_HEADER.pack(
            FRAME_MAGIC,
            PROTOCOL_VERSION,
            self.kind,
            self.topic,
            self.flags,
            self.seq,
            length,
            self.t_ns,
        )
        return head + self.payload


class Decoder:
    """Takes bytes in pieces of any size, and returns complete frames.

    The work per byte is bounded, however the bytes are split. Memory never exceeds one header,
    `largest` bytes and the last piece.

    Attributes:
        received: bytes that are not decoded yet; more may be appended.
        largest: bytes allowed after a header; more end the connection before they are read.
        largest_operation: the same if the payload is an operation.
    """

    def __init__(
        self, largest: int = MAX_PAYLOAD_BYTES, largest_operation: int = MAX_PAYLOAD_BYTES
    ) -> None:
        self.largest = largest
        self.largest_operation = largest_operation
        self.received = self._undecoded = bytearray()
        self._needed = 1

    @property
    def waiting(self) -> int:
        """Number of bytes of an incomplete frame."""
        return len(self._undecoded)

    def feed(self, data: bytes) -> Iterator[WireFrame]:
        """Take bytes, and return an iterator over the frames now complete.

        Frames before an invalid one are yielded before it raises. It raises again when fed more, as
        nothing after that can be decoded. Frames not fetched come with the next call, even one
        without bytes.

        Raises:
            WireError: by the iterator, if the bytes are not a frame.
        """
        self.received += data
        return iter(self.next, None)

    def next(self) -> WireFrame | None:
        """Return the next complete frame, or None.

        Raises:
            WireError: if the bytes are not a frame.
        """
        if len(self._undecoded) < self._needed:
            return None
        self._needed = 1
        end = self._next_end()
        if end > len(self._undecoded):
            if len(self._undecoded) >= FRAME_HEADER.size:
                self._needed = end  # do not examine an incomplete frame at each piece
            return None
        _, _, kind, topic, flags, seq, _, t_ns = FRAME_HEADER.unpack_from(self._undecoded)
        payload = bytes(self._undecoded[FRAME_HEADER.size : end - PROOF_SIZE * (flags & _PROOF)])
        del self._undecoded[:end]
        return WireFrame(kind, topic, flags & ~_PROOF, seq, t_ns, payload)

    def _next_end(self) -> int:
        """Return the end of the next frame, as far as its header is known."""
        found = bytes(self._undecoded[: len(FRAME_MAGIC)])
        if not FRAME_MAGIC.startswith(found):  # raised at once: others may send no more than this
            raise WireError(
                "magic", f"a frame begins with {found!r}: it must begin with {FRAME_MAGIC!r}"
            )
        if len(self._undecoded) < FRAME_HEADER.size:
            return FRAME_HEADER.size
        _, version, kind, _, flags, _, length, _ = FRAME_HEADER.unpack_from(self._undecoded)
        self._check(version, kind, flags, length)
        return FRAME_HEADER.size + length

    def _check(self, version: int, kind: int, flags: int, length: int) -> None:
        if version != PROTOCOL_VERSION:
            raise WireError(
                "version",
                f"the frame has version {version}: versions {PROTOCOL_VERSION} to "
                f"{PROTOCOL_VERSION} are understood",
            )
        if kind not in FRAME_KINDS and not kind & SKIPPABLE_BIT:
            raise WireError("kind", f"frames of kind {kind} are unknown and may not be skipped")
        if length > self.largest:
            raise _too_long(length, self.largest)
        if kind == _CONTROL_FRAME_KIND and length > self.largest_operation:
            raise WireError(
                "length",
                f"an operation of {length} bytes is too long: {self.largest_operation} is the most",
            )
        if flags & _PROOF and length < PROOF_SIZE:
            raise WireError("length", f"a proof has {PROOF_SIZE} bytes: the frame has {length}")


def _too_long(length: int, largest: int) -> WireError:
    return WireError("length", f"{length} bytes after a header are too many: {largest} is the most")
