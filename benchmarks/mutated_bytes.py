"""Mutated copies of files: texts, XML, tables of bytes, and chunks of MCAP with right checksums."""

import gzip
import random
import re
import struct
import zlib
from collections.abc import Callable, Sequence

import zstandard
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

Mutate = Callable[[bytes, random.Random], bytes]
"""Returns a mutated copy of a file's bytes."""

NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
WORD = re.compile(rb"[A-Za-z_][\w.]*")
ELEMENT = re.compile(rb"<(\w+)\b[^<>]*(?:/>|>[^<>]*</\1>)")
QUOTED = re.compile(rb'(?<=")[^"<>]*(?=")')
NUMBERS = (
    *(b"nan", b".nan", b"inf", b"-inf", b".inf", b"0", b"-0.0", b"-1", b"1e308", b"-1e308"),
    *(b"1e-308", b"5e-324", b"1e999", b"9" * 40, b"9" * 5000, b"2147483648", b"4294967296"),
    *(b"9223372036854775807", b"18446744073709551616", b"0x7fffffff", b"1_000", b"1e5", b"12:30"),
    *(b"", b"abc", b"1 2", b"true", b"null", b"~", b"\xc3\xbc", b"%s", b"1" + b"0" * 400),
)
"""What stands in place of a number."""
WORDS = (
    *(b"", b"x" * 100_000, b"\0", b"\xff\xfe", b"\xed\xa0\x80", b"\x1b[2J", b"../../../etc/passwd"),
    *(b"/dev/zero", b"~nobody/x", b"package://gone/x", b"file:/" + b"//etc/hostname", b"{{name}}"),
    *(b"${1/0}", b"$(find gone)", b"&a [1, 2]", b"*a", b"!!python/object/apply:os.system [id]"),
    *(b"<<", b"- ", b": ", b"{", b"[" * 50, b"'", b'"', b"#", b"|", b"&#0;", b"&x;", b"]]>"),
    *(b"2026-02-30", b"__class__", b"nan", b"null", b"yes", b"\xef\xbb\xbf", b"\r", b"\t", b"\\"),
)
"""What stands in place of a word."""
RAW = (
    *(struct.pack("<Q", each) for each in (2**64 - 1, 2**63, 2**63 - 1, 2**32, 0, 10**15)),
    *(struct.pack("<I", each) for each in (2**32 - 1, 2**31, 2**31 - 1, 0, 10**6)),
    *(struct.pack("<H", each) for each in (2**16 - 1, 2**15, 0)),
    *(struct.pack("<d", each) for each in (float("nan"), float("inf"), -1e308, 5e-324)),
    *(struct.pack("<f", each) for each in (float("nan"), float("-inf"), 3e38)),
    *(b"\0", b"\xff", b"\x80", bytes(64), b"\xff" * 64),
)
"""What stands in place of some bytes."""
TIMES = (1, 1, 1, 2, 4)
"""How many changes a copy has."""
_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQI")


def mutated_bytes(data: bytes, chance: random.Random) -> bytes:
    """Return a copy with one to four changes of its bytes."""
    copy = bytearray(data)
    for _ in range(chance.choice(TIMES)):
        at = chance.randrange(len(copy) + 1)
        size = min(chance.choice((1, 2, 4, 8, 64, 1000)), len(copy) - at)
        match chance.randrange(8):
            case 0:
                del copy[at:]
            case 1:
                del copy[at : at + size]
            case 2:
                copy[at : at + size] = chance.randbytes(size)
            case 3:
                copy[at:at] = copy[at : at + size] * chance.choice((1, 2, 2000))
            case 4:
                other = chance.randrange(len(copy) + 1)
                part, copy[at : at + size] = copy[at : at + size], copy[other : other + size]
                copy[other : other + size] = part
            case 5:
                copy[at:at] = chance.choice(RAW)
            case 6:
                raw = chance.choice(RAW)
                copy[at : at + len(raw)] = raw
            case _:
                if at < len(copy):
                    copy[at] ^= 1 << chance.randrange(8)
    return bytes(copy)


def mutated_text(data: bytes, chance: random.Random) -> bytes:
    """Return a copy with one to four changes of its lines, words and numbers."""
    for _ in range(chance.choice(TIMES)):
        data = chance.choice(_OF_TEXT)(data, chance)
    return data


def mutated_xml(data: bytes, chance: random.Random) -> bytes:
    """Return a copy with one to four changes of its elements, attributes and numbers."""
    for _ in range(chance.choice(TIMES)):
        data = chance.choice(_OF_XML)(data, chance)
    return data


def mutated_gzip(inner: Mutate) -> Mutate:
    """Return what mutates a gzip file: mostly its content, otherwise its own bytes."""

    def mutate(data: bytes, chance: random.Random) -> bytes:
        if chance.random() < 0.3:
            return mutated_bytes(data, chance)
        return gzip.compress(inner(gzip.decompress(data), chance), 1)

    return mutate


def mutated_mcap(data: bytes, chance: random.Random) -> bytes:
    """Return a copy that is changed within its records and chunks, whose frames stay right."""
    if chance.random() < 0.3:
        return mutated_bytes(data, chance)
    records = _records(data[len(MCAP0_MAGIC) :])
    for _ in range(chance.randint(1, 3)):
        place = chance.randrange(len(records))
        opcode, content = records[place]
        match chance.randrange(6):
            case 0:
                del records[place]
            case 1:
                records.insert(chance.randrange(len(records) + 1), (opcode, content))
            case 2:
                records[place] = (chance.randrange(16), content)
            case _:
                records[place] = (opcode, _mutated_content(opcode, content, chance))
        if not records:
            break
    return MCAP0_MAGIC + b"".join(_HEAD.pack(op, len(each)) + each for op, each in records)


