"""Read Betaflight's blackbox logs, with orangebox: one of the logs in a file.

Roll to the right, nose down and counter-clockwise from above are positive, as in forward, left, up.
Motors are M1 rear right, M2 front right, M3 rear left, M4 front left. What a number means depends
on header and version:

- `gyro_scale` has the bits of a float: degrees per second of a count of the gyro, 1 since 3.1.
  Firmware before Betaflight states radians per microsecond.
- `blackbox_high_resolution` (since 4.4) multiplies gyro, rate setpoints and stick commands by 10.
- The voltage is in steps of 0.01 V since 4.0, of 0.1 V since 3.1, and the reading of a 12-bit
  converter before, whose scale is `vbatscale`. The current is in 0.01 A since 3.1, and a reading
  before, with offset and scale in `currentMeter`.
- `motorOutput` (before 3.1 `minthrottle` and `maxthrottle`) has the range of the motors.

What a header does not determine keeps the log's name, and a remark states it.

Source: github.com/betaflight/blackbox-log-viewer, and blackbox.c, battery.c and voltage.h of
Betaflight 2.9 to 2026.6, as facts.
"""

import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, Remark, parts
from workbench.logs.readers.topic_log import Row, Table, scaled, share, topic_record
from workbench.plant.gravity import GRAVITY

FORMAT = "Betaflight blackbox log"
MAGIC = b"H Product:Blackbox flight data recorder"
NEEDS = "orangebox"
_LONG_HEADER = re.compile(rb"(?:\A|\n)H [^\n]{10000}")
"""Pattern of a header that is far longer than any of Betaflight's; orangebox takes minutes."""
MOST_FRAMES = 5_000_000
"""Largest number of frames of all logs in a file."""
MOTORS = 8
HIGH_RESOLUTION = 10.0
FINER = re.compile(r"(gyroADC|gyroUnfilt|rcCommand)\[\d\]|setpoint\[[012]\]")
"""Fields that `blackbox_high_resolution` multiplies."""
FEATURE_3D = 1 << 12
LEAST_DEGREES = 1e-5
"""A smaller `gyro_scale` is in radians per microsecond; the finest gyros have 4e-3 degrees."""
LEAST_BITS = 1 << 23
"""A smaller whole number has the bits of no float, and is itself the scale."""
USUAL_POLES = 14.0
_REVISION = re.compile(r"(\w+)\s+v?(\d+)\.(\d+)(?:\.(\d+))?")
_DEG = np.pi / 180.0
_ADC = 3.3 / 4095.0
"""Voltage of a step of the converter that older firmware logs [V]."""
_TOPIC = "blackbox"
"""Name for the only table of such a log."""


class _Frames(NamedTuple):
    """The frames of a log.

    Attributes:
        headers: by name.
        names: of the fields.
        frames: their values.
        damage: what is wrong with the log, "" if nothing.
    """

    headers: Mapping[str, object]
    names: Sequence[str]
    frames: Sequence[tuple[float, ...]]
    damage: str


def read_blackbox(path: Path, number: int | None = None) -> FlightRecord:
    """Read a log of Betaflight.

    Args:
        path: the file.
        number: of the log in it, from 1; None for the longest one.

    Raises:
        WorkbenchError: if it cannot be read, is not such a log, or has no log of that number.
    """
    from orangebox.reader import Reader

    if _LONG_HEADER.search(path.read_bytes()):
        raise WorkbenchError(f"{path}: has a header of more than 10 kB: it is damaged")
    try:
        count = Reader(str(path)).log_count
    except MemoryError:
        raise
    except Exception as error:  # orangebox raises any exception on a damaged file
        raise WorkbenchError(f"{path}: cannot be read as a blackbox log: {error}") from error
    left = MOST_FRAMES

    def read(each: int) -> FlightRecord:
        nonlocal left
        found = _frames(path, each, left)
        left -= len(found.frames)
        return _record(path, found)

    return _one_of(path, count, number, read)


def _one_of(
    path: Path, count: int, number: int | None, read: Callable[[int], FlightRecord]
) -> FlightRecord:
    """Return one of the logs in a file, with a remark that lists them with their lengths.

    Args:
        path: the file.
        count: of logs in it.
        number: of the log, from 1; None for the longest one.
        read: reads the log with a number.

    Raises:
        WorkbenchError: if none can be read, or there is no log of that number.
    """
    if number is not None:
        if not 1 <= number <= count:
            has = f"{count} logs" if count != 1 else "one log"
            raise WorkbenchError(f"{path}: has {has}: --log-number {number} is not one of them")
        flight = read(number)
        if count == 1:
            return flight
        remark = Remark(f"this is log {number} of the {count} in the file", count, f"log {number}")
        return replace(flight, remarks=(remark, *flight.remarks))
    best: FlightRecord | None = None
    chosen, failure = 0, None
    lengths: list[float] = []
    for each in range(1, count + 1):
        try:
            flight = read(each)
        except WorkbenchError as error:
            failure = failure or error
            lengths.append(0.0)
            continue
        lengths.append(flight.end)
        if best is None or flight.end > best.end:
            best, chosen = flight, each
    if best is None:
        raise failure or WorkbenchError(f"{path}: has no log: it is empty or damaged")
    if count == 1:
        return best
    listed = ", ".join(
        f"{each} {f'has {length:.2f} s' if length else 'has no frames'}"
        for each, length in enumerate(lengths, start=1)
    )
    remark = Remark(
        f"the file has {count} logs ({listed}): this is number {chosen}, the longest; "
        "--log-number N takes another one",
        count,
        f"log {chosen}",
    )
    return replace(best, remarks=(remark, *best.remarks), logs=tuple(lengths))


