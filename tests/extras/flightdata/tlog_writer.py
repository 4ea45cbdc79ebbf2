"""Write telemetry logs of MAVLink after its published definitions, with `struct` alone.

Source: mavlink.io/en/guide/serialization.html and mavlink.io/en/messages/common.html. On the wire
the fields of a message stand by the size of their types, largest first, then its extensions.
"""

import struct
from collections.abc import Iterable, Sequence
from typing import NamedTuple

Value = float | str | bytes


class Definition(NamedTuple):
    """A message: number, seed of its checksum, and struct's codes of its fields on the wire.

    `extensions` are the codes of fields that version 1 lacks.
    """

    number: int
    seed: int
    fields: str
    extensions: str = ""


HEARTBEAT = Definition(0, 50, "IBBBBB")
SYS_STATUS = Definition(1, 124, "IIIHHhHHHHHHb")
PARAM_VALUE = Definition(22, 220, "fHH16sB")
SCALED_IMU = Definition(26, 170, "Ihhhhhhhhh", "h")
RAW_IMU = Definition(27, 144, "Qhhhhhhhhh", "Bh")
ATTITUDE = Definition(30, 39, "Iffffff")
ATTITUDE_QUATERNION = Definition(31, 246, "Ifffffff")
LOCAL_POSITION_NED = Definition(32, 185, "Iffffff")
GLOBAL_POSITION_INT = Definition(33, 104, "IiiiihhhH")
SERVO_OUTPUT_RAW = Definition(36, 222, "IHHHHHHHHB", "HHHHHHHH")
ATTITUDE_TARGET = Definition(83, 22, "IffffffffB")
POSITION_TARGET_LOCAL_NED = Definition(85, 140, "IfffffffffffHB")
HIGHRES_IMU = Definition(105, 93, "QfffffffffffffH", "B")
BATTERY_STATUS = Definition(147, 154, "iih" + "H" * 10 + "hBBBb", "iBHHHHBI")
AUTOPILOT_VERSION = Definition(148, 178, "QQIIIIHH8s8s8s", "18s")
STATUSTEXT = Definition(253, 83, "B50s", "HB")
ACTUATOR_OUTPUT_STATUS = Definition(375, 251, "QI" + "f" * 32)
ESC_TELEMETRY_1_TO_4 = Definition(11030, 144, "H" * 20 + "BBBB")
ESC_TELEMETRY_5_TO_8 = Definition(11031, 133, "H" * 20 + "BBBB")


def x25(data: bytes) -> int:
    """Return the checksum of MAVLink, bit by bit."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x8408 if crc & 1 else crc >> 1
    return crc


def frame(
    what: Definition,
    values: Sequence[Value],
    *,
    system: int = 1,
    component: int = 1,
    version: int = 2,
    signed: bool = False,
) -> bytes:
    """Return a frame of a message; values of a version 2 may include those of extensions."""
    codes = what.fields + (what.extensions if version == 2 else "")
    given = [each.encode() if isinstance(each, str) else each for each in values]
    given = given[: len(struct.unpack("<" + codes, bytes(struct.calcsize("<" + codes))))]
    short = "<" + _first_codes(codes, len(given))
    whole = [
        int(value) if code in "BbHhIiQ" else value
        for value, code in zip(given, _single_codes(short[1:]), strict=True)
    ]
    payload = struct.pack(short, *whole)
    if version == 1:
        head = struct.pack("<BBBBB", len(payload), 0, system, component, what.number)
        return (
            b"\xfe" + head + payload + struct.pack("<H", x25(head + payload + bytes([what.seed])))
        )
    payload = payload.rstrip(b"\0") or b"\0"
    head = struct.pack("<BBBBBB", len(payload), int(signed), 0, 0, system, component)
    head += what.number.to_bytes(3, "little")
    check = struct.pack("<H", x25(head + payload + bytes([what.seed])))
    return b"\xfd" + head + payload + check + (bytes(13) if signed else b"")


def _single_codes(codes: str) -> list[str]:
    """Return the code of each value; that of a text is s."""
    return [each for each in codes if not each.isdigit()]


def _first_codes(codes: str, count: int) -> str:
    """Return the codes of the first values."""
    found, seen = "", 0
    for each in codes:
        if seen == count:
            break
        found += each
        seen += not each.isdigit()
    return found


def tlog(stamped: Iterable[tuple[int, bytes]]) -> bytes:
    """Return a log of frames, each with its stamp [us since 1970]."""
    return b"".join(struct.pack(">Q", stamp) + each for stamp, each in stamped)
