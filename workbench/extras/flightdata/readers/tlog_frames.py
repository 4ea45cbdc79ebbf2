"""The frames of a telemetry log: each has a stamp before it, and ends with a checksum.

Source: mavlink.io/en/guide/serialization.html.
"""

import re
from collections import defaultdict
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from workbench.common.flight import LogRemark

TLOG_STAMP_BYTES = 8
"""Size of the stamp before a frame: microseconds since 1970, most significant byte first."""
V1_MARK = 0xFE
"""First byte of a frame of MAVLink 1."""
V2_MARK = 0xFD
"""First byte of a frame of MAVLink 2."""
V1_HEADER_BYTES = 6
V2_HEADER_BYTES = 10
CHECKSUM_BYTES = 2
SIGNATURE_BYTES = 13
IS_SIGNED = 0x01
"""Flag of a frame with a signature."""
PLAUSIBLE_STAMPS_US = (946_684_800_000_000, 4_102_444_800_000_000)
"""From the year 2000 to 2100."""
MAX_ARRAY_ITEMS = 32
"""Longest array of numbers that is read; longer ones are contents of files."""
MAX_TLOG_MESSAGES = 20_000_000
_MARK_PATTERN = re.compile(b"[\xfd\xfe]")


class FrameKey(NamedTuple):
    """Which frames are of one kind.

    Attributes:
        system: number of the vehicle or ground station.
        component: of the system; an autopilot has number 1.
        message: number of the message.
    """

    system: int
    component: int
    message: int


class Frames(NamedTuple):
    """The frames of one kind, in the order of the file.

    Attributes:
        stamps: microseconds since 1970, on the clock of the program that wrote the log (n).
        places: of the frames in the file (n).
        payloads: of the frames (n).
    """

    stamps: list[int]
    places: list[int]
    payloads: list[bytes]


class _Frame(NamedTuple):
    """A whole frame: what it is of, its payload, and where it ends."""

    key: FrameKey
    payload: bytes
    end: int


def begins_with_frame(data: bytes) -> bool:
    """Return whether a file may begin with a plausible stamp and a frame."""
    low, high = PLAUSIBLE_STAMPS_US
    if len(data) <= TLOG_STAMP_BYTES or data[TLOG_STAMP_BYTES] not in (V1_MARK, V2_MARK):
        return False
    end = _frame_end(data, TLOG_STAMP_BYTES)
    follows = data[end + TLOG_STAMP_BYTES : end + TLOG_STAMP_BYTES + 1]
    return low < int.from_bytes(data[:TLOG_STAMP_BYTES]) < high and (
        not follows or follows[0] in (V1_MARK, V2_MARK)
    )


def read_tlog_frames(
    data: bytes, messages: Mapping[int, Any]
) -> tuple[dict[FrameKey, Frames], str]:
    """Return the frames of a log by kind, and a remark on damage, "" without any.

    Messages that are not known are left out. Behind damage, frames count again from the next known
    message with a right checksum.

    Args:
        data: of the file.
        messages: classes of pymavlink by the number of the message.
    """
    found: dict[FrameKey, Frames] = defaultdict(lambda: Frames([], [], []))
    at = damaged = count = 0
    first = -1
    while at < len(data) and count < MAX_TLOG_MESSAGES:
        frame = _frame_at(data, at + TLOG_STAMP_BYTES, messages)
        if frame is None:
            begin, at = at, _next_frame(data, at + 1, messages)
            damaged += at - begin
            first = begin if first < 0 else first
            continue
        if frame.key.message in messages:
            kept = found[frame.key]
            kept.stamps.append(int.from_bytes(data[at : at + TLOG_STAMP_BYTES]))
            kept.places.append(at)
            kept.payloads.append(frame.payload)
            count += 1
        at = frame.end
    if not damaged:
        return dict(found), ""
    text = f"the file is damaged: {damaged} bytes are no messages, the first one is byte {first}"
    return dict(found), LogRemark(text, damaged, f"byte {first}")


def _next_frame(data: bytes, begin: int, messages: Mapping[int, Any]) -> int:
    """Return where the stamp of the next known message begins, else the end of the file."""
    for mark in _MARK_PATTERN.finditer(data, begin + TLOG_STAMP_BYTES):
        frame = _frame_at(data, mark.start(), messages)
        if frame is not None and frame.key.message in messages:
            return mark.start() - TLOG_STAMP_BYTES
    return len(data)


def _frame_end(data: bytes, at: int) -> int:
    """Return where the frame with its mark at a place ends."""
    head = data[at : at + 3].ljust(3, b"\0")
    if head[0] == V1_MARK:
        return at + V1_HEADER_BYTES + head[1] + CHECKSUM_BYTES
    signature = SIGNATURE_BYTES if head[2] & IS_SIGNED else 0
    return at + V2_HEADER_BYTES + head[1] + CHECKSUM_BYTES + signature


def _frame_at(data: bytes, at: int, messages: Mapping[int, Any]) -> _Frame | None:
    """Return the frame with its mark at a place, None if there is none, or its checksum is wrong.

    The checksum of an unknown message cannot be checked.
    """
    from pymavlink.generator.mavcrc import x25crc

    if at >= len(data) or data[at] not in (V1_MARK, V2_MARK):
        return None
    end = _frame_end(data, at)
    if end > len(data):
        return None
    if data[at] == V1_MARK:
        begin = at + V1_HEADER_BYTES
        key = FrameKey(*data[at + 3 : begin])
    else:
        begin = at + V2_HEADER_BYTES
        key = FrameKey(data[at + 5], data[at + 6], int.from_bytes(data[at + 7 : begin], "little"))
    payload = data[begin : begin + data[at + 1]]
    if key.message in messages:
        check = begin + len(payload)
        seeded = data[at + 1 : check] + bytes([messages[key.message].crc_extra])
        if x25crc(seeded).crc != int.from_bytes(data[check : check + CHECKSUM_BYTES], "little"):
            return None
    return _Frame(key, payload, end)


def read_payloads(frames: Frames, message: Any) -> dict[str, np.ndarray]:
    """Return the fields of the frames of a kind by name: numbers (n), and texts as bytes (n).

    Version 2 leaves zeros at the end of a payload out, and earlier versions of a message lack its
    last fields: both count as zeros.
    """
    kinds = [
        (name, f"S{max(count, 1)}", ())
        if code == "c"
        else (name, f"<{code}", (count,) if count else ())
        for name, code, count in zip(
            message.ordered_fieldnames,
            message.native_format.decode().lstrip("<"),
            message.array_lengths,
            strict=True,
        )
    ]
    layout = np.dtype(kinds)
    size = layout.itemsize
    rows = np.frombuffer(
        b"".join(each[:size].ljust(size, b"\0") for each in frames.payloads), layout
    )
    fields: dict[str, np.ndarray] = {}
    for name, _, shape in kinds:
        if not shape:
            fields[name] = rows[name]
        elif shape[0] <= MAX_ARRAY_ITEMS:
            fields |= {f"{name}[{i}]": rows[name][:, i] for i in range(shape[0])}
    return fields
