"""Write blackbox logs as a flight controller does: key frames, differences, and all encodings."""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tests.extras.flightdata.foreign_files import HEADERS, header_lines, unsigned, vb

I_INTERVAL = 16
"""Number of frames from a key frame to the next one."""


def bits(value: int, size: int) -> int:
    """Return the two's complement of a number."""
    assert -(1 << (size - 1)) <= value < 1 << (size - 1)
    return value & ((1 << size) - 1)


def whole_bytes(values: Sequence[int]) -> bytes:
    """Return three numbers with the bytes that each one needs."""
    sizes = [
        next(n for n in (1, 2, 3, 4) if -(1 << 8 * n - 1) <= v < 1 << 8 * n - 1) for v in values
    ]
    lead = 0xC0 | sum((size - 1) << 2 * i for i, size in enumerate(sizes))
    return bytes([lead]) + b"".join(
        value.to_bytes(size, "little", signed=True)
        for value, size in zip(values, sizes, strict=True)
    )


def tag2_3s32(values: Sequence[int]) -> bytes:
    """Encoding 7."""
    a, b, c = values
    low, high = min(values), max(values)
    if low >= -2 and high < 2:
        return bytes([bits(a, 2) << 4 | bits(b, 2) << 2 | bits(c, 2)])
    if low >= -8 and high < 8:
        return bytes([0x40 | bits(a, 4), bits(b, 4) << 4 | bits(c, 4)])
    if low >= -32 and high < 32:
        return bytes([0x80 | bits(a, 6), bits(b, 6), bits(c, 6)])
    return whole_bytes(values)


def tag2_3svariable(values: Sequence[int]) -> bytes:
    """Encoding 10."""
    a, b, c = values
    low, high = min(values), max(values)
    if low >= -2 and high < 2:
        return bytes([bits(a, 2) << 4 | bits(b, 2) << 2 | bits(c, 2)])
    if min(a, b) >= -16 and max(a, b) < 16 and -8 <= c < 8:
        return (1 << 14 | bits(a, 5) << 9 | bits(b, 5) << 4 | bits(c, 4)).to_bytes(2, "big")
    if -128 <= a < 128 and min(b, c) >= -64 and max(b, c) < 64:
        return (2 << 22 | bits(a, 8) << 14 | bits(b, 7) << 7 | bits(c, 7)).to_bytes(3, "big")
    return whole_bytes(values)


def tag8_4s16(values: Sequence[int]) -> bytes:
    """Encoding 8, of format version 2."""
    lead, nibbles = 0, ""
    for i, value in enumerate(values):
        kind = 0 if value == 0 else 1 if -8 <= value < 8 else 2 if -128 <= value < 128 else 3
        lead |= kind << 2 * i
        size = (0, 4, 8, 16)[kind]
        nibbles += f"{bits(value, size):0{size // 4}x}" if size else ""
    return bytes([lead]) + bytes.fromhex(nibbles + "0" * (len(nibbles) % 2))


def tag8_4s16_v1(values: Sequence[int]) -> bytes:
    """Encoding 8, of format version 1: numbers of 4 bits come in pairs."""
    lead, data, i = 0, b"", 0
    while i < 4:
        pair = values[i : i + 2]
        if len(pair) == 2 and all(-8 <= each < 8 for each in pair) and any(pair):
            lead |= 0b0101 << 2 * i
            data += bytes([bits(pair[1], 4) << 4 | bits(pair[0], 4)])
            i += 2
            continue
        if values[i] == 0:
            kind = 0
        elif -128 <= values[i] < 128:
            kind, data = 2, data + struct.pack("<b", values[i])
        else:
            kind, data = 3, data + struct.pack("<h", values[i])
        lead |= kind << 2 * i
        i += 1
    return bytes([lead]) + data


def tag8_8svb(values: Sequence[int]) -> bytes:
    """Encoding 6."""
    if len(values) == 1:
        return vb(values[0])
    lead = sum(1 << i for i, value in enumerate(values) if value)
    return bytes([lead]) + b"".join(vb(value) for value in values if value)


@dataclass(frozen=True)
class Field:
    """A field: its values, and predictors and encodings of key frames and differences."""

    values: Sequence[int]
    key: tuple[int, int]
    difference: tuple[int, int]
    signed: int = 1


def encoded(values: Sequence[int], encodings: Sequence[int], version: int = 2) -> bytes:
    """Return the bytes of the fields of a frame."""
    data, at = b"", 0
    while at < len(values):
        kind, size = encodings[at], 1
        if kind == 6:
            while size < 8 and list(encodings[at + size : at + size + 1]) == [6]:
                size += 1
            data += tag8_8svb(values[at : at + size])
        elif kind in (7, 10):
            size = 3
            data += (tag2_3s32 if kind == 7 else tag2_3svariable)(values[at : at + 3])
        elif kind == 8:
            size = 4
            data += (tag8_4s16 if version > 1 else tag8_4s16_v1)(values[at : at + 4])
        elif kind == 0:
            data += vb(values[at])
        elif kind == 1:
            data += unsigned(values[at] & 0xFFFFFFFF)
        elif kind == 3:
            data += unsigned(-values[at] & 0x3FFF)
        at += size
    return data


