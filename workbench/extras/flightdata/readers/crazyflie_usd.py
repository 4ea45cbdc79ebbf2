"""Read the logs of a Crazyflie's micro-SD card (usd), versions 1 and 2, also compressed with gzip.

A file has a header: 0xBC; version (u16); number of events (u16); and for each event its number
(u16), its name, the number of its variables (u16), and the variables as "acc.x(f)"; texts end with
0. Samples follow: number of the event (u16), time (version 1: u32 [ms], 2: u64 [us]), and values.
The last four bytes are the CRC-32 of everything before.

Accelerations are in g, the gyro in degrees per second, angles in degrees, and the firmware's pitch
is positive nose up. `pwm.m*_pwm` are the commands to the motors after battery compensation; if they
were not logged, `motor.m*` is used.

Source: tools/usdlog/cfusdlog.py of bitcraze/crazyflie-firmware, as a description of the format.
"""

import re
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, LogRemark
from workbench.common.series import Series, make_series
from workbench.extras.flightdata.readers.clock import SampleClock, read_clock, stamps_of
from workbench.logs.readers.log_reader import LogReader
from workbench.logs.readers.packed import PackedFile, log_stem
from workbench.logs.readers.rotations import without_jumps
from workbench.plant.gravity import GRAVITY

USD_FORMAT = "Crazyflie usd log"
USD_MAGIC = b"\xbc"
USD_FULL_PWM = 65535.0
MAX_USD_VARIABLES = 500
"""Largest number of variables of all events; the buffers of the firmware hold far fewer."""
_VARIABLE_PATTERN = re.compile(r"([\w.]+)\(([BHIQbhiqef])\)")
_USD_DEG_IN_RAD = np.pi / 180.0

SIGNAL_BY_USD_VARIABLE: Mapping[str, tuple[str, str, float]] = {
    **{f"acc.{x}": (f"imu.linear_acceleration.{x}", "m/s^2", GRAVITY) for x in "xyz"},
    **{f"gyro.{x}": (f"imu.angular_velocity.{x}", "rad/s", _USD_DEG_IN_RAD) for x in "xyz"},
    **{f"stateEstimate.{x}": (f"estimate.{x}", "m", 1.0) for x in "xyz"},
    **{f"stateEstimate.v{x}": (f"estimate.v_{x}", "m/s", 1.0) for x in "xyz"},
    **{f"stateEstimate.a{x}": (f"estimate.a_{x}", "m/s^2", GRAVITY) for x in "xyz"},
    **{f"stateEstimate.q{x}": (f"estimate.q_{x}", "1", 1.0) for x in "wxyz"},
    **{
        f"{log}.{name}": (
            f"{topic}.{name}",
            "rad",
            -_USD_DEG_IN_RAD if name == "pitch" else _USD_DEG_IN_RAD,
        )
        for log, topic in (
            ("stateEstimate", "estimate"),
            ("stabilizer", "estimate"),
            ("controller", "attitude_setpoint"),
        )
        for name in ("roll", "pitch", "yaw")
    },
    "controller.rollRate": ("rate_setpoint.w_x", "rad/s", _USD_DEG_IN_RAD),
    "controller.pitchRate": ("rate_setpoint.w_y", "rad/s", -_USD_DEG_IN_RAD),
    "controller.yawRate": ("rate_setpoint.w_z", "rad/s", _USD_DEG_IN_RAD),
    "controller.actuatorThrust": ("attitude_setpoint.thrust", "1", 1.0 / USD_FULL_PWM),
    **{f"ctrltarget.{x}": (f"setpoint.{x}", "m", 1.0) for x in "xyz"},
    **{f"ctrltarget.v{x}": (f"setpoint.v_{x}", "m/s", 1.0) for x in "xyz"},
    "ctrltarget.yaw": ("setpoint.yaw", "rad", _USD_DEG_IN_RAD),
    "pm.vbat": ("battery.voltage", "V", 1.0),
    "pm.vbatMV": ("battery.voltage", "V", 1e-3),
    **{f"motor.m{i}": (f"motors.command_{i}", "1", 1.0 / USD_FULL_PWM) for i in (1, 2, 3, 4)},
    **{f"pwm.m{i}_pwm": (f"motors.command_{i}", "1", 1.0 / USD_FULL_PWM) for i in (1, 2, 3, 4)},
}
"""For each variable of the firmware: name and unit of the signal, and factor to that unit.

If a log has two variables of one signal, the later one in this table counts; the other one keeps
its own name.
"""


class _Event(NamedTuple):
    name: str
    variables: tuple[str, ...]
    kind: np.dtype


def read_usd(path: Path) -> Flight:
    """Read a usd log of a Crazyflie as far as it is intact.

    Raises:
        WorkbenchError: if it cannot be read, or is not such a log.
    """
    file = PackedFile(path)
    data = b"".join(file.blocks())
    cut = file.remark
    events, at, version = _events(path, data)
    rows, places, rest = _event_rows(data, at, events)
    tick = 1e-3 if version == 1 else 1e-6
    found = {
        number: np.frombuffer(parts, events[number].kind) for number, parts in rows.items() if parts
    }
    streams: dict[int, str] = {}
    for number in found:  # damaged names may be equal
        name = events[number].name
        streams[number] = name if name not in streams.values() else f"{name} ({number})"
    columns: dict[str, tuple[int, np.ndarray]] = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for number, table in found.items():
            for i, variable in enumerate(events[number].variables):
                columns[variable] = (number, table[f"v{i}"].astype(float))
    clock = read_clock(
        {
            streams[number]: stamps_of(
                table["t"],
                [values for event, values in columns.values() if event == number],
                np.array(places[number]) if number in places else None,
            )
            for number, table in found.items()
        },
        tick,
        counter=version == 1,
    )
    if not clock.end > 0.0:
        raise WorkbenchError(f"{path}: has fewer than two samples: it is empty or damaged")
    remarks = [*filter(None, (cut, _end_fault(data, rest))), *clock.remarks]
    signals = _signals(
        {
            variable: (clock.times[streams[number]], values)
            for variable, (number, values) in columns.items()
        },
        clock,
    )
    if any(name.startswith("motors.") for name in signals):
        remarks.append(
            "the motors' commands are shares of the voltage, after the battery compensation"
            if "pwm.m1_pwm" in columns
            else "the motors' commands are motor.m*: whether they include the battery compensation "
            "depends on the firmware"
        )
    return Flight(
        name=log_stem(path) if path.suffix == ".gz" and "." in path.stem else path.stem,
        source=path,
        format=USD_FORMAT,
        firmware="Crazyflie",
        parameters={"usd_version": version, "first_sample_s": clock.begin * tick},
        remarks=tuple(remarks),
        signals=without_jumps(signals),
        end=clock.end,
        clock_start=clock.begin * tick,
    )


