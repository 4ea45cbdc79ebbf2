"""The encodings of numbers in frames of a blackbox log.

Each function returns the numbers that are at a place in the data, and the place behind them; at the
end of the data it raises IndexError. Numbers have 32 bits.

Source: docs/development/Blackbox of Betaflight and src/decoders.c of blackbox-tools, as facts.
"""

from collections.abc import Callable, Sequence

MAX_NUMBER_BYTES = 5
"""Largest number of bytes of a number with seven bits a byte; a longer one is damaged, and 0."""
Decoded = tuple[Sequence[int], int]
Decoder = Callable[[bytes, int], Decoded]


def unsigned_number(data: bytes, at: int) -> tuple[int, int]:
    """Return a number of seven bits a byte, the lowest ones first."""
    value, shift = 0, 0
    for _ in range(MAX_NUMBER_BYTES):
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & 0xFFFFFFFF, at
        shift += 7
    return 0, at


def signed_number(data: bytes, at: int) -> tuple[int, int]:
    """Return a number of seven bits a byte, whose lowest bit is its sign (zigzag)."""
    byte = data[at]
    if byte < 0x80:
        return (byte >> 1) ^ -(byte & 1), at + 1
    value, at = unsigned_number(data, at)
    return (value >> 1) ^ -(value & 1), at


def _signed(value: int, bits: int) -> int:
    """Return the number that some bits have in two's complement."""
    value &= (1 << bits) - 1
    return value - (1 << bits) if value >> (bits - 1) else value


def _unsigned_vb(data: bytes, at: int) -> Decoded:
    value, at = unsigned_number(data, at)
    return (value,), at


def _signed_vb(count: int) -> Decoder:
    """Return the decoder of signed numbers that follow each other, most of all numbers of a log."""

    def decode(data: bytes, at: int) -> Decoded:
        values = []
        for _ in range(count):
            byte = data[at]
            if byte < 0x80:
                values.append((byte >> 1) ^ -(byte & 1))
                at += 1
            else:
                value, at = signed_number(data, at)
                values.append(value)
        return values, at

    return decode


def _negative_14_bits(data: bytes, at: int) -> Decoded:
    value, at = unsigned_number(data, at)
    return (-_signed(value, 14),), at


def _null(_: bytes, at: int) -> Decoded:
    return (0,), at


def _whole_bytes(data: bytes, at: int) -> Decoded:
    """Return three numbers of 1 to 4 bytes; the first byte has their sizes."""
    sizes, values = data[at], []
    at += 1
    for _ in range(3):
        size = (sizes & 3) + 1
        if at + size > len(data):
            raise IndexError
        values.append(int.from_bytes(data[at : at + size], "little", signed=True))
        at += size
        sizes >>= 2
    return values, at


def _tag2_3s32(data: bytes, at: int) -> Decoded:
    """Return three numbers, all with 2, 4 or 6 bits, or each with whole bytes."""
    first = data[at]
    kind = first >> 6
    if kind == 0:
        return (_signed(first >> 4, 2), _signed(first >> 2, 2), _signed(first, 2)), at + 1
    if kind == 1:
        second = data[at + 1]
        return (_signed(first, 4), _signed(second >> 4, 4), _signed(second, 4)), at + 2
    if kind == 2:
        return (_signed(first, 6), _signed(data[at + 1], 6), _signed(data[at + 2], 6)), at + 3
    return _whole_bytes(data, at)


def _tag2_3svariable(data: bytes, at: int) -> Decoded:
    """Return three numbers, with 2, 2, 2 or 5, 5, 4 or 8, 7, 7 bits, or each with whole bytes."""
    first = data[at]
    kind = first >> 6
    if kind == 0:
        return _tag2_3s32(data, at)
    if kind == 1:
        bits = first << 8 | data[at + 1]
        return (_signed(bits >> 9, 5), _signed(bits >> 4, 5), _signed(bits, 4)), at + 2
    if kind == 2:
        bits = first << 16 | data[at + 1] << 8 | data[at + 2]
        return (_signed(bits >> 14, 8), _signed(bits >> 7, 7), _signed(bits, 7)), at + 3
    return _whole_bytes(data, at)


