r"""Read a CSV file with a mapping file that names its columns.

    delimiter: ";"                  # if left out, that of "," ";" "\t" with which all columns exist
    firmware: my own, version 3     # what you like, or nothing
    time: {column: t, unit: us}
    columns:
      gx: {signal: imu.angular_velocity.x, unit: deg/s}
      gy: {signal: imu.angular_velocity.y, unit: deg/s, sign: -1}
      m1: {signal: motors.command_1, unit: "1", scale: 0.001, offset: -1.0}
      vbat: {signal: battery.voltage, unit: mV, delay: 0.1}

A value is `sign * (scale * x + offset)` in the unit, see `units`, and is converted to SI. A signal
that all readers share has one unit, and others of its dimension are converted to it; a signal of
your own may have any unit. Empty cells, and cells without a number, count as not measured. Where a
comma does not separate columns and no number has a point, it may be that of decimals.
"""

import csv
import math
import re
from array import array
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.flight import Flight, LogRemark
from workbench.common.series import Series, make_series
from workbench.common.yaml_files import read_yaml
from workbench.extras.flightdata.readers.clock import read_clock, stamps_of
from workbench.extras.flightdata.readers.units import find_unit
from workbench.logs.logged_signal import SIGNAL_NAME, standard_unit
from workbench.logs.readers.log_reader import LogFile, LogReader, companion_file
from workbench.logs.readers.packed import PackedFile, log_stem
from workbench.logs.readers.rotations import without_jumps
from workbench.logs.readers.table_head import DELIMITERS

MAPPED_CSV_FORMAT = "CSV with a mapping"
MAPPING_SUFFIX = ".mapping.yaml"
"""Ending of a mapping file that is found next to a table."""
TABLE_ENDINGS = (".csv", ".csv.gz", ".txt", ".tsv")
"""Endings of the names of tables, which need a mapping."""
TIME_SIGNAL = "time.s"
"""Name of the time among the signals of a mapping."""
MAX_CSV_COLUMNS = 50_000
"""Largest number of columns of a file."""
_DECIMAL_COMMA_PATTERN = re.compile(r"\s*[-+]?\d*,\d+([eE][-+]?\d+)?\s*")
_DELIMITER_LINE_PATTERN = re.compile(r"sep=(.)\s*")
"""First line of a table that Excel reads with a delimiter."""
_MAPPING_KEYS = ("delimiter", "firmware", "time", "columns")
_COLUMN_KEYS = ("signal", "unit", "scale", "offset", "sign", "delay")


@dataclass(frozen=True)
class _MappedColumn:
    """The conversion of a column: factor * x + offset.

    Attributes:
        signal: its name.
        unit: of the signal.
        factor: of the conversion.
        offset: of the conversion.
        delay: of the signal [s]; None if unknown.
        remark: on its unit, "" if it is stated and known.
    """

    signal: str
    unit: str
    factor: float
    offset: float
    delay: float | None
    remark: str


def read_csv(path: Path, mapping: Path) -> Flight:
    """Read a CSV file, which may be compressed, with a mapping.

    Raises:
        WorkbenchError: if one of them cannot be read, or the mapping does not fit the file.
    """
    delimiter, firmware, clock_column, wanted = _read_mapping(mapping)
    file = PackedFile(path)
    table, numbers, damage = _csv_table(file, delimiter, [clock_column.signal, *wanted])
    stamps = table[clock_column.signal]
    stamps[~np.isfinite(stamps)] = np.nan
    if np.isnan(stamps).all():
        raise WorkbenchError(
            f"{path}: its column {clock_column.signal} has no number: name its time"
        )
    streams = _columns_by_rows(table, wanted)
    clock = read_clock(
        {
            names[0]: stamps_of(stamps[rows], [table[name][rows] for name in names], rows)
            for names, rows in streams
        },
        clock_column.factor,
        noun="line",
        numbers=numbers,
    )
    signals: dict[str, Series] = {}
    for names, rows in streams:
        for name in names:
            column = wanted[name]
            signals[column.signal] = make_series(
                column.signal,
                column.unit,
                clock.times[names[0]],
                column.factor * table[name][rows] + column.offset,
                end=clock.end,
                delay=column.delay,
                breaks=clock.breaks,
            )
    empty = [
        column.signal for name, column in wanted.items() if not len(signals[column.signal].time)
    ]
    units = [column.remark for column in (clock_column, *wanted.values()) if column.remark]
    lacking = f"without a single number: {', '.join(empty)}" if empty else ""
    remarks = [file.remark, damage, *units, lacking]
    return Flight(
        name=log_stem(path),
        source=path,
        format=MAPPED_CSV_FORMAT,
        firmware=firmware,
        parameters={"mapping": mapping.name},
        remarks=(*filter(None, remarks), *clock.remarks),
        signals=without_jumps(
            {
                column.signal: signals[column.signal]
                for column in wanted.values()
                if column.signal not in empty
            }
        ),
        end=clock.end,
        clock_start=clock.begin * clock_column.factor,
    )


