"""The head of a table of an unknown kind, and the mapping file that describes its columns."""

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.logs.logged_signal import signal_name_part
from workbench.logs.readers.log_reader import companion_file, reader_of
from workbench.logs.readers.packed import TABLE_ENCODING, WINDOWS_BYTES, read_head

TABLE_HEAD_BYTES = 65_536
MAX_HEAD_ROWS = 3
MAX_TABLE_COLUMNS = 500
"""Largest number of columns that a dialog shows."""
DELIMITERS = (",", ";", "\t")
_TIME_NAME = re.compile(r"(t|time|timestamp|stamp)(_?(s|ms|us|ns))?", re.IGNORECASE)
_NAMED_UNIT = re.compile(r"[\[(]\s*([^\])]*)\s*[\])]\s*$")
OWN_COLUMN_TOPIC = "csv"
"""Topic of columns that have no standard name."""


@dataclass(frozen=True)
class TableHead:
    """The first rows of a table.

    Attributes:
        path: of the table.
        mapping: where its mapping file should be.
        delimiter: between columns.
        columns: their names.
        rows: first values of all columns, for each of some rows.
    """

    path: Path
    mapping: Path
    delimiter: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def time_column(self) -> int:
        """Index of the column that is likely to have the time; the first one without any."""
        named = (i for i, name in enumerate(self.columns) if _TIME_NAME.fullmatch(_bare(name)))
        return next(named, 0)

    @property
    def time_unit(self) -> str:
        """The unit of the time that the name of its column states, "" for none."""
        found = _TIME_NAME.fullmatch(_bare(self.columns[self.time_column]))
        suffix = found[3] if found else ""
        return (self.unit_of(self.time_column) or suffix or "").lower()

    def unit_of(self, index: int) -> str:
        """Return the unit that the name of a column states in brackets, "" for none."""
        found = _NAMED_UNIT.search(self.columns[index])
        return found[1].strip() if found else ""


@dataclass(frozen=True)
class ColumnChoice:
    """What a column becomes.

    Attributes:
        signal: name of the signal, TOPIC.FIELD.
        unit: of the column; "" if it is not known.
    """

    signal: str
    unit: str = ""


def undescribed_table(path: Path) -> TableHead | None:
    """Return the head of a table that no file describes; None for any other file.

    Raises:
        WorkbenchError: if it cannot be read, or has no columns with names.
    """
    head = read_head(path, TABLE_HEAD_BYTES)
    reader = reader_of(path, head) if head else None
    if reader is None or not reader.takes_mapping or not reader.companions:
        return None
    places = [companion_file(path, ending) for ending in reader.companions]
    if any(place.is_file() for place in places):
        return None
    lines = head.decode(TABLE_ENCODING, WINDOWS_BYTES).splitlines()
    if len(head) >= TABLE_HEAD_BYTES:
        lines = lines[:-1]  # the last one may be cut
    lines = [line for line in lines if line.strip()]
    if len(lines) < 2:
        raise WorkbenchError(f"{path}: has no row of numbers below the names of columns")
    delimiter = max(DELIMITERS, key=lines[0].count)
    rows = list(csv.reader(lines[: 1 + MAX_HEAD_ROWS], delimiter=delimiter))
    columns = tuple(name.strip() for name in rows[0])
    if len(columns) > MAX_TABLE_COLUMNS or not any(columns):
        raise WorkbenchError(
            f"{path}: has {len(columns)} columns: describe those that you need in a file, "
            f"{places[0].name}"
        )
    cells = tuple(tuple([*row, *[""] * len(columns)][: len(columns)]) for row in rows[1:])
    return TableHead(path, places[0], delimiter, columns, cells)


def own_signal(column: str) -> str:
    """Return the name of a signal for a column that has no standard name."""
    return f"{OWN_COLUMN_TOPIC}.{signal_name_part(_bare(column))}"


def write_mapping(
    head: TableHead, time: str, time_unit: str, choices: Mapping[str, ColumnChoice]
) -> None:
    """Write the mapping file of a table.

    Args:
        head: of the table.
        time: name of the column of the time.
        time_unit: s, ms, us or ns.
        choices: of the other columns, by name.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    import yaml

    columns: dict[str, Any] = {
        name: {"signal": each.signal, **({"unit": each.unit} if each.unit else {})}
        for name, each in choices.items()
    }
    content = {
        **({"delimiter": head.delimiter} if head.delimiter != "," else {}),
        "time": {"column": time, "unit": time_unit},
        "columns": columns,
    }
    write_atomically(head.mapping, yaml.safe_dump(content, sort_keys=False, allow_unicode=True))


def _bare(name: str) -> str:
    """Return the name of a column without its unit."""
    return _NAMED_UNIT.sub("", name).strip()
