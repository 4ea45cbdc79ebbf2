"""A topic of a log as a file: CSV, or Parquet."""

import csv
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import WorkbenchError
from workbench.flight_log.series import LoggedTopic, Series


def file_name(topic: LoggedTopic, suffix: str) -> str:
    """Return the name of a topic's file."""
    return topic.short.strip("/").replace("/", "_") + suffix


def write_topic(topic: LoggedTopic, path: Path) -> None:
    """Write a topic, a row a message, with the simulated time in front.

    CSV has names with units in its first line, "v_x [m/s]"; Parquet has names, and the unit in each
    field's metadata. What is not known is left empty.

    Args:
        topic: of the log.
        path: the file, .csv or .parquet.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    time = Series(f"{topic.short}.t", "s", topic.time, topic.time)
    columns = {"t": time, **topic.columns}
    write = _write_parquet if path.suffix == ".parquet" else _write_csv
    try:
        write(columns, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error


def _write_csv(columns: dict[str, Series], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            f"{name} [{series.unit}]" if series.unit else name for name, series in columns.items()
        )
        writer.writerows(zip(*(_texts(series.values) for series in columns.values()), strict=True))


def _texts(values: np.ndarray) -> list[str]:
    """Return values as the shortest texts that are read back as the same numbers."""
    if values.dtype.kind == "O":
        return [str(value) for value in values]
    texts: list[str] = values.astype(str).tolist()
    if values.dtype.kind == "f":
        return ["" if text == "nan" else text for text in texts]
    return texts


def _write_parquet(columns: dict[str, Series], path: Path) -> None:
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
