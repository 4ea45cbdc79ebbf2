"""Read Betaflight's blackbox logs, with orangebox: the first log in a file.

Betaflight's gyro and setpoints are in degrees per second; roll to the right, nose down and
counter-clockwise from above are positive, as in forward, left, up. Its motors are M1 rear right, M2
front right, M3 rear left, M4 front left.

Source: github.com/betaflight/blackbox-log-viewer and blackbox.c of Betaflight, as facts.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, parts
from workbench.logs.readers.topic_log import Row, Table, scaled, share, topic_record
from workbench.plant.gravity import GRAVITY

FORMAT = "Betaflight blackbox log"
MAGIC = b"H Product:Blackbox flight data recorder"
NEEDS = "orangebox"
MOST_FRAMES = 5_000_000
MOTORS = 8
_DEG = np.pi / 180.0
_TOPIC = "blackbox"
"""Name for the only table of such a log."""


def read_blackbox(path: Path) -> FlightRecord:
    """Read a log of Betaflight.

    Raises:
        WorkbenchError: if it cannot be read, or is not such a log.
    """
    from orangebox import Parser

    frames: list[tuple[float, ...]] = []
    damage = ""
    try:
        parser = Parser.load(str(path), allow_invalid_header=True)
        headers = dict(parser.headers)
        names = list(parser.field_names)
        count = parser.reader.log_count
        for frame in parser.frames():
            frames.append(frame.data)
            if len(frames) >= MOST_FRAMES:
                damage = f"only the first {MOST_FRAMES} frames were read"
                break
    except Exception as error:  # orangebox raises any exception on a damaged file
        if len(frames) < 2:
            raise WorkbenchError(f"{path}: cannot be read as a blackbox log: {error}") from error
        damage = f"the file is damaged, and was read up to there: {error}"
    fields = _columns(names, frames)
    if len(fields.get("time", ())) < 2:
        raise WorkbenchError(f"{path}: has fewer than two frames: it is empty or damaged")
    microseconds = fields.pop("time")
    fields.pop("loopIteration", None)
    time = (microseconds - microseconds[0]) * 1e-6
    filtered = any(name.startswith("gyroADC") for name in fields)
    return topic_record(
        path,
        FORMAT,
        {_TOPIC: Table(time, fields)},
        _rows(headers),
        end=float(np.max(time)),
        firmware=str(headers.get("Firmware revision", headers.get("Firmware type", ""))),
        parameters={
            str(name): value if isinstance(value, int | float) else str(value)
            for name, value in headers.items()
        },
        remarks=(
            damage,
            "imu.angular_velocity is behind Betaflight's gyro filters" if filtered else "",
            f"the file has {count} logs: this is the first one" if count > 1 else "",
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


def _number(headers: Mapping[str, object], name: str, otherwise: float) -> float:
    """Return a number of the headers that is not 0, or else a default."""
    value = headers.get(name)
    return (float(value) if isinstance(value, int | float) else otherwise) or otherwise


def _rows(headers: Mapping[str, object]) -> list[Row]:
    """Return the signals of Betaflight's fields."""
    gravity = scaled(GRAVITY / _number(headers, "acc_1G", 2048.0))
    columns: list[tuple[str, str, str, Callable[[np.ndarray], np.ndarray]]] = []
    for i, (gyro, force) in enumerate(zip(GYRO, FORCE, strict=True)):
        unfiltered = parts("imu.unfiltered.")[i]
        columns += [
            (f"gyroADC[{i}]", gyro, "rad/s", scaled(_DEG)),
            (f"gyroUnfilt[{i}]", gyro, "rad/s", scaled(_DEG)),
            (f"gyroUnfilt[{i}]", unfiltered, "rad/s", scaled(_DEG)),
            (f"accSmooth[{i}]", force, "m/s^2", gravity),
            (f"setpoint[{i}]", parts("rate_setpoint.w_")[i], "rad/s", scaled(_DEG)),
        ]
    columns.append(("setpoint[3]", "attitude_setpoint.thrust", "1", lambda value: value / 1000.0))
    output = headers.get("motorOutput")
    low, full = output if isinstance(output, list) and len(output) == 2 else (1000, 2000)
    low, full = (float(each) if isinstance(each, int | float) else 0.0 for each in (low, full))
    # eRPM is in hundreds of electrical revolutions per minute.
    turns = 100.0 * 2.0 / _number(headers, "motor_poles", 14.0)
    for i in range(MOTORS):
        if full > low:
            columns.append((f"motor[{i}]", f"motors.command_{i + 1}", "1", share(low, full)))
        columns.append(
            (f"eRPM[{i}]", f"rotors.speed.{i}", "rad/s", lambda rpm: np.pi / 30.0 * (turns * rpm))
        )
    columns += [
        ("vbatLatest", "battery.voltage", "V", scaled(0.01)),
        ("amperageLatest", "battery.current", "A", scaled(0.01)),
    ]
    return [Row(_TOPIC, (field,), (name,), unit, make) for field, name, unit, make in columns]
