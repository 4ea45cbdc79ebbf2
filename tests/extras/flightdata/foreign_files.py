"""Small log files of all formats, with any time stamps."""

import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.common.flight import Flight
from workbench.logs.readers.any_log import read_any
from workbench.logs.readers.log_reader import LogFile

HEADERS = {
    "Firmware type": "Cleanflight",
    "Firmware revision": "Betaflight 4.5.1 (made up) TEST",
    "gyro_scale": "0x3f800000",
    "motorOutput": "158,2047",
    "acc_1G": "2048",
}
FIELDS = ("gyroADC[0]", "gyroADC[1]", "setpoint[1]", "motor[0]", "accSmooth[2]", "vbatLatest")


def vb(value: int) -> bytes:
    """Return a number as blackbox logs have it: zigzag, seven bits a byte."""
    value = (value << 1) ^ (value >> 31)
    value &= 0xFFFFFFFF
    parts = bytearray()
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*parts, value])


def unsigned(value: int) -> bytes:
    """Return a number without a sign as blackbox logs have it, seven bits a byte."""
    parts = bytearray()
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*parts, value])


def header_lines(
    names: Sequence[str],
    signed: Sequence[int],
    key: Sequence[tuple[int, int]],
    difference: Sequence[tuple[int, int]],
    headers: Mapping[str, str | None],
    *,
    version: int = 2,
    interval: int = 1,
    extra: Sequence[str] = (),
) -> bytes:
    """Return the header of a log of Betaflight.

    Args:
        names: of the fields.
        signed: 1 for each field with a sign, else 0.
        key: predictor and encoding of each field in key frames.
        difference: the same in the frames between.
        headers: more headers; None leaves one of `HEADERS` out.
        version: of the format.
        interval: number of frames from a key frame to the next one.
        extra: header lines in front of `headers`.
    """
    lines = [
        "Product:Blackbox flight data recorder by Nicholas Sherlock",
        f"Data version:{version}",
        f"I interval:{interval}",
        "P interval:1/1",
        f"Field I name:{','.join(names)}",
        f"Field I signed:{','.join(map(str, signed))}",
    ]
    for mark, kinds in (("I", key), ("P", difference)):
        for name, numbers in zip(("predictor", "encoding"), zip(*kinds, strict=True), strict=True):
            lines.append(f"Field {mark} {name}:{','.join(map(str, numbers))}")
    merged = HEADERS | dict(headers)
    lines += [*extra, *(f"{name}:{text}" for name, text in merged.items() if text is not None)]
    return "".join(f"H {line}\n" for line in lines).encode()


def blackbox(
    microseconds: Sequence[int],
    rows: Sequence[Sequence[int]],
    fields: Sequence[str] = FIELDS,
    headers: dict[str, str | None] | None = None,
    end: bytes = b"E\xffEnd of log\x00",
) -> bytes:
    """Return a log of Betaflight: key frames alone, each field a number with a sign.

    A header of None is left out.
    """
    names = ["loopIteration", "time", *fields]
    signed = [0 if i < 2 else 1 for i in range(len(names))]
    key = [(0, 1 - each) for each in signed]
    data = header_lines(names, signed, key, [(0, 0)] * len(names), headers or {})
    for i, (time, row) in enumerate(zip(microseconds, rows, strict=True)):
        data += b"I" + unsigned(i) + unsigned(time % 2**32) + b"".join(map(vb, row))
    return data + end


Topic = tuple[str, int, Sequence[int], dict[str, tuple[str, Sequence[float]]]]
"""Name, instance, stamps [us], and the type and values of each field."""
_CODES = {
    "float": "f",
    "uint8_t": "B",
    "int16_t": "h",
    "int32_t": "i",
    "uint32_t": "I",
    "uint64_t": "Q",
    "bool": "?",
}