def _columns_by_rows(
    table: Mapping[str, np.ndarray], names: Iterable[str]
) -> list[tuple[list[str], np.ndarray]]:
    """Return columns that have numbers in the same rows, with these rows.

    A table may have several streams, each with empty cells in the rows of the others.
    """
    streams: dict[bytes, tuple[list[str], np.ndarray]] = {}
    for name in names:
        known = np.isfinite(table[name])
        rows = np.flatnonzero(known)
        streams.setdefault(known.tobytes(), ([], rows))[0].append(name)
    return list(streams.values())


def _read_mapping(path: Path) -> tuple[str, str, _MappedColumn, dict[str, _MappedColumn]]:
    """Return delimiter, firmware, the time column, and the other columns by name."""
    found = read_yaml(path).data
    if "time" not in found or "columns" not in found:
        raise WorkbenchError(f"{path}: is not a mapping: write `time:` and `columns:`")
    for key in found:
        if key not in _MAPPING_KEYS:
            raise WorkbenchError(f"{path}: {unknown_name('key', str(key), _MAPPING_KEYS)}")
    delimiter = found.get("delimiter", "")
    if not isinstance(delimiter, str) or len(delimiter) > 1:
        raise WorkbenchError(f"{path}: a delimiter is one character, as ';'")
    clock, columns = found["time"], found["columns"]
    if not isinstance(clock, dict) or not isinstance(columns, dict) or not columns:
        raise WorkbenchError(f"{path}: `time` and `columns` are tables, as the docs show")
    said = {str(key): value for key, value in clock.items()}
    name = str(said.pop("column", ""))
    time = _mapped_column(path, "time", {"signal": TIME_SIGNAL, **said})
    if not time.factor > 0.0:
        raise WorkbenchError(f"{path}: time: its scale and sign let it run backwards")
    wanted = {str(each): _mapped_column(path, str(each), what) for each, what in columns.items()}
    _check_different(path, {each: column.signal for each, column in wanted.items()})
    return (
        delimiter,
        str(found.get("firmware", "")),
        replace(time, signal=name),
        wanted,
    )


def _check_different(path: Path, signals: Mapping[str, str]) -> None:
    """Check that no signal is another one, or begins with its name.

    Args:
        path: the mapping, for the message.
        signals: by column.

    Raises:
        WorkbenchError: if two columns become such signals.
    """
    ordered = sorted(signals.items(), key=lambda row: row[1].split("."))  # a name before its parts
    for (one, signal), (other, longer) in pairwise(ordered):
        if f"{longer}.".startswith(f"{signal}."):
            raise WorkbenchError(
                f"{path}: {one} and {other} become {signal} and {longer}: give each a different "
                "name"
            )


def _mapped_column(path: Path, name: str, what: object) -> _MappedColumn:
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
    unit, factor, zero, remark = _unit_conversion(path, name, signal, what.get("unit"))
    factor *= numbers["sign"]
    return _MappedColumn(
        signal,
        unit,
        factor * numbers["scale"],
        factor * numbers["offset"] + zero,
        None if math.isnan(numbers["delay"]) else numbers["delay"],
        remark,
    )


def _unit_conversion(
    path: Path, name: str, signal: str, text: object
) -> tuple[str, float, float, str]:
    """Return the unit of a signal, factor and zero of the conversion to it, and a remark.

    Raises:
        WorkbenchError: if the unit is not one of a signal that all readers share.
    """
    standard = "s" if signal == TIME_SIGNAL else standard_unit(signal)
    if text is None:
        remark = f"{signal} has no unit in {path.name}: it is read as {standard}"
        return standard, 1.0, 0.0, LogRemark(remark, None, f"column {name}") if standard else ""
    try:
        unit = find_unit(str(text))
    except WorkbenchError as error:
        if standard:
            raise WorkbenchError(f"{path}: column {name}: {error}") from error
        remark = f"{signal} keeps its unit: {error}"
        return str(text), 1.0, 0.0, LogRemark(remark, None, f"column {name}")
    if standard and unit.powers != find_unit(standard).powers:
        raise WorkbenchError(
            f"{path}: column {name}: {signal} is in {standard}, and {text} is no unit of that: "
            "correct the unit, or give the signal another name"
        )
    return standard or unit.si, unit.factor, unit.zero, ""