def _events(path: Path, data: bytes) -> tuple[dict[int, _Event], int, int]:
    """Return the events by number, the offset of the first sample, and the version."""
    if not data.startswith(USD_MAGIC):
        raise WorkbenchError(f"{path}: is not a Crazyflie usd log: it does not begin with 0xBC")
    try:
        version, count = struct.unpack_from("<HH", data, 1)
        if version not in (1, 2):
            raise WorkbenchError(f"{path}: is a usd log of version {version}: 1 and 2 are known")
        at, seen, events = 5, 0, {}
        for _ in range(count):
            (number,) = struct.unpack_from("<H", data, at)
            name, at = _terminated_text(data, at + 2)
            (size,) = struct.unpack_from("<H", data, at)
            at, seen = at + 2, seen + size
            if seen > MAX_USD_VARIABLES:
                raise ValueError(f"it names more than {MAX_USD_VARIABLES} variables")
            variables = []
            for _ in range(size):
                text, at = _terminated_text(data, at)
                variables.append(text)
            events[number] = _usd_event(version, name, variables)
    except (struct.error, ValueError, IndexError) as error:
        raise WorkbenchError(f"{path}: the header of the usd log is damaged: {error}") from error
    return events, at, version


def _usd_event(version: int, name: str, variables: list[str]) -> _Event:
    fields = [("number", "<u2"), ("t", "<u4" if version == 1 else "<u8")]
    names = []
    for i, text in enumerate(variables):
        found = _VARIABLE_PATTERN.fullmatch(text)
        if found is None:
            raise ValueError(f"{text[:40]!a} is not a variable")
        names.append(found[1])
        fields.append((f"v{i}", np.dtype(found[2]).newbyteorder("<").str))
    return _Event(name, tuple(names), np.dtype(fields))


def _terminated_text(data: bytes, at: int) -> tuple[str, int]:
    """Return a text that ends with 0, and the offset after it."""
    end = data.index(b"\0", at, at + 200)
    return data[at:end].decode("ascii"), end + 1


def _event_rows(
    data: bytes, at: int, events: Mapping[int, _Event]
) -> tuple[dict[int, bytearray], dict[int, list[int]], int]:
    """Return the bytes of the samples of each event, their offsets, and that after the last one.

    The offsets of a single event are not needed, and left out.
    """
    rows = {number: bytearray() for number in events}
    places: dict[int, list[int]] = {number: [] for number in events if len(events) > 1}
    sizes = {number: event.kind.itemsize for number, event in events.items()}
    while at + 2 <= len(data):
        number = data[at] | data[at + 1] << 8
        size = sizes.get(number)
        if size is None or at + size > len(data):
            break
        end = at + size
        if len(sizes) == 1:  # only one kind of event: read all samples at once
            whole = (len(data) - at) // size
            numbers = np.frombuffer(data, f"<u2,V{size - 2}", whole, at)["f0"]
            other = np.nonzero(numbers != number)[0]
            end = at + size * int(other[0] if len(other) else whole)
        else:
            places[number].append(at)
        rows[number] += data[at:end]
        at = end
    return rows, places, at


def _end_fault(data: bytes, rest: int) -> str:
    """Return what is wrong with the end of the file: extra bytes or checksum; "" if nothing."""
    left = len(data) - rest
    if left == 4:
        (said,) = struct.unpack_from("<I", data, rest)
        if said == zlib.crc32(data[:rest]):
            return ""
        return "the log's checksum does not match its content: it is damaged"
    if left == 0:
        return "the log has no checksum at its end: it was cut, or the Crazyflie lost power"
    text = f"the last {left} bytes of the log are not samples and were left out: the log is damaged"
    return LogRemark(text, left, f"byte {rest}")


def _signals(
    columns: Mapping[str, tuple[np.ndarray, np.ndarray]], clock: SampleClock
) -> dict[str, Series]:
    """Return the signals of the variables."""
    source = {
        SIGNAL_BY_USD_VARIABLE[each][0]: each for each in SIGNAL_BY_USD_VARIABLE if each in columns
    }
    signals = {}
    for each, (time, values) in columns.items():
        name, unit, factor = SIGNAL_BY_USD_VARIABLE.get(each, (each, "", 1.0))
        if source.get(name, each) != each:
            name, unit, factor = each, "", 1.0
        signals[name] = make_series(
            name, unit, time, factor * values, end=clock.end, breaks=clock.breaks
        )
    return signals


LOG_READER = LogReader(
    USD_FORMAT,
    "a Crazyflie's usd log",
    lambda _, head: head.startswith(USD_MAGIC),
    lambda file: read_usd(file.path),
    place=40,
)