def ulog(
    topics: Sequence[Topic], parameters: dict[str, float] | None = None, begin: int = 0
) -> bytes:
    """Return a log of PX4. Messages come in the order of the rows: one of each topic in turn.

    Another subscription of a topic comes behind those before.
    """

    def message(kind: str, body: bytes) -> bytes:
        return struct.pack("<HB", len(body), ord(kind)) + body

    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", begin)
    data += message("B", bytes(40))
    for name, _, _, fields in {topic[0]: topic for topic in topics}.values():
        counts: dict[str, tuple[str, int]] = {}
        nested: dict[str, dict[str, str]] = {}
        places: set[str] = set()
        for field, (kind, _) in fields.items():
            base, _, rest = field.partition("[")
            if "]." in rest:  # of a nested message
                nested.setdefault(base, {})[rest.partition("].")[2]] = kind
                kind = f"{base}_report"
            place = field.partition(".")[0]
            counts[base] = (kind, counts.get(base, (kind, 0))[1] + (place not in places))
            places.add(place)
        for base, parts in nested.items():
            text = "".join(f"{kind} {part};" for part, kind in parts.items())
            data += message("F", f"{base}_report:{text}".encode())
        text = "uint64_t timestamp;" + "".join(
            f"{kind}[{count}] {base};"
            if any(field.startswith(f"{base}[") for field in fields)
            else f"{kind} {base};"
            for base, (kind, count) in counts.items()
        )
        data += message("F", f"{name}:{text}".encode())
    for name, value in (parameters or {}).items():
        key = f"float {name}".encode()
        data += message("P", bytes([len(key)]) + key + struct.pack("<f", value))
    for number, (name, instance, _, _) in enumerate(topics):
        data += message("A", struct.pack("<BH", instance, number) + name.encode())
    names = [topic[:2] for topic in topics]
    rows = [
        (names[:number].count(names[number]), (i + 0.5) / len(topics[number][2]), number, i)
        for number in range(len(topics))
        for i in range(len(topics[number][2]))
    ]
    for _, _, number, i in sorted(rows):
        _, _, stamps, fields = topics[number]
        body = struct.pack("<HQ", number, int(stamps[i]))
        for kind, values in fields.values():
            code = _CODES[kind]
            body += struct.pack(f"<{code}", values[i] if code in "f?" else int(values[i]))
        data += message("D", body)
    return data


Message = tuple[str, str, Sequence[str], Sequence[int], Sequence[Sequence[float | str]]]
"""Name, format of the columns behind TimeUS, their names, stamps [us], and rows."""


