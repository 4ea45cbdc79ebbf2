r"""Read a CSV file with a mapping file that names its columns.

    delimiter: ","                  # or ";" or "\t"; a comma if left out
    firmware: my own, version 3     # what you like, or nothing
    time: {column: t, unit: us}
    columns:
      gx: {signal: imu.angular_velocity.x, unit: deg/s}
      gy: {signal: imu.angular_velocity.y, unit: deg/s, sign: -1}
      m1: {signal: motors.command_1, unit: "1", scale: 0.001, offset: -1.0}
      vbat: {signal: battery.voltage, unit: mV, delay: 0.1}

A value is `sign * (scale * x + offset)` in the unit, and is converted to SI. Units that are not in
`UNITS` stay unchanged. Empty cells, and cells without a number, count as not measured.
"""

import csv
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_files import read_plain
from workbench.logs.flight_record import FlightRecord, Signal, make_signal, rising_rows
from workbench.logs.readers.packed import read_packed, stem
from workbench.logs.readers.topic_log import SIGNAL_NAME
from workbench.plant.gravity import GRAVITY

FORMAT = "CSV with a mapping"
UNITS: Mapping[str, tuple[str, float]] = {
    "deg": ("rad", math.pi / 180.0),
    "deg/s": ("rad/s", math.pi / 180.0),
    "rpm": ("rad/s", math.pi / 30.0),
    "g": ("m/s^2", GRAVITY),
    "mm": ("m", 1e-3),
    "cm": ("m", 1e-2),
    "ft": ("m", 0.3048),
    "mm/s": ("m/s", 1e-3),
    "cm/s": ("m/s", 1e-2),
    "km/h": ("m/s", 1.0 / 3.6),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "ns": ("s", 1e-9),
    "mV": ("V", 1e-3),
    "mA": ("A", 1e-3),
    "%": ("1", 1e-2),
}
"""Conversions of units to SI."""
LARGEST_MAPPING = 1_000_000
_KEYS = ("delimiter", "firmware", "time", "columns")
_COLUMN_KEYS = ("signal", "unit", "scale", "offset", "sign", "delay")


@dataclass(frozen=True)
class _Column:
    """The conversion of a column."""

    signal: str
    unit: str
    factor: float
    offset: float
    delay: float | None


def read_csv(path: Path, mapping: Path) -> FlightRecord:
    """Read a CSV file, which may be compressed, with a mapping.

    Raises:
        WorkbenchError: if one of them cannot be read, or the mapping does not fit the file.
    """
    delimiter, firmware, clock, wanted = _mapping(mapping)
    data, cut = read_packed(path)
    table, damage = _table(path, data, delimiter, [clock.signal, *wanted])
    time = clock.factor * table[clock.signal] + clock.offset
    time[~np.isfinite(time)] = np.nan
    if np.isnan(time).all():
        raise WorkbenchError(f"{path}: its column {clock.signal} has no number: name its time")
    time = time - np.nanmin(time)
    known = time[np.isfinite(time)]
    known = known[rising_rows(known)]
    end = float(known[-1]) if len(known) else 0.0
    signals: dict[str, Signal] = {}
    for name, column in wanted.items():
        values = column.factor * table[name] + column.offset
        signals[column.signal] = make_signal(
            column.signal, column.unit, time, values, end=end, delay=column.delay
        )
    empty = [signal.name for signal in signals.values() if len(signal.time) == 0]
    remarks = [cut, damage, f"without a single number: {', '.join(empty)}" if empty else ""]
    return FlightRecord(
        name=stem(path),
        source=path,
        format=FORMAT,
        firmware=firmware,
        parameters={"mapping": mapping.name},
        remarks=tuple(filter(None, remarks)),
        signals={name: signal for name, signal in signals.items() if len(signal.time)},
        end=end,
    )


