"""Read the log of a flight in any known format.

The libraries that read PX4's, ArduPilot's and Betaflight's logs were not written for untrusted
files. They run in a child process, this module, with limits of time and memory. Arrays come back
as files, and the rest as JSON.
"""

import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import LimitedError, run_limited, serve
from workbench.logs.flight_record import FlightRecord
from workbench.logs.imported import flight_record, log_of
from workbench.logs.readers import (
    blackbox,
    crazyflie_usd,
    dataflash,
    nanobench,
    states_csv,
    ulog,
)
from workbench.logs.readers.mapped_csv import read_csv
from workbench.logs.readers.packed import read_head, stem
from workbench.logs.record import LogRecord, read_log

KNOWN = (
    "a log of the workbench (.mcap), PX4's .ulg, ArduPilot's .bin, Betaflight's .bbl or .bfl, a "
    "Crazyflie's usd log, a CSV of NanoBench, or any CSV with a mapping file"
)
BESIDE = ".mapping.yaml"
"""Ending of a mapping file that is found next to a CSV file."""
READERS = {
    ulog.FORMAT: (ulog.NEEDS, ulog.read_ulog),
    dataflash.FORMAT: (dataflash.NEEDS, dataflash.read_dataflash),
    blackbox.FORMAT: (blackbox.NEEDS, blackbox.read_blackbox),
}
"""By the format: the package that it needs, and the reader."""
SECONDS, SECONDS_A_MEGABYTE = 15.0, 4.0
MEGABYTES, MEGABYTES_A_MEGABYTE = 1500, 40
MOST_SECONDS, MOST_MEGABYTES = 900.0, 12_000
"""Limits of the child process, by the file's size: blackbox logs take some 2 s and 20 MB a
megabyte."""


def read_flight(
    path: Path | str,
    mapping: Path | str | None = None,
    progress: Callable[[float], None] | None = None,
    log_number: int | None = None,
) -> FlightRecord:
    """Read a log; its first bytes determine the format.

    Args:
        path: the log, see `KNOWN`; CSV files and usd logs may be compressed with gzip.
        mapping: a file that names the columns of a CSV; None for X.mapping.yaml next to X.csv, if
            it exists.
        progress: called with the share done, 0 .. 1, if known.
        log_number: of the log in a file with several, from 1; None for the longest one.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    path = Path(path)
    head = read_head(path, max(len(nanobench.HEAD), len(states_csv.HEAD)))
    if head.startswith(blackbox.MAGIC[: len(head)]) and head and mapping is None:
        return read_limited(path, blackbox.FORMAT, log_number)
    if log_number not in (None, 1):
        raise WorkbenchError(f"{path}: has one log: --log-number {log_number} is not one of them")
    if mapping is not None:
        return read_csv(path, Path(mapping))
    if head.startswith(MCAP0_MAGIC) or path.suffix == ".mcap":
        return flight_record(read_log(path, progress))
    if head.startswith(nanobench.HEAD):
        return nanobench.read_nanobench(path)
    if head.startswith(crazyflie_usd.MAGIC):
        return crazyflie_usd.read_usd(path)
    for reader in (ulog, dataflash):
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
            f"{path}: is a CSV file of an unknown kind: describe its columns in a file, --mapping "
            "FILE"
        )
    raise WorkbenchError(f"{path}: is not a known kind of log: name {KNOWN}")


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
    path = Path(path)
    if mapping is None and (
        path.suffix == ".mcap" or read_head(path, len(MCAP0_MAGIC)).startswith(MCAP0_MAGIC)
    ):
        return read_log(path, progress)
    return log_of(read_flight(path, mapping, log_number=log_number))


def read_limited(path: Path, format_: str, log_number: int | None = None) -> FlightRecord:
    """Read a log of one of the `READERS` in a child process.

    Raises:
        WorkbenchError: if its package is not there, or the log cannot be read within bounds.
    """
    needs, _ = READERS[format_]
    if find_spec(needs) is None:
        raise WorkbenchError(
            f"{path}: a {format_} needs the package {needs}: `pip install {needs}`"
        )
    size = path.stat().st_size / 1e6
    with tempfile.TemporaryDirectory() as folder:
        request = {
            "path": str(path),
            "format": format_,
            "folder": folder,
            "log_number": log_number,
        }
        try:
            said = run_limited(
                __name__,
                request,
                seconds=min(SECONDS + SECONDS_A_MEGABYTE * size, MOST_SECONDS),
                megabytes=round(min(MEGABYTES + MEGABYTES_A_MEGABYTE * size, MOST_MEGABYTES)),
                reads=[path],
                writes=[folder],
            )
        except LimitedError as error:
            raise WorkbenchError(f"{path}: cannot be read as a {format_}: {error}") from error
        times = [_load(folder, f"t{place}") for place in range(said["times"])]
        samples = {
            each["name"]: (times[place], _load(folder, f"v{number}"))
            for number, (each, place) in enumerate(
                zip(said["signals"], said["places"], strict=True)
            )
        }
    return FlightRecord.from_description(said, path, samples)


def _load(folder: str, name: str) -> np.ndarray:
    array: np.ndarray = np.load(Path(folder) / f"{name}.npy", allow_pickle=False)
    return array


def _read(request: dict[str, Any]) -> dict[str, Any]:
    """Read a log here, and return all but the arrays, which become files."""
    folder = Path(request["folder"])
    _, read = READERS[request["format"]]
    number = request["log_number"]
    flight = read(Path(request["path"]), *([] if number is None else [number]))
    known: dict[bytes, int] = {}
    places = []
    for number, signal in enumerate(flight.signals.values()):
        key = signal.time.tobytes()
        if key not in known:
            known[key] = len(known)
            np.save(folder / f"t{known[key]}.npy", signal.time)
        places.append(known[key])
        np.save(folder / f"v{number}.npy", signal.values)
    return {**flight.described(), "times": len(known), "places": places}


if __name__ == "__main__":
    serve(_read)
