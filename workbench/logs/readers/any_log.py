"""Read a log of any known format; its first bytes determine which."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.logs.flight_record import FlightRecord
from workbench.logs.log_process import BESIDE, beside
from workbench.logs.readers import (
    blackbox,
    crazyflie_usd,
    dataflash,
    nanobench,
    states_csv,
    ulog,
)
from workbench.logs.readers.mapped_csv import read_csv
from workbench.logs.readers.mcap_log import read_mcap
from workbench.logs.readers.packed import GZIP, PackedFile, read_head, stem
from workbench.logs.record import LogRecord

KNOWN = (
    "a log of the workbench (.mcap), PX4's .ulg, ArduPilot's .bin, Betaflight's .bbl or .bfl, a "
    "Crazyflie's usd log, a CSV of NanoBench, or any CSV with a mapping file"
)
READERS: Mapping[str, tuple[str, bytes, Callable[..., FlightRecord]]] = {
    ulog.FORMAT: (ulog.NEEDS, ulog.MAGIC, ulog.read_ulog),
    dataflash.FORMAT: (dataflash.NEEDS, dataflash.MAGIC, dataflash.read_dataflash),
    blackbox.FORMAT: (blackbox.NEEDS, blackbox.MAGIC, blackbox.read_blackbox),
}
"""By the format: the package that it needs, the first bytes of a file, and the reader."""
LARGEST_COPY = 120_000_000
"""Size limit of the content of a compressed file that a library reads [bytes]."""


def read_any(
    path: Path,
    mapping: Path | None,
    folder: Path,
    progress: Callable[[float], None] | None = None,
    log_number: int | None = None,
) -> LogRecord | FlightRecord:
    """Return a log, as a `LogRecord` if it is in MCAP.

    Args:
        path: the log, see `KNOWN`; it may be compressed with gzip.
        mapping: a file that names the columns of a CSV; None for X.mapping.yaml next to X.csv, if
            it exists.
        folder: for temporary files.
        progress: called with the share done, 0 .. 1, if known.
        log_number: of the log in a file with several, from 1; None for the longest one.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    head = read_head(path, max(len(nanobench.HEAD), len(states_csv.HEAD)))
    several = bool(head) and head.startswith(blackbox.MAGIC[: len(head)]) and mapping is None
    if log_number not in (None, 1) and not several:
        raise WorkbenchError(f"{path}: has one log: --log-number {log_number} is not one of them")
    if mapping is not None:
        return read_csv(path, mapping)
    if head.startswith(MCAP0_MAGIC) or path.suffix == ".mcap":
        return read_own(path, folder, progress)
    if head.startswith(nanobench.HEAD):
        return nanobench.read_nanobench(path)
    if head.startswith(crazyflie_usd.MAGIC):
        return crazyflie_usd.read_usd(path)
    for format_, (_, magic, _) in READERS.items():
        if head.startswith(magic[: len(head)]) and head:
            return _read_by_library(path, format_, folder, log_number if several else None)
    if not head:
        raise WorkbenchError(f"{path}: is empty: name {KNOWN}")
    described = beside(path, BESIDE)
    if described.is_file():
        return read_csv(path, described)
    if head.startswith(states_csv.HEAD):
        return states_csv.read_states(path)
    if path.name.lower().endswith((".csv", ".csv.gz", ".txt", ".tsv")):
        raise WorkbenchError(
            f"{path}: is a CSV file of an unknown kind: describe its columns in a file, --mapping "
            "FILE"
        )
    raise WorkbenchError(f"{path}: is not a known kind of log: name {KNOWN}")


def read_own(
    path: Path, folder: Path, progress: Callable[[float], None] | None = None
) -> LogRecord:
    """Return a log of the workbench; arguments and errors are those of `read_any`."""
    with _plain(path, folder) as (plain, remark):
        found = read_mcap(plain, progress)
    return replace(found, path=path, remark="; ".join(filter(None, (remark, found.remark))))


def _read_by_library(
    path: Path, format_: str, folder: Path, log_number: int | None
) -> FlightRecord:
    """Read a log of one of the `READERS`.

    Raises:
        WorkbenchError: if its package is not there, or the log cannot be read.
    """
    needs, _, read = READERS[format_]
    if find_spec(needs) is None:
        raise WorkbenchError(
            f"{path}: a {format_} needs the package {needs}: `pip install {needs}`"
        )
    with _plain(path, folder) as (plain, remark):
        found = read(plain) if log_number is None else read(plain, log_number)
    remarks = tuple(filter(None, (remark, *found.remarks)))
    return replace(found, name=stem(path), source=path, remarks=remarks)


@contextmanager
def _plain(path: Path, folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield the file itself, or its unpacked copy if it is compressed, and a remark.

    Raises:
        WorkbenchError: if it cannot be unpacked, or is too large.
    """
    if not read_plain(path, first=len(GZIP)).startswith(GZIP):
        yield path, ""
        return
    packed, copy, size = PackedFile(path), folder / "unpacked", 0
    with copy.open("wb") as stream:
        for block in packed.blocks():
            size += stream.write(block)
            if size > LARGEST_COPY:
                raise WorkbenchError(
                    f"{path}: unpacks to more than {LARGEST_COPY // 1_000_000} MB: unpack it "
                    "first (gunzip)"
                )
    try:
        yield copy, packed.remark
    except WorkbenchError as error:
        raise WorkbenchError(str(error).replace(str(copy), str(path))) from error