def _mapping(path: Path) -> tuple[str, str, _Column, dict[str, _Column]]:
    """Return delimiter, firmware, the time column, and the other columns by name."""
    try:
        found = yaml.safe_load(read_plain(path, LARGEST_MAPPING))
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{path}: cannot be read as YAML: {reason}") from error
    if not isinstance(found, dict) or "time" not in found or "columns" not in found:
        raise WorkbenchError(f"{path}: is not a mapping: write `time:` and `columns:`")
    for key in found:
        if key not in _KEYS:
            raise WorkbenchError(f"{path}: {unknown_name('key', str(key), _KEYS)}")
    delimiter = found.get("delimiter", ",")
    if not isinstance(delimiter, str) or len(delimiter) != 1:
        raise WorkbenchError(f"{path}: a delimiter is one character, as ';'")
    clock, columns = found["time"], found["columns"]
    if not isinstance(clock, dict) or not isinstance(columns, dict) or not columns:
        raise WorkbenchError(f"{path}: `time` and `columns` are tables, as the docs show")
    said = {str(key): value for key, value in clock.items()}
    name = str(said.pop("column", ""))
    time = _column(path, "time", {"signal": "time.s", "unit": "s", **said})
    wanted = {str(each): _column(path, str(each), what) for each, what in columns.items()}
    taken: dict[str, str] = {}
    for each, column in wanted.items():
        for other, signal in taken.items():
            if f"{column.signal}.".startswith(f"{signal}.") or signal.startswith(
                f"{column.signal}."
            ):
                raise WorkbenchError(
                    f"{path}: {other} and {each} become {signal} and {column.signal}: "
                    "give each a different name"
                )
        taken[each] = column.signal
    return (
        delimiter,
        str(found.get("firmware", "")),
        _Column(name, time.unit, time.factor, time.offset, None),
        wanted,
    )


def _column(path: Path, name: str, what: object) -> _Column:
    if not isinstance(what, dict) or not isinstance(what.get("signal"), str):
        raise WorkbenchError(f"{path}: column {name}: write {{signal: TOPIC.FIELD, unit: ...}}")
    for key in what:
        if key not in _COLUMN_KEYS:
            raise WorkbenchError(
                f"{path}: column {name}: {unknown_name('key', str(key), _COLUMN_KEYS)}"
            )
    signal = what["signal"]
    if not SIGNAL_NAME.fullmatch(signal):
        raise WorkbenchError(
            f"{path}: column {name}: '{signal}' is not a signal: write TOPIC.FIELD in small letters"
        )
    numbers = {}
    for key, otherwise in (("scale", 1.0), ("offset", 0.0), ("sign", 1.0), ("delay", math.nan)):
        value = what.get(key, otherwise)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise WorkbenchError(f"{path}: column {name}: {key} is a number")
        numbers[key] = float(value)
    unit = str(what.get("unit", ""))
    si, factor = UNITS.get(unit, (unit, 1.0))
    factor *= numbers["sign"]
    return _Column(
        signal,
        si,
        factor * numbers["scale"],
        factor * numbers["offset"],
        None if math.isnan(numbers["delay"]) else numbers["delay"],
    )


def _table(
    path: Path, data: bytes, delimiter: str, wanted: list[str]
) -> tuple[dict[str, np.ndarray], str]:
    """Return the wanted columns by name, and a remark on cells without a number."""
    reader = csv.reader(io.StringIO(data.decode("utf-8-sig", "replace")), delimiter=delimiter)
    try:
        heads = [head.strip() for head in next(reader, [])]
        for name in wanted:
            if name not in heads:
                raise unknown_name(f"column of {path},", name, heads)
        places = [heads.index(name) for name in wanted]
        rows, strange = [], 0
        for cells in reader:
            row = [_number(cells[place]) if place < len(cells) else None for place in places]
            strange += sum(value is None for value in row)
            rows.append([math.nan if value is None else value for value in row])
    except (csv.Error, ValueError) as error:
        raise WorkbenchError(f"{path}: cannot be read as CSV: {error}") from error
    if not rows:
        raise WorkbenchError(f"{path}: has no row of numbers")
    remark = f"{strange} cells are not numbers and were left out" if strange else ""
    return dict(zip(wanted, np.array(rows, dtype=float).T, strict=True)), remark


def _number(text: str) -> float | None:
    """Return the number in a cell, NaN for an empty one, None for any other text."""
    text = text.strip()
    try:
        return float(text) if text else math.nan
    except ValueError:
        return None
