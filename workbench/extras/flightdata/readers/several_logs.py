"""Which of several logs in a file is read."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, LogRemark


def one_of_logs(
    path: Path, count: int, number: int | None, read: Callable[[int], Flight], noun: str
) -> Flight:
    """Return one of the logs in a file, with a remark that lists them with their lengths.

    Args:
        path: the file.
        count: of logs in it.
        number: of the log, from 1; None for the longest one.
        read: reads the log with a number.
        noun: of what a log consists of, in the plural.

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
        remark = LogRemark(
            f"this is log {number} of the {count} in the file", count, f"log {number}"
        )
        return replace(flight, remarks=(remark, *flight.remarks))
    best: Flight | None = None
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
        f"{each} {f'has {length:.2f} s' if length else f'has no {noun}'}"
        for each, length in enumerate(lengths, start=1)
    )
    remark = LogRemark(
        f"the file has {count} logs ({listed}): this is number {chosen}, the longest; "
        "--log-number N takes another one",
        count,
        f"log {chosen}",
    )
    return replace(best, remarks=(remark, *best.remarks), logs=tuple(lengths))
