"""Files with several logs: the one with a number, or the longest."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FlightRecord, Remark

ReadLog = Callable[[int], FlightRecord]
"""Reads the log with a number, from 1."""


def longest(path: Path, count: int, number: int | None, read: ReadLog) -> FlightRecord:
    """Return one of the logs in a file; a remark and `logs` of the record list them with lengths.

    Args:
        path: the file.
        count: of logs in it.
        number: of the log, from 1; None for the longest one.
        read: reads one of them.

    Raises:
        WorkbenchError: if none can be read, or there is no log of that number.
    """
    if number is not None:
        if not 1 <= number <= count:
            has = f"{count} logs" if count != 1 else "one log"
            raise WorkbenchError(f"{path}: has {has}: --log-number {number} is not one of them")
        flight = read(number)
        if count == 1:
            return flight
        remark = Remark(f"this is log {number} of the {count} in the file", count, f"log {number}")
        return replace(flight, remarks=(remark, *flight.remarks))
    best: FlightRecord | None = None
    chosen, failure = 0, None
    lengths: list[float] = []
    for each in range(1, count + 1):
        try:
            flight = read(each)
        except WorkbenchError as error:
            failure = failure or error
            lengths.append(0.0)
            continue
        lengths.append(flight.end)
        if best is None or flight.end > best.end:
            best, chosen = flight, each
    if best is None:
        raise failure or WorkbenchError(f"{path}: has no log: it is empty or damaged")
    if count == 1:
        return best
    listed = ", ".join(
        f"{each} {f'has {length:.2f} s' if length else 'has no frames'}"
        for each, length in enumerate(lengths, start=1)
    )
    remark = Remark(
        f"the file has {count} logs ({listed}): this is number {chosen}, the longest; "
        "--log-number N takes another one",
        count,
        f"log {chosen}",
    )
    return replace(best, remarks=(remark, *best.remarks), logs=tuple(lengths))