def _tag8_4s16_v1(data: bytes, at: int) -> Decoded:
    """Return four numbers of 0, 4, 8 or 16 bits; two of 4 bits follow each other in a byte."""
    sizes, values = data[at], []
    at += 1
    while len(values) < 4:
        kind = sizes & 3
        sizes >>= 2
        if kind == 0:
            values.append(0)
        elif kind == 1:
            values += [_signed(data[at], 4), _signed(data[at] >> 4, 4)]
            sizes >>= 2
            at += 1
        elif kind == 2:
            values.append(_signed(data[at], 8))
            at += 1
        else:
            values.append(_signed(data[at] | data[at + 1] << 8, 16))
            at += 2
    return values[:4], at


_NIBBLES = (0, 1, 2, 4)
"""Half bytes of a number by its two bits in the first byte."""


def _tag8_4s16_v2(data: bytes, at: int) -> Decoded:
    """Return four numbers of 0, 4, 8 or 16 bits, as half bytes in a row, the highest ones first."""
    sizes, values = data[at], []
    place = 2 * (at + 1)
    for _ in range(4):
        count = _NIBBLES[sizes & 3]
        sizes >>= 2
        value = 0
        for nibble in range(place, place + count):
            byte = data[nibble >> 1]
            value = value << 4 | (byte & 15 if nibble & 1 else byte >> 4)
        values.append(_signed(value, 4 * count) if count else 0)
        place += count
    return values, (place + 1) >> 1


def _tag8_8svb(count: int) -> Decoder:
    """Return the decoder of up to eight numbers, whose first byte says which are not 0."""
    if count == 1:
        return _signed_vb(1)

    def decode(data: bytes, at: int) -> Decoded:
        present, values = data[at], []
        at += 1
        for _ in range(count):
            value = 0
            if present & 1:
                value, at = signed_number(data, at)
            values.append(value)
            present >>= 1
        return values, at

    return decode


_SIGNED_VB, _TAG8_8SVB, _TAG8_4S16 = 0, 6, 8
_SINGLE: dict[int, Decoder] = {1: _unsigned_vb, 3: _negative_14_bits, 9: _null}
_TRIPLES: dict[int, Decoder] = {7: _tag2_3s32, 10: _tag2_3svariable}
_GROUP_SIZES = {**dict.fromkeys(_TRIPLES, 3), _TAG8_4S16: 4}
"""Number of fields of encodings that always have the same number of fields."""


def field_decoders(encodings: Sequence[int], version: int) -> list[Decoder]:
    """Return the decoders of the fields of a frame, in order; some return several fields.

    Args:
        encodings: of the fields, by the numbers of the format.
        version: of the format.

    Raises:
        ValueError: if an encoding is unknown, or lacks fields.
    """
    decoders: list[Decoder] = []
    at = 0
    while at < len(encodings):
        encoding = encodings[at]
        size = _GROUP_SIZES.get(encoding, 1)
        if encoding in (_SIGNED_VB, _TAG8_8SVB):
            most = len(encodings) if encoding == _SIGNED_VB else 8
            while size < most and encodings[at + size : at + size + 1] == [encoding]:
                size += 1
            decoders.append((_signed_vb if encoding == _SIGNED_VB else _tag8_8svb)(size))
        elif encoding == _TAG8_4S16:
            decoders.append(_tag8_4s16_v1 if version < 2 else _tag8_4s16_v2)
        elif encoding in _SINGLE or encoding in _TRIPLES:
            decoders.append(_SINGLE[encoding] if encoding in _SINGLE else _TRIPLES[encoding])
        else:
            raise ValueError(f"the encoding {encoding} of a field is not known")
        at += size
    if at > len(encodings):
        raise ValueError("an encoding has more fields than the frame")
    return decoders