def _csv_table(
    file: PackedFile, delimiter: str, wanted: list[str]
) -> tuple[dict[str, np.ndarray], np.ndarray, str]:
    """Return the wanted columns by name, the lines of their rows, and a remark on other cells."""
    path = file.path
    rows, lines, strange = array("d"), array("q"), array("q")
    commas = points = longer = 0
    try:
        reader, heads, places = _table_reader(file, delimiter, wanted)
        for cells in reader:
            longer += any(cells[len(heads) :])
            texts = [cells[place] if place < len(cells) else None for place in places]
            row = [None if text is None else _cell_number(text) for text in texts]
            for place, text in enumerate(texts):
                if row[place] is not None:
                    points += "." in str(text)
                elif text is not None and _DECIMAL_COMMA_PATTERN.fullmatch(text):
                    commas += 1
                    row[place] = float(text.replace(",", "."))
                else:
                    strange.append(reader.line_num)
            rows.extend(math.nan if value is None else value for value in row)
            lines.append(reader.line_num)
    except (csv.Error, ValueError) as error:
        raise WorkbenchError(f"{path}: cannot be read as CSV: {error}") from error
    if not rows:
        raise WorkbenchError(f"{path}: has no row of numbers")
    if longer > 0.5 * len(lines):
        raise WorkbenchError(
            f"{path}: its rows have more cells than the {len(heads)} columns that it names: if its "
            "numbers have decimal commas, save it with semicolons between columns"
        )
    if commas and (points or reader.dialect.delimiter == ","):
        raise WorkbenchError(
            f"{path}: has {commas} numbers with a comma and {points} with a point: save it with "
            "decimal points, and without commas in numbers"
        )
    remark = ""
    if strange:
        place = f"line {strange[0]}"
        text = f"{len(strange)} cells are not numbers and were left out, the first one in {place}"
        remark = LogRemark(text, len(strange), place)
    table = np.array(rows).reshape(-1, len(wanted))
    return dict(zip(wanted, table.T, strict=True)), np.array(lines), remark


def _table_reader(
    file: PackedFile, delimiter: str, wanted: list[str]
) -> tuple[Any, list[str], list[int]]:
    """Return a reader of the rows, the names of all columns, and the places of the wanted ones.

    Args:
        file: the table.
        delimiter: between columns, "" for the first one with which all wanted columns exist.
        wanted: names of columns.

    Raises:
        WorkbenchError: if a column does not exist, or there are too many.
    """
    text = file.lines()
    begin = [next(text, "")]
    if stated := _DELIMITER_LINE_PATTERN.fullmatch(begin[0]):
        delimiter, begin = delimiter or stated[1], ["", next(text, "")]
    known = {
        each: [head.strip() for head in next(csv.reader(begin[-1:], delimiter=each), [])]
        for each in ([delimiter] if delimiter else DELIMITERS)
    }
    chosen = next((each for each, heads in known.items() if {*wanted} <= {*heads}), "")
    delimiter = chosen or max(known, key=lambda each: len(known[each]))
    heads = known[delimiter]
    if len(heads) > MAX_CSV_COLUMNS:
        raise WorkbenchError(f"{file.path}: has more than {MAX_CSV_COLUMNS} columns")
    named = dict(zip(reversed(heads), range(len(heads) - 1, -1, -1), strict=True))
    for name in wanted:
        if name not in named:
            raise unknown_name(f"column of {file.path},", name, heads)
    reader = csv.reader(chain(begin, text), delimiter=delimiter)
    for _ in begin:
        next(reader, None)
    return reader, heads, [named[name] for name in wanted]


def _cell_number(text: str) -> float | None:
    """Return the number in a cell, NaN for an empty one, None for any other text."""
    text = text.strip()
    try:
        return float(text) if text else math.nan
    except ValueError:
        return None


def is_described(path: Path) -> bool:
    """Return whether a mapping file is next to a table."""
    return companion_file(path, MAPPING_SUFFIX).is_file()


def _read_table(file: LogFile) -> Flight:
    """Read a table with the mapping that the user names, or the one next to it.

    Raises:
        WorkbenchError: if there is none, or the table cannot be read.
    """
    mapping = file.mapping or companion_file(file.path, MAPPING_SUFFIX)
    if file.mapping is None and not mapping.is_file():
        raise WorkbenchError(
            f"{file.path}: is a CSV file of an unknown kind: describe its columns in a file, "
            "--mapping FILE"
        )
    return read_csv(file.path, mapping)


LOG_READER = LogReader(
    MAPPED_CSV_FORMAT,
    "any CSV with a mapping file",
    lambda path, _: is_described(path) or path.name.lower().endswith(TABLE_ENDINGS),
    _read_table,
    place=70,
    endings=(".csv",),
    takes_mapping=True,
    companions=(MAPPING_SUFFIX,),
)
