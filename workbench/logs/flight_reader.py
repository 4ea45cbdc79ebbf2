"""Read the log of a flight in any known format, in a process with limits of time and memory."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from workbench.logs.array_files import ArrayReader
from workbench.logs.flight_record import FlightRecord
from workbench.logs.imported import flight_record, log_of
from workbench.logs.log_process import read_held
from workbench.logs.record import LogRecord


def read_flight(
    path: Path | str,
    mapping: Path | str | None = None,
    progress: Callable[[float], None] | None = None,
    log_number: int | None = None,
) -> FlightRecord:
    """Read a log; its first bytes determine the format.

    Args:
        path: the log, see `any_log.KNOWN`; it may be compressed with gzip.
        mapping: a file that names the columns of a CSV; None for X.mapping.yaml next to X.csv, if
            it exists.
        progress: called with the share done, 0 .. 1, if known, from another thread.
        log_number: of the log in a file with several, from 1; None for the longest one.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    found = _read(path, mapping, progress, log_number)
    return found if isinstance(found, FlightRecord) else flight_record(found)


def open_log(
    path: Path | str,
    mapping: Path | str | None = None,
    progress: Callable[[float], None] | None = None,
    log_number: int | None = None,
) -> LogRecord:
    """Return any log in the form of our own logs, to draw, list and export it.

    Raises:
        WorkbenchError: as `read_flight`.
    """
    found = _read(path, mapping, progress, log_number)
    return found if isinstance(found, LogRecord) else log_of(found)


def _read(
    path: Path | str,
    mapping: Path | str | None,
    progress: Callable[[float], None] | None,
    log_number: int | None,
) -> LogRecord | FlightRecord:
    file = Path(path)

    def made(said: Any, arrays: ArrayReader) -> LogRecord | FlightRecord:
        if "log" in said:
            return LogRecord.from_description(said["log"], file, arrays)
        names = [each["name"] for each in said["flight"]["signals"]]
        samples = {
            name: (arrays.get(time), arrays.get(values))
            for name, (time, values) in zip(names, said["samples"], strict=True)
        }
        return FlightRecord.from_description(said["flight"], file, samples)

    described = None if mapping is None else Path(mapping)
    return read_held(file, made, progress, mapping=described, log_number=log_number)