def _frames(path: Path, number: int, most: int) -> _Frames:
    """Return the frames of a log, as far as they can be read."""
    from orangebox import Parser

    try:
        # A new parser for each log: it keeps the headers of the log before.
        parser = Parser.load(str(path), number, allow_invalid_header=True)
    except MemoryError:
        raise
    except Exception as error:  # orangebox raises any exception on a damaged file
        raise WorkbenchError(f"{path}: cannot be read as a blackbox log: {error}") from error
    frames: list[tuple[float, ...]] = []
    damage = ""
    try:
        for frame in parser.frames():
            if len(frames) >= most:
                damage = f"only the first {MOST_FRAMES} frames of the file were read"
                break
            frames.append(frame.data)
    except MemoryError:
        raise
    except Exception as error:
        # At the end of the data it fails, too, if there is no end mark: as when power was lost.
        if parser.reader.tell() < len(parser.reader):
            place = f"frame {len(frames)}"
            text = f"the log is damaged, and was read up to {place}: {error}"
            damage = Remark(text, len(frames), place)
    return _Frames(dict(parser.headers), list(parser.field_names), frames, damage)


def _record(path: Path, found: _Frames) -> FlightRecord:
    """Return the flight record of the frames of a log."""
    headers = found.headers
    fields = _columns(found.names, found.frames)
    if len(fields.get("time", ())) < 2:
        raise WorkbenchError(f"{path}: has fewer than two frames: it is empty or damaged")
    microseconds = fields.pop("time")
    fields.pop("loopIteration", None)
    if _number(headers, "blackbox_high_resolution") > 0.0:
        fields = {
            name: values / HIGH_RESOLUTION if FINER.fullmatch(name) else values
            for name, values in fields.items()
        }
    rows, remarks = _rows(headers, fields)
    filtered = any(name.startswith("gyroADC") for name in fields)
    return topic_record(
        path,
        FORMAT,
        {_TOPIC: Table(microseconds, fields)},
        rows,
        tick=1e-6,
        counter=True,
        noun="frame",
        firmware=str(headers.get("Firmware revision", headers.get("Firmware type", ""))),
        parameters={
            str(name): value if isinstance(value, int | float) else str(value)
            for name, value in headers.items()
        },
        remarks=(
            found.damage,
            "imu.angular_velocity is behind Betaflight's gyro filters" if filtered else "",
            *remarks,
        ),
    )


def _columns(names: Sequence[str], frames: Sequence[tuple[float, ...]]) -> dict[str, np.ndarray]:
    """Return the columns by name; a value that a frame lacks is NaN."""
    rows = [frame for frame in frames if len(frame) == len(names)]
    columns = zip(*rows, strict=True) if rows else ()
    return {
        name: np.array(
            [value if isinstance(value, int | float) else np.nan for value in values], dtype=float
        )
        for name, values in zip(names, columns, strict=False)
    }


def _number(headers: Mapping[str, object], name: str) -> float:
    """Return a number of the headers, 0 if there is none."""
    value = headers.get(name)
    return float(value) if isinstance(value, int | float) and abs(value) < 1e9 else 0.0


def _pair(headers: Mapping[str, object], *names: str) -> tuple[float, float] | None:
    """Return two numbers of the headers, from the first of some names that has them."""
    for name in names:
        value = headers.get(name)
        if isinstance(value, list) and len(value) == 2:
            first, second = value
            if isinstance(first, int | float) and isinstance(second, int | float):
                return float(first), float(second)
    return None


def _revision(headers: Mapping[str, object]) -> tuple[str, tuple[int, int, int]]:
    """Return the name of the firmware in lower case, and its version; "" and zeros if unknown."""
    found = _REVISION.match(str(headers.get("Firmware revision", "")))
    if found is None:
        return "", (0, 0, 0)
    return found[1].lower(), (int(found[2]), int(found[3]), int(found[4] or 0))


def _gyro_scale(headers: Mapping[str, object]) -> float:
    """Return the angular velocity of a count of the gyro [rad/s], 0 if it is not stated."""
    value = next((headers[each] for each in ("gyro_scale", "gyro.scale") if each in headers), None)
    if isinstance(value, int) and LEAST_BITS <= value < 2**32:
        (value,) = struct.unpack("<f", struct.pack("<I", value))
    firmware, version = _revision(headers)
    if value is None and firmware == "betaflight" and version >= (3, 1, 0):
        value = 1.0
    if not isinstance(value, int | float) or not 0.0 < value < LEAST_BITS:
        return 0.0
    return value * 1e6 if value < LEAST_DEGREES else value * _DEG