def residuals(
    fields: Mapping[str, Field], row: int, previous: Sequence[int], references: Mapping[int, int]
) -> list[int]:
    """Return what a frame has of its fields: the values without the predictions.

    Args:
        fields: by name.
        row: of the frame.
        previous: rows of the two frames before, none for a key frame.
        references: fixed predictions by predictor.
    """
    found = []
    for field in fields.values():
        predictor = (field.difference if previous else field.key)[0]
        prediction = references.get(predictor, 0)
        if predictor == 5:
            prediction = fields["motor[0]"].values[row]
        elif previous:
            last, before = (field.values[each] for each in previous)
            both = last + before
            average = both // 2 if both >= 0 else -(-both // 2)
            prediction = {1: last, 2: 2 * last - before, 3: average, 6: last + 1}.get(
                predictor, prediction
            )
        value = int(field.values[row]) - prediction
        found.append((value + 2**31) % 2**32 - 2**31)
    return found


def predicted_blackbox(
    fields: Mapping[str, Field],
    headers: Mapping[str, str | None] | None = None,
    *,
    between: Mapping[int, bytes] | None = None,
    extra: Sequence[str] = (),
    version: int = 2,
    end: bytes = b"E\xffEnd of log\x00",
) -> tuple[bytes, list[int]]:
    """Return a log with predicted frames, and the place of each frame in it.

    Args:
        fields: by name, the number of the control update and the time first.
        headers: more headers; None leaves one out.
        between: bytes in front of a frame, by its number.
        extra: header lines in front of the others.
        version: of the format.
        end: of the log.
    """
    merged = HEADERS | {"minthrottle": "1070", "vbatref": "1640"} | dict(headers or {})
    data = header_lines(
        list(fields),
        [each.signed for each in fields.values()],
        [each.key for each in fields.values()],
        [each.difference for each in fields.values()],
        merged,
        version=version,
        interval=I_INTERVAL,
        extra=extra,
    )
    motor = int(str(merged["motorOutput"]).split(",")[0])
    references = {4: 1070, 8: 1500, 9: 1640, 11: motor}
    places = []
    for row in range(len(fields["time"].values)):
        data += (between or {}).get(row, b"")
        places.append(len(data))
        since = row % I_INTERVAL
        previous = [row - 1, row - min(since, 2)] if since else []
        values = residuals(fields, row, previous, references)
        kinds = [each.difference if since else each.key for each in fields.values()]
        mark = b"P" if since else b"I"
        data += mark + encoded(values, [encoding for _, encoding in kinds], version)
    return data + end, places


def flight_fields(count: int, *, begin_us: int = 0, seed: int = 0) -> dict[str, Field]:
    """Return the fields of a flight of four motors, encoded as Betaflight does.

    The time steps by 500 us, and its counter of 32 bits may overflow.
    """
    random = np.random.default_rng(seed)

    def walk(step: float, middle: float, low: int, high: int) -> list[int]:
        steps = random.standard_t(2, count) * step
        return np.clip(np.rint(middle + np.cumsum(steps)), low, high).astype(int).tolist()

    previous, straight, average = 1, 2, 3
    time = [(begin_us + 500 * i) % 2**32 for i in range(count)]
    fields = {
        "loopIteration": Field(list(range(count)), (0, 1), (6, 9), 0),
        "time": Field(time, (0, 1), (straight, 0), 0),
    }
    fields |= {
        f"axisP[{i}]": Field(walk(20, 0, -900, 900), (0, 0), (previous, 0)) for i in range(3)
    }
    for i, step in enumerate((1, 8, 3000)):
        fields[f"axisI[{i}]"] = Field(walk(step, 0, -(2**24), 2**24), (0, 0), (previous, 7))
    for i in range(3):
        fields[f"axisF[{i}]"] = Field(walk(6, 0, -300, 300), (0, 0), (previous, 10))
    for i, step in enumerate((0.4, 4, 60, 300)):
        fields[f"setpoint[{i}]"] = Field(walk(step, 0, -1900, 1900), (0, 0), (previous, 8))
    for i in range(3):
        fields[f"gyroADC[{i}]"] = Field(walk(12, 0, -1900, 1900), (0, 0), (average, 0))
        fields[f"accSmooth[{i}]"] = Field(walk(15, 0, -9000, 9000), (0, 0), (average, 0))
    low = int(HEADERS["motorOutput"].split(",")[0])
    fields["motor[0]"] = Field(walk(30, 900, low, 2047), (11, 1), (average, 0), 0)
    for i in (1, 2, 3):
        fields[f"motor[{i}]"] = Field(walk(30, 900, low, 2047), (5, 0), (average, 0), 0)
    fields["vbatLatest"] = Field(walk(0.3, 1600, 1200, 1640), (9, 3), (previous, 6), 0)
    fields["amperageLatest"] = Field(walk(3, 900, -100, 9000), (0, 0), (previous, 6))
    fields["rssi"] = Field(walk(0.2, 900, 0, 1023), (0, 1), (previous, 6), 0)
    return fields
