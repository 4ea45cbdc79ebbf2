"""Frames as bytes: a header of 24 bytes and a payload, see docs/protocol.md."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum, IntFlag

HEADER = struct.Struct("<2sBBHHIIq")
MAGIC = b"DH"
VERSION = 1
LARGEST = 64 * 1024
"""Bytes that may follow a header."""
LARGEST_BEFORE_LOGIN = 4 * 1024
"""The same of a client that is not logged in."""
HMAC_SIZE = 16
SKIPPABLE = 0x80
"""Bit of a kind that a receiver may skip where it does not know it."""


class Kind(IntEnum):
    """What a frame's payload is."""

    CONTROL = 0
    """An operation, in JSON."""
    DATA = 1
    """A topic's fields, as a packed structure."""
    ACKNOWLEDGEMENT = 2
    """Nothing: `seq` is that of the last frame that was processed."""


class Flag(IntFlag):
    """Bits of a header's flags."""

    HMAC = 1
    """16 bytes that prove the sender follow the payload, and count in the length."""
    ACKNOWLEDGE = 2
    """The last frame of a batch: the receiver is to acknowledge it."""


class WireError(Exception):
    """What arrived cannot be understood, so the connection must end.

    Attributes:
        code: a word for programs.
    """

    def __init__(self, code: str, said: str) -> None:
        super().__init__(said)
        self.code = code


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame.

    Attributes:
        kind: see `Kind`; unknown ones arrive too, where they may be skipped.
        topic: number of a topic, 0 for control.
        flags: see `Flag`.
        seq: rises with each frame of a connection and direction.
        t_ns: simulated time [ns]; in a command, that of the state acted on.
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
        """Return the frame as it is sent."""
        return self.signed_part() + self.proof

    def signed_part(self) -> bytes:
        """Return header and payload: what the proof is taken of."""
        length = len(self.payload) + (HMAC_SIZE if self.flags & Flag.HMAC else 0)
        head = HEADER.pack(
            MAGIC, VERSION, self.kind, self.topic, self.flags, self.seq, length, self.t_ns
        )
        return head + self.payload


class Decoder:
    """Takes bytes as they come, in any pieces, and returns whole frames.

    Attributes:
        largest: bytes that may follow a header; more ends the connection before they are read.
    """

    def __init__(self, largest: int = LARGEST) -> None:
        self.largest = largest
        self._kept = bytearray()

    @property
    def waiting(self) -> int:
        """Bytes of a frame that is not whole yet."""
        return len(self._kept)

    def feed(self, data: bytes) -> Iterator[Frame]:
        """Yield the frames that are whole now.

        Raises:
            WireError: if what came is no frame; nothing after it can be understood.
        """
        self._kept += data
        begin = 0
        try:
            while len(self._kept) - begin >= HEADER.size:
                magic, version, kind, topic, flags, seq, length, t_ns = HEADER.unpack_from(
                    self._kept, begin
                )
                self._check(magic, version, kind, flags, length)
                end = begin + HEADER.size + length
                if len(self._kept) < end:
                    return
                split = end - (HMAC_SIZE if flags & Flag.HMAC else 0)
                payload = bytes(self._kept[begin + HEADER.size : split])
                proof = bytes(self._kept[split:end])
                begin = end
                yield Frame(kind, topic, flags, seq, t_ns, payload, proof)
        finally:
            del self._kept[:begin]

    def _check(self, magic: bytes, version: int, kind: int, flags: int, length: int) -> None:
        if magic != MAGIC:
            raise WireError("magic", f"a frame begins with {magic!r}: it must begin with {MAGIC!r}")
        if version != VERSION:
            raise WireError(
                "version",
                f"the frame has version {version}: versions {VERSION} to {VERSION} are understood",
            )
        if kind not in tuple(Kind) and not kind & SKIPPABLE:
            raise WireError("kind", f"frames of kind {kind} are unknown and may not be skipped")
        if length > self.largest:
            raise WireError(
                "length", f"a frame of {length} bytes is too long: at most {self.largest} follow"
            )
        if flags & Flag.HMAC and length < HMAC_SIZE:
            raise WireError("length", f"a proof has {HMAC_SIZE} bytes: the frame has {length}")
