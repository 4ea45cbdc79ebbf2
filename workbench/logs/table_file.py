"""A topic of a log as a file: CSV, or Parquet."""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import file_stem, plain_text
from workbench.common.series import Series
from workbench.logs.logged_topic import LoggedTopic

MAX_CSV_CELL_CHARS = 32_000
"""Largest number of characters of a text in CSV; spreadsheets take 32,767."""
_FORMULA_STARTS = ("=", "+", "-", "@")
"""Beginnings of a cell that spreadsheets compute."""
ROWS_PER_WRITE = 100_000
"""Number of rows written at a time, as texts take a hundred times the memory of numbers."""


def topic_tables(topic: LoggedTopic) -> dict[str, dict[str, Series]]:
    """Return the tables of a topic, by the stem of their file.

    There is a table with a row for each message, and for clouds another one with a row for each
    point.

    Raises:
        WorkbenchError: if a message cannot be decoded.
    """
    name = file_stem(topic.short.strip("/"))
    time = Series(f"{topic.short}.t", "s", topic.time, topic.time)
    found = {name: {"t": time, **topic.columns}}
    if topic.points:
        times = next(iter(topic.points.values())).time
        found[f"{name}_points"] = {"t": Series(time.name, "s", times, times), **topic.points}
    return found


def write_columns(columns: Mapping[str, Series], path: Path) -> None:
    """Write columns as a table.

    CSV has names with units in its first line, such as "v_x [m/s]". Its texts have at most
    `MAX_CSV_CELL_CHARS` characters, escapes for control characters, and an apostrophe before what a
    spreadsheet would take for a formula. Parquet has names and texts as in the log, with the unit
    in the metadata of each field. Unknown values are left empty.

    Args:
        columns: of equal lengths, by name.
        path: the file, .csv or .parquet.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    write = _write_parquet if path.suffix == ".parquet" else _write_csv
    try:
        write(columns, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error


def _write_csv(columns: Mapping[str, Series], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            _safe_cell(f"{name} [{series.unit}]" if series.unit else name)
            for name, series in columns.items()
        )
        all_values = [series.values for series in columns.values()]
        for first in range(0, len(all_values[0]), ROWS_PER_WRITE):
            part = (
                _shortest_texts(values[first : first + ROWS_PER_WRITE]) for values in all_values
            )
            writer.writerows(zip(*part, strict=True))


def _shortest_texts(values: np.ndarray) -> list[str]:
    """Return values as the shortest texts that restore the same numbers."""
    if values.dtype.kind == "O":
        return [_safe_cell(value) if isinstance(value, str) else str(value) for value in values]
    texts: list[str] = values.astype(str).tolist()
    if values.dtype.kind == "f":
        return ["" if text == "nan" else text for text in texts]
    return texts


def _safe_cell(text: str) -> str:
    """Return a text of a log that a spreadsheet does not compute and a terminal does not obey."""
    shown = plain_text(text, MAX_CSV_CELL_CHARS)
    return f"'{shown}" if shown.startswith(_FORMULA_STARTS) else shown


def _write_parquet(columns: Mapping[str, Series], path: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    arrays: list[Any] = []
    fields: list[Any] = []
    for name, series in columns.items():
        values = series.values
        blank = np.isnan(values) if values.dtype.kind == "f" else None
        arrays.append(pyarrow.array(values, mask=blank))
        fields.append(pyarrow.field(name, arrays[-1].type, metadata={"unit": series.unit}))
    table = pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))
    pyarrow.parquet.write_table(table, path)
