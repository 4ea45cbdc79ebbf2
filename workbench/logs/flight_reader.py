"""Reads a flight's log, whoever wrote it."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord
from workbench.logs.readers import crazyflie_usd, nanobench
from workbench.logs.readers.packed import read_packed


def read_flight(path: Path) -> FlightRecord:
    """Read a log; what it is, its first bytes say.

    Args:
        path: the log; a NanoBench CSV or a Crazyflie's usd log, packed with gzip or not.

    Raises:
        WorkbenchError: if it cannot be read, or is no log that is known.
    """
    head, _ = read_packed(path)
    if not head:
        raise WorkbenchError(f"{path}: is empty")
    if head.startswith(nanobench.HEAD):
        return nanobench.read_nanobench(path)
    if head.startswith(crazyflie_usd.MAGIC):
        return crazyflie_usd.read_usd(path)
    raise WorkbenchError(f"{path}: is no log that is known")