def dataflash(messages: Sequence[Message]) -> bytes:
    """Return a log of ArduPilot. Messages come in the order of their rows, of each kind in turn."""
    codes = {"f": "f", "B": "B", "h": "h", "i": "i", "N": "16s", "Z": "64s"}

    def definition(number: int, length: int, name: str, form: str, columns: str) -> bytes:
        body = struct.pack(
            "<BB4s16s64s", number, length, name.encode(), form.encode(), columns.encode()
        )
        return b"\xa3\x95\x80" + body

    data = definition(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    shape = {}
    for number, (name, form, columns, _, _) in enumerate(messages, start=130):
        shape[number] = "<Q" + "".join(codes[each] for each in form)
        size = 3 + struct.calcsize(shape[number])
        data += definition(number, size, name, f"Q{form}", ",".join(("TimeUS", *columns)))
    rows = [
        ((i + 0.5) / len(stamps), number, i)
        for number, (_, _, _, stamps, _) in enumerate(messages, start=130)
        for i in range(len(stamps))
    ]
    for _, number, i in sorted(rows):
        _, form, _, stamps, values = messages[number - 130]
        row = [
            value.encode() if isinstance(value, str) else value if code == "f" else int(value)
            for code, value in zip(form, values[i], strict=True)
        ]
        data += bytes([0xA3, 0x95, number]) + struct.pack(shape[number], int(stamps[i]), *row)
    return data


def usd(stamps: Sequence[int], columns: Mapping[str, Sequence[float]], version: int = 2) -> bytes:
    """Return a log of a Crazyflie with variables; stamps are in us, in version 1 in ms."""
    data = struct.pack("<BHHH", 0xBC, version, 1, 7) + b"fixed\0"
    data += struct.pack("<H", len(columns)) + b"".join(f"{name}(f)\0".encode() for name in columns)
    code = f"<H{'I' if version == 1 else 'Q'}{len(columns)}f"
    for time, *row in zip(stamps, *columns.values(), strict=True):
        data += struct.pack(code, 7, int(time), *row)
    return data + struct.pack("<I", zlib.crc32(data))


def write_blackbox(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """Write the gyro about x to a blackbox log; this and the next ones return the file."""
    rows = [[int(value)] for value in degrees]
    return _written(folder / "a.bbl", blackbox([*map(int, stamps)], rows, ["gyroADC[0]"]))


def write_ulog(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """The same as a ULog, with a slower topic beside it."""
    turn = np.radians(degrees)
    zeros = np.zeros(len(turn))
    fields = {f"gyro_rad[{i}]": ("float", turn if i == 0 else zeros) for i in range(3)}
    slow = stamps[::7]
    other = {"voltage_v": ("float", 16.0 + 0.001 * np.arange(len(slow)))}
    topics: list[Topic] = [
        ("sensor_combined", 0, stamps.tolist(), fields),
        ("battery_status", 0, slow.tolist(), other),
    ]
    return _written(folder / "a.ulg", ulog(topics))


def write_dataflash(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """The same as a DataFlash log, with a slower message beside it."""
    turn = np.radians(degrees)
    slow = stamps[::7]
    names = ("GyrX", "GyrY", "GyrZ")
    messages: list[Message] = [
        ("IMU", "fff", names, stamps.tolist(), [(each, 0.0, 0.0) for each in turn]),
        ("BAT", "f", ("Volt",), slow.tolist(), [(16.0 + 0.001 * i,) for i in range(len(slow))]),
    ]
    return _written(folder / "a.bin", dataflash(messages))


def write_usd(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """The same as a log of a Crazyflie."""
    return _written(folder / "a", usd(stamps.tolist(), {"gyro.x": degrees.tolist()}))


def write_csv(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """The same as a table with a mapping, times in us."""
    mapping = (
        "time: {column: t, unit: us}\ncolumns:\n  g: {signal: imu.angular_velocity.x, unit: dps}"
    )
    (folder / "a.mapping.yaml").write_text(mapping)
    rows = [f"{time},{value:g}" for time, value in zip(stamps, degrees, strict=True)]
    return _written(folder / "a.csv", "\n".join(["t,g", *rows]).encode())


def write_states(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """The same as the table of a simulated flight, times in s."""
    groups = {"p_W": "xyz", "q_WB": "wxyz", "v_W": "xyz", "w_W": "xyz", "vdot_W": "xyz"}
    names = [f"{name}.{axis}" for name, axes in groups.items() for axis in axes]
    lines = [",".join(["t [s]", *(f"{name} [m]" for name in names)])]
    for time, value in zip(stamps, degrees, strict=True):
        row = dict.fromkeys(names, 0.0) | {"q_WB.w": 1.0, "w_W.x": float(np.radians(value))}
        lines.append(",".join([f"{1e-6 * time:.6f}", *(f"{row[name]:.17g}" for name in names)]))
    return _written(folder / "a.csv", "\n".join(lines).encode())


def write_nanobench(folder: Path, stamps: np.ndarray, degrees: np.ndarray) -> Path:
    """The same as a file of NanoBench, times in s since 1970."""
    head = "t,px,py,pz,qx,qy,qz,qw,roll,pitch,yaw,imu_acc_x,imu_acc_y,imu_acc_z"
    lines = [f"{head},imu_gyro_x,imu_gyro_y,imu_gyro_z"]
    for time, value in zip(stamps, degrees, strict=True):
        whole, rest = divmod(int(time), 10**6)
        noise = (value * value) % 7.0  # values on a straight line are not measured
        cells = ["0,0,1,0,0,0,1,0,0,0,0", f"{noise},1", f"{np.radians(value):.17g},0,0"]
        lines.append(f"{1_700_000_000 + whole}.{rest:06d},{','.join(cells)}")
    return _written(folder / "a.csv", "\n".join(lines).encode())


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def read_here(path: Path) -> Flight:
    """Read a log in this process; `read_flight` starts another one."""
    found = read_any(LogFile(path), path.parent)
    assert isinstance(found, Flight)
    return found


Write = Callable[[Path, np.ndarray, np.ndarray], Path]
WRITERS: tuple[Write, ...] = (
    write_blackbox,
    write_ulog,
    write_dataflash,
    write_usd,
    write_csv,
    write_states,
    write_nanobench,
)
"""Write the same flight in each format: stamps (n) [us] and the gyro about x (n) [deg/s]."""
