"""Frames as bytes: a header of 24 bytes and a payload, see docs/protocol.md."""

import struct
from collections.abc import Generator
from dataclasses import dataclass
from enum import IntEnum, IntFlag

HEADER = struct.Struct("<2sBBHHIIq")
SEQ = slice(8, 12)
"""Place of a frame's number in its header, little-endian."""
MAGIC = b"DH"
VERSION = 1
LARGEST = 64 * 1024
"""Largest number of bytes after a header."""
LARGEST_BEFORE_LOGIN = 4 * 1024
"""The same, for a client before login."""
LARGEST_OPERATION = 8 * 1024
"""The same, for a client's frame with an operation, as reading JSON is slow. Setting all live
parameters at once, with all digits, needs a quarter of it."""
HMAC_SIZE = 16
SKIPPABLE = 0x80
"""Bit of a kind that a receiver may skip if unknown."""


class Kind(IntEnum):
    """The kind of payload of a frame."""

    CONTROL = 0
    """An operation, in JSON."""
    DATA = 1
    """The fields of a topic, as a packed structure."""
    ACKNOWLEDGEMENT = 2
    """Empty: `seq` is that of the last processed frame."""


KINDS = frozenset(int(each) for each in Kind)


class Flag(IntFlag):
    """Bits of the flags in a header."""

    HMAC = 1
    """A proof of 16 bytes follows the payload, and counts in the length."""
    ACKNOWLEDGE = 2
    """The last frame of a batch, which the receiver must acknowledge."""


_CONTROL = int(Kind.CONTROL)
_HMAC = int(Flag.HMAC)
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
class Frame:
    """One frame.

    Attributes:
        kind: see `Kind`; unknown kinds occur, too, if they may be skipped.
        topic: number of a topic, 0 for control.
        flags: see `Flag`.
        seq: increases with each frame of a connection and direction.
        t_ns: simulated time [ns]; in a command, that of the state it acts on.
        payload: without the proof.
        proof: 16 bytes, or none.
    """

    kind: int
    topic: int
    flags: int
    seq: int
    t_ns: int
    payload: bytes
    proof: bytes = b""

    def to_bytes(self) -> bytes:
        """Return the frame as bytes to send."""
        return self.signed_part() + self.proof

    def signed_part(self) -> bytes:
        """Return header and payload, the input of the proof.

        Raises:
            WireError: if the frame is too long for receivers.
        """
        length = len(self.payload) + (HMAC_SIZE if self.flags & _HMAC else 0)
        if length > LARGEST:
            raise _too_long(length, LARGEST)
        head = HEADER.pack(
            MAGIC, VERSION, self.kind, self.topic, self.flags, self.seq, length, self.t_ns
        )
        return head + self.payload


class Decoder:
    """Takes bytes in pieces of any size, and returns complete frames.

    The work per byte is bounded, however the bytes are split. Memory never exceeds one header,
    `largest` bytes and the last piece.

    Attributes:
        largest: bytes allowed after a header; more end the connection before they are read.
        largest_operation: the same if the payload is an operation.
    """

    def __init__(self, largest: int = LARGEST, largest_operation: int = LARGEST) -> None:
        self.largest = largest
        self.largest_operation = largest_operation
        self._kept = bytearray()
        self._needed = 1

    @property
    def waiting(self) -> int:
        """Number of bytes of an incomplete frame."""
        return len(self._kept)

    def feed(self, data: bytes) -> Generator[Frame]:
        """Take bytes, and return a generator of the frames now complete.

        Frames before an invalid one are yielded before it raises. It raises again when fed more, as
        nothing after that can be decoded. Frames not fetched come with the next call, even one
        without bytes.

        Raises:
            WireError: by the generator, if the bytes are not a frame.
        """
        self.keep(data)
        return self._frames()

    def keep(self, data: bytes) -> None:
        """Take bytes, and decode them later."""
        self._kept += data

    def next(self) -> Frame | None:
        """Return the next complete frame, or None.

        Raises:
            WireError: if the bytes are not a frame.
        """
        if len(self._kept) < self._needed:
            return None
        self._needed = 1
        end = self._next_end()
        if end > len(self._kept):
            if len(self._kept) >= HEADER.size:
                self._needed = end  # do not examine an incomplete frame at each piece
            return None
        _, _, kind, topic, flags, seq, _, t_ns = HEADER.unpack_from(self._kept)
        split = end - (HMAC_SIZE if flags & _HMAC else 0)
        payload, proof = bytes(self._kept[HEADER.size : split]), bytes(self._kept[split:end])
        del self._kept[:end]
        return Frame(kind, topic, flags, seq, t_ns, payload, proof)

    def _frames(self) -> Generator[Frame]:
        while (frame := self.next()) is not None:
            yield frame

    def _next_end(self) -> int:
        """Return the end of the next frame, as far as its header is known."""
        found = bytes(self._kept[: len(MAGIC)])
        if not MAGIC.startswith(found):  # raised at once: others may send no more than this
            raise WireError("magic", f"a frame begins with {found!r}: it must begin with {MAGIC!r}")
        if len(self._kept) < HEADER.size:
            return HEADER.size
        _, version, kind, _, flags, _, length, _ = HEADER.unpack_from(self._kept)
        self._check(version, kind, flags, length)
        return HEADER.size + length

    def _check(self, version: int, kind: int, flags: int, length: int) -> None:
        if version != VERSION:
            raise WireError(
                "version",
                f"the frame has version {version}: versions {VERSION} to {VERSION} are understood",
            )
        if kind not in KINDS and not kind & SKIPPABLE:
            raise WireError("kind", f"frames of kind {kind} are unknown and may not be skipped")
        if length > self.largest:
            raise _too_long(length, self.largest)
        if kind == _CONTROL and length > self.largest_operation:
            raise WireError(
                "length",
                f"an operation of {length} bytes is too long: {self.largest_operation} is the most",
            )
        if flags & _HMAC and length < HMAC_SIZE:
            raise WireError("length", f"a proof has {HMAC_SIZE} bytes: the frame has {length}")


def _too_long(length: int, largest: int) -> WireError:
    return WireError("length", f"{length} bytes after a header are too many: {largest} is the most")
