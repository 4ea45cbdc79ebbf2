"""Read the log of a flight in any known format, in a process with limits of time and memory."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from workbench.common.flight import Flight
from workbench.logs.array_files import ArrayReader
from workbench.logs.imported import flight_of_log, imported_topics, signal_topics
from workbench.logs.log_process import read_in_process
from workbench.logs.logged_topic import LoggedTopic
from workbench.logs.readers.log_reader import LogFile
from workbench.logs.record import LogRecord


def read_flight(
    path: Path | str,
    mapping: Path | str | None = None,
    progress: Callable[[float], None] | None = None,
    log_number: int | None = None,
) -> Flight:
    """Read a log; its first bytes determine the format.

    Args:
        path: the log, see `log_reader.known_log_formats`; it may be compressed with gzip.
        mapping: a file that names the columns of a CSV; None for X.mapping.yaml next to X.csv, if
            it exists.
        progress: called with the share done, 0 .. 1, if known, from another thread.
        log_number: of the log in a file with several, from 1; None for the longest one.

    Raises:
        WorkbenchError: if it cannot be read, or its format is unknown.
    """
    file = LogFile(Path(path), None if mapping is None else Path(mapping), log_number)
    found = _read_log_file(file, progress)
    return found if isinstance(found, Flight) else flight_of_log(found)


def open_log(file: LogFile | Path | str, progress: Callable[[float], None] | None = None) -> Flight:
    """Return a flight with every field of its log as it is there, to draw and list it.

    Signals of other programs have a NaN in each gap.

    Raises:
        WorkbenchError: as `read_flight`.
    """
    found = _read_log_file(file, progress)
    if isinstance(found, LogRecord):
        if not found.imported:
            return found.flight
        found = replace(flight_of_log(found), remarks=(found.remark,) if found.remark else ())
    shown = {name: each.with_gaps() for name, each in found.signals.items()}
    return replace(found, signals=shown)


def log_topics(
    file: LogFile | Path | str, progress: Callable[[float], None] | None = None
) -> tuple[list[LoggedTopic], str]:
    """Return the topics of a log, to export it, and what is missing in it, or "".

    Those of another program have a message for each sample.

    Raises:
        WorkbenchError: as `read_flight`.
    """
    found = _read_log_file(file, progress)
    if isinstance(found, LogRecord):
        topics = imported_topics(found) if found.imported else [*found.topics.values()]
        return topics, found.remark
    return [each.topic for each in signal_topics(found)], found.remark


def _read_log_file(
    file: LogFile | Path | str, progress: Callable[[float], None] | None
) -> LogRecord | Flight:
    asked = file if isinstance(file, LogFile) else LogFile(Path(file))

    def made(said: Any, arrays: ArrayReader) -> LogRecord | Flight:
        if "log" in said:
            return LogRecord.from_description(said["log"], asked.path, arrays)
        names = [each["name"] for each in said["flight"]["signals"]]
        samples = {
            name: (arrays.get(time), arrays.get(values))
            for name, (time, values) in zip(names, said["samples"], strict=True)
        }
        return Flight.from_description(said["flight"], asked.path, samples)

    return read_in_process(asked, made, progress)