Column = tuple[str, str, str, Callable[[np.ndarray], np.ndarray]]
"""A field, its signal, the unit, and the conversion."""


def _rows(
    headers: Mapping[str, object], fields: Mapping[str, np.ndarray]
) -> tuple[list[Row], list[Remark]]:
    """Return the signals of Betaflight's fields, and remarks on fields without one."""
    columns: list[Column] = []
    remarks: list[Remark] = []

    def unknown(prefix: str, why: str) -> None:
        names = [name for name in fields if name.startswith(prefix)]
        if names:
            remarks.append(
                Remark(f"{names[0]} keeps its name, without a unit: {why}", len(names), names[0])
            )

    gyro, gravity = _gyro_scale(headers), _number(headers, "acc_1G")
    for i, (turn, force) in enumerate(zip(GYRO, FORCE, strict=True)):
        unfiltered = parts("imu.unfiltered.")[i]
        if gyro:
            columns += [
                (f"gyroADC[{i}]", turn, "rad/s", scaled(gyro)),
                (f"gyroUnfilt[{i}]", turn, "rad/s", scaled(gyro)),
                (f"gyroUnfilt[{i}]", unfiltered, "rad/s", scaled(gyro)),
            ]
        if gravity > 0.0:
            columns.append((f"accSmooth[{i}]", force, "m/s^2", scaled(GRAVITY / gravity)))
        columns.append((f"setpoint[{i}]", parts("rate_setpoint.w_")[i], "rad/s", scaled(_DEG)))
    columns.append(("setpoint[3]", "attitude_setpoint.thrust", "1", scaled(1e-3)))
    if not gyro:
        unknown("gyro", "the header has no gyro_scale")
    if not gravity > 0.0:
        unknown("accSmooth", "the header has no acc_1G")
    motors, why = _motors(headers)
    columns += motors
    if why:
        unknown("motor[", why)
    poles = _number(headers, "motor_poles")
    if poles <= 0.0 and "eRPM[0]" in fields:
        remarks.append(
            Remark(f"rotors.speed: the header has no motor_poles: {USUAL_POLES:g} are assumed")
        )
    # eRPM is in hundreds of electrical revolutions per minute.
    turns = 100.0 * 2.0 / (poles if poles > 0.0 else USUAL_POLES)
    columns += [
        (f"eRPM[{i}]", f"rotors.speed.{i}", "rad/s", scaled(turns * np.pi / 30.0))
        for i in range(MOTORS)
    ]
    battery, why = _battery(headers)
    columns += battery
    found = {name for name, *_ in battery}
    for name in ("vbat", "amperage"):
        if not any(each.startswith(name) for each in found):
            unknown(name, why)
    rows = [Row(_TOPIC, (field,), (name,), unit, make) for field, name, unit, make in columns]
    return rows, remarks


def _motors(headers: Mapping[str, object]) -> tuple[list[Column], str]:
    """Return the columns of the motor commands, or the reason why there are none."""
    output = _pair(headers, "motorOutput")
    low, full = output or (_number(headers, "minthrottle"), _number(headers, "maxthrottle"))
    features = headers.get("features")
    if isinstance(features, int) and features & FEATURE_3D:
        return [], "the feature 3D is on, so the motors also turn backwards"
    if not full > low:
        return [], "the header does not state their range (motorOutput)"
    return [
        (f"motor[{i}]", f"motors.command_{i + 1}", "1", share(low, full)) for i in range(MOTORS)
    ], ""


def _battery(headers: Mapping[str, object]) -> tuple[list[Column], str]:
    """Return the columns of voltage and current, and the reason why one is missing."""
    firmware, version = _revision(headers)
    first = {"betaflight": (3, 1, 0), "cleanflight": (2, 0, 0)}.get(firmware)
    if first is None:
        named = str(headers.get("Firmware revision", "")) or "the firmware, which is not stated,"
        return [], f"the unit that {named} has is not known"
    if version >= first:
        volts = 0.01 if firmware == "betaflight" and version >= (4, 0, 0) else 0.1
        return [
            ("vbatLatest", "battery.voltage", "V", scaled(volts)),
            ("amperageLatest", "battery.current", "A", scaled(0.01)),
        ], ""
    columns: list[Column] = []
    scale = _number(headers, "vbatscale") or _number(headers, "vbat_scale")
    if scale > 0.0:
        # The divider's ratio is a tenth of the scale.
        columns.append(("vbatLatest", "battery.voltage", "V", scaled(0.1 * scale * _ADC)))
    meter = _pair(headers, "currentMeter", "currentSensor")
    if meter and meter[1] != 0.0:
        offset, sensor = meter  # [mV], [mV / 10 A]
        columns.append(
            (
                "amperageLatest",
                "battery.current",
                "A",
                lambda reading: (1e3 * _ADC * reading - offset) * 10.0 / sensor,
            )
        )
    return columns, "the header has no vbatscale or currentMeter"