def _mutated_content(opcode: int, content: bytes, chance: random.Random) -> bytes:
    """Return another content of a record, which need not be what its opcode says."""
    inner = {Opcode.CHUNK: _mutated_chunk, Opcode.ATTACHMENT: _mutated_attachment}
    try:
        return inner.get(opcode, mutated_bytes)(content, chance)
    except (struct.error, ValueError, zstandard.ZstdError):  # its opcode was changed before
        return mutated_bytes(content, chance)


def _records(data: bytes) -> list[tuple[int, bytes]]:
    """Return opcodes and contents of complete records."""
    found, at = [], 0
    while at + _HEAD.size <= len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size + length
        if at > len(data):
            break
        found.append((opcode, data[at - length : at]))
    return found


def _mutated_chunk(content: bytes, chance: random.Random) -> bytes:
    """Return a chunk with other records, packed again, and with its checksum."""
    begin, end, _, _ = _CHUNK.unpack_from(content)
    (length,) = struct.unpack_from("<I", content, _CHUNK.size)
    packed = content[_CHUNK.size + 4 + length + 8 :]
    plain = zstandard.ZstdDecompressor().decompress(packed) if length else packed
    inner = _records(plain)
    for _ in range(chance.randint(1, 3)):
        place = chance.randrange(len(inner))
        opcode, each = inner[place]
        inner[place] = (opcode, mutated_bytes(each, chance))
    plain = b"".join(_HEAD.pack(op, len(each)) + each for op, each in inner)
    packed = zstandard.ZstdCompressor(level=1).compress(plain)
    size = chance.choice((len(plain),) * 5 + (0, 2**40, 2**64 - 1))
    head = _CHUNK.pack(begin, end, size, zlib.crc32(plain)) + struct.pack("<I", 4) + b"zstd"
    return head + struct.pack("<Q", len(packed)) + packed


def _mutated_attachment(content: bytes, chance: random.Random) -> bytes:
    """Return an attachment with another text."""
    at = 16  # behind two times
    for _ in ("name", "media type"):
        at += 4 + struct.unpack_from("<I", content, at)[0]
    data = mutated_text(content[at + 8 : -4], chance)
    return content[:at] + struct.pack("<Q", len(data)) + data + struct.pack("<I", 0)


def _replaced(
    data: bytes,
    pattern: re.Pattern[bytes],
    chance: random.Random,
    made: Callable[[re.Match[bytes]], bytes],
) -> bytes:
    """Return a text with one match, chosen at random, replaced."""
    matches = list(pattern.finditer(data))
    if not matches:
        return data
    match = chance.choice(matches)
    return data[: match.start()] + made(match) + data[match.end() :]


def _spoil_number(data: bytes, chance: random.Random) -> bytes:
    return _replaced(data, NUMBER, chance, lambda _: chance.choice(NUMBERS))


def _swap_numbers(data: bytes, chance: random.Random) -> bytes:
    numbers: Sequence[bytes] = NUMBER.findall(data) or [b"1"]
    return _replaced(data, NUMBER, chance, lambda _: chance.choice(numbers))


def _spoil_word(data: bytes, chance: random.Random) -> bytes:
    return _replaced(data, WORD, chance, lambda _: chance.choice(WORDS))


def _swap_words(data: bytes, chance: random.Random) -> bytes:
    words: Sequence[bytes] = WORD.findall(data) or [b"x"]
    return _replaced(data, WORD, chance, lambda _: chance.choice(words))


def _insert_word(data: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(data) + 1)
    return data[:at] + chance.choice((*WORDS, *NUMBERS)) + data[at:]


def _move_line(data: bytes, chance: random.Random) -> bytes:
    lines = data.split(b"\n")
    line = lines.pop(chance.randrange(len(lines)))
    for _ in range(chance.choice((0, 1, 2, 1000))):
        lines.insert(chance.randrange(len(lines) + 1), line)
    return b"\n".join(lines)


def _indent_line(data: bytes, chance: random.Random) -> bytes:
    lines = data.split(b"\n")
    place = chance.randrange(len(lines))
    lines[place] = b" " * chance.choice((0, 1, 2, 40)) + lines[place].lstrip()
    return b"\n".join(lines)


def _drop_element(data: bytes, chance: random.Random) -> bytes:
    return _replaced(data, ELEMENT, chance, lambda _: b"")


def _repeat_element(data: bytes, chance: random.Random) -> bytes:
    times = chance.choice((2, 3, 300))
    return _replaced(data, ELEMENT, chance, lambda match: match[0] * times)


def _move_element(data: bytes, chance: random.Random) -> bytes:
    elements = [match[0] for match in ELEMENT.finditer(data)] or [b""]
    return _replaced(data, ELEMENT, chance, lambda match: match[0] + chance.choice(elements))


def _deepen(data: bytes, chance: random.Random) -> bytes:
    times = chance.choice((5, 50, 5000))
    return _replaced(
        data,
        ELEMENT,
        chance,
        lambda each: b"<%b>" % each[1] * times + each[0] + b"</%b>" % each[1] * times,
    )


def _rename(data: bytes, chance: random.Random) -> bytes:
    names = QUOTED.findall(data) or [b"x"]
    return _replaced(data, QUOTED, chance, lambda _: chance.choice([*names, *WORDS]))


_OF_TEXT = (
    mutated_bytes,
    _spoil_number,
    _spoil_number,
    _swap_numbers,
    _spoil_word,
    _swap_words,
    _insert_word,
    _move_line,
    _indent_line,
)
_OF_XML = (
    mutated_bytes,
    _spoil_number,
    _spoil_number,
    _spoil_number,
    _swap_numbers,
    _insert_word,
    _drop_element,
    _repeat_element,
    _move_element,
    _deepen,
    _rename,
    _rename,
)
