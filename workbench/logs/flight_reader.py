"""Read the log of a flight in any known format."""

from collections.abc import Callable
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord
from workbench.logs.imported import flight_record, log_of
from workbench.logs.mcap_writer import MAGIC as MCAP
from workbench.logs.readers import (
    blackbox,
    crazyflie_usd,
    dataflash,
    nanobench,
    states_csv,
    ulog,
)
from workbench.logs.readers.limited_reader import read_limited
from workbench.logs.readers.mapped_csv import read_csv
from workbench.logs.readers.packed import read_head, stem
from workbench.logs.record import LogRecord, read_log

KNOWN = (
    "a log of the workbench (.mcap), PX4's .ulg, ArduPilot's .bin, Betaflight's .bbl or .bfl, a "
    "Crazyflie's usd log, a CSV of NanoBench, or any CSV with a mapping file"
)
BESIDE = ".mapping.yaml"
"""Ending of a mapping file that is found next to a CSV file."""


def read_flight(
    path: Path,
    mapping: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> FlightRecord:
    """Read a log; its first bytes determine the format.

    Args:
        path: the log, see `KNOWN`; CSV files and usd logs may be compressed with gzip.
        mapping: a file that names the columns of a CSV; None for X.mapping.yaml next to X.csv, if
            it exists.
        progress: called with the share done, 0 .. 1, if known.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    if mapping is not None:
        return read_csv(path, mapping)
    head = read_head(path, max(len(nanobench.HEAD), len(states_csv.HEAD)))
    if head.startswith(MCAP) or path.suffix == ".mcap":
        return flight_record(read_log(path, progress))
    if head.startswith(nanobench.HEAD):
        return nanobench.read_nanobench(path)
    if head.startswith(crazyflie_usd.MAGIC):
        return crazyflie_usd.read_usd(path)
    for reader in (ulog, dataflash, blackbox):
        if head.startswith(reader.MAGIC[: len(head)]) and head:
            return read_limited(path, reader.FORMAT)
    if not head:
        raise WorkbenchError(f"{path}: is empty: name {KNOWN}")
    beside = path.with_name(stem(path) + BESIDE)
    if beside.is_file():
        return read_csv(path, beside)
    if head.startswith(states_csv.HEAD):
        return states_csv.read_states(path)
    if path.name.lower().endswith((".csv", ".csv.gz", ".txt", ".tsv")):
        raise WorkbenchError(
            f"{path}: is a CSV file of somebody's own: name its columns in a file, --mapping FILE"
        )
    raise WorkbenchError(f"{path}: is no log that is known: name {KNOWN}")


def open_log(
    path: Path,
    mapping: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> LogRecord:
    """Return any log in the form of our own logs, to draw, list and export it.

    Raises:
        WorkbenchError: as `read_flight`.
    """
    if mapping is None and (path.suffix == ".mcap" or read_head(path, len(MCAP)).startswith(MCAP)):
        return read_log(path, progress)
    return log_of(read_flight(path, mapping))
