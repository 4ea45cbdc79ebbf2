"""Betaflight's blackbox logs, by orangebox; the first log of a file that has several.

Betaflight's gyro and set-points are in degrees per second; roll to the right, nose down and
counter-clockwise from above are positive, as in forward, left, up. Its motors count so:
M1 rear right, M2 front right, M3 rear left, M4 front left.

Source: github.com/betaflight/blackbox-log-viewer and blackbox.c of Betaflight, as facts.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord, Signal, make_signal
from workbench.logs.readers.names import own_name
from workbench.logs.readers.packed import stem
from workbench.plant.gravity import GRAVITY

FORMAT = "Betaflight blackbox log"
MAGIC = b"H Product:Blackbox flight data recorder"
NEEDS = "orangebox"
MOST_FRAMES = 5_000_000
MOTORS = 8
_DEG = np.pi / 180.0


def read_blackbox(path: Path) -> FlightRecord:
    """Read a log of Betaflight.

    Raises:
        WorkbenchError: if it cannot be read, or is none.
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
    except Exception as error:  # it raises whatever its parsing meets in a damaged file
        if len(frames) < 2:
            raise WorkbenchError(f"{path}: cannot be read as a blackbox log: {error}") from error
        damage = f"the file is damaged, and was read up to there: {error}"
    table = _table(names, frames)
    if len(table.get("time", ())) < 2:
        raise WorkbenchError(f"{path}: has no two frames: it is empty or damaged")
    begin = table["time"][0]
    time = (table["time"] - begin) * 1e-6
    end = float(np.max(time))
    signals: dict[str, Signal] = {}

    def add(name: str, unit: str, values: np.ndarray) -> None:
        if name not in signals and np.isfinite(values).any():
            signals[name] = make_signal(name, unit, time, values, end=end)

    remarks = _add_all(table, headers, add)
    for field, values in table.items():
        if field not in ("time", "loopIteration"):
            add(own_name("blackbox", field), "", values)
    if count > 1:
        remarks.append(f"the file has {count} logs: this is the first one")
    plain = {
        str(name): value if isinstance(value, int | float) else str(value)
        for name, value in headers.items()
    }
    return FlightRecord(
        name=stem(path),
        source=path,
        format=FORMAT,
        firmware=str(headers.get("Firmware revision", headers.get("Firmware type", ""))),
        parameters=plain,
        remarks=tuple(filter(None, (damage, *remarks))),
        signals=signals,
        end=end,
    )


def _table(names: Sequence[str], frames: Sequence[tuple[float, ...]]) -> dict[str, np.ndarray]:
    """Return the columns by name; what a frame does not have is NaN."""
    rows = [frame for frame in frames if len(frame) == len(names)]
    columns = zip(*rows, strict=True) if rows else ()
    table = {}
    for name, values in zip(names, columns, strict=False):
        table[name] = np.array(
            [value if isinstance(value, int | float) else np.nan for value in values], dtype=float
        )
    return table


def _number(headers: Mapping[str, object], name: str, otherwise: float) -> float:
    value = headers.get(name)
    return float(value) if isinstance(value, int | float) else otherwise


def _add_all(table: Mapping[str, np.ndarray], headers: Mapping[str, object], add) -> list[str]:  # type: ignore[no-untyped-def]
    """Add the signals that have a name of ours, and return remarks."""
    remarks = []
    for i, axis in enumerate("xyz"):
        gyro = table.get(f"gyroADC[{i}]", table.get(f"gyroUnfilt[{i}]"))
        if gyro is not None:
            add(f"imu.angular_velocity.{axis}", "rad/s", _DEG * gyro)
        if f"gyroUnfilt[{i}]" in table:
            add(f"imu.unfiltered.{axis}", "rad/s", _DEG * table[f"gyroUnfilt[{i}]"])
        if f"accSmooth[{i}]" in table:
            one = _number(headers, "acc_1G", 2048.0) or 2048.0
            add(
                f"imu.linear_acceleration.{axis}", "m/s^2", GRAVITY / one * table[f"accSmooth[{i}]"]
            )
        if f"setpoint[{i}]" in table:
            add(f"rate_setpoint.w_{axis}", "rad/s", _DEG * table[f"setpoint[{i}]"])
    if any(name.startswith("gyroADC") for name in table):
        remarks.append("imu.angular_velocity is behind Betaflight's gyro filters")
    if "setpoint[3]" in table:
        add("attitude_setpoint.thrust", "1", table["setpoint[3]"] / 1000.0)
    output = headers.get("motorOutput")
    low, full = output if isinstance(output, list) and len(output) == 2 else (1000, 2000)
    low, full = (float(each) if isinstance(each, int | float) else 0.0 for each in (low, full))
    poles = _number(headers, "motor_poles", 14.0) or 14.0
    for i in range(MOTORS):
        if f"motor[{i}]" in table and full > low:
            share = np.clip((table[f"motor[{i}]"] - low) / (full - low), 0.0, 1.0)
            add(f"motors.command_{i + 1}", "1", share)
        if f"eRPM[{i}]" in table:  # hundreds of electrical turns a minute
            turns = 100.0 * 2.0 / poles * table[f"eRPM[{i}]"]
            add(f"rotors.speed.{i}", "rad/s", np.pi / 30.0 * turns)
    for field, name, unit in (
        ("vbatLatest", "voltage", "V"),
        ("amperageLatest", "current", "A"),
    ):
        if field in table:
            add(f"battery.{name}", unit, 0.01 * table[field])
    return remarks
