"""The table of a sweep as a file: CSV, or Parquet."""

import csv
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.sweep.table import SweepTable

SUFFIXES = (".csv", ".parquet")


def check_table_path(path: Path) -> None:
    """Refuse a table that could not be written, before anything is flown.

    Raises:
        WorkbenchError: if the suffix is unknown, or Parquet cannot be written here.
    """
    if path.suffix not in SUFFIXES:
        raise WorkbenchError(f"{path}: a table's name ends in {' or '.join(SUFFIXES)}")
    if path.suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError:
            raise WorkbenchError(
                f"{path}: Parquet needs pyarrow: `pip install pyarrow`, or name a .csv"
            ) from None


def write_table(table: SweepTable, path: Path) -> None:
    """Write a sweep's table, a row a candidate; what is not known is left empty.

    CSV has names with units in its first line, "kp_roll [1/s^2]"; Parquet has names, and the unit
    in each field's metadata.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    check_table_path(path)
    try:
        if path.suffix == ".parquet":
            _write_parquet(table, path)
        else:
            _write_csv(table, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(f"{path}: cannot be written: {reason}") from error


def _write_csv(table: SweepTable, path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(f"{n} [{u}]" for n, u in zip(table.names, table.units, strict=True))
        for row in table.rows:
            writer.writerow("" if np.isnan(value) else repr(float(value)) for value in row)


def _write_parquet(table: SweepTable, path: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    fields = [
        pyarrow.field(name, pyarrow.float64(), metadata={"unit": unit})
        for name, unit in zip(table.names, table.units, strict=True)
    ]
    columns = [
        pyarrow.array(column, mask=np.isnan(column))
        for column in np.ascontiguousarray(table.rows.T)
    ]
    pyarrow.parquet.write_table(
        pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields)), path
    )
