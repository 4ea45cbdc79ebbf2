"""Read a log in a process that the system limits, as all of a log is foreign; see `log_child`."""

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import open_plain, size_of
from workbench.ipc.limited import LimitedError, run_limited
from workbench.logs.array_files import ArrayReader
from workbench.logs.readers.packed import GZIP, stem

SECONDS, SECONDS_A_MEGABYTE = 3.0, 4.0
MEGABYTES = 400
MEGABYTES_A_MEGABYTE = 30
MOST_SECONDS = 900.0
MOST_MEGABYTES = 12_000
"""Limits of processor time and memory by the size of the file; blackbox logs take some 2 s and 20
MB a megabyte."""
PACKED = 2.0
"""A file compressed by gzip counts as so many times its size."""
BESIDE = ".mapping.yaml"
"""Ending of a mapping file that is found next to a CSV file."""
METADATA = "_metadata.yaml"
"""Ending of a file of NanoBench next to a log."""
ARRAYS, PROGRESS = "arrays", "progress"
"""Folder of the answer's arrays, and a file that grows by a byte for each percent read."""
_CHILD = "workbench.logs.log_child"
_LOOK_PERIOD = 0.1
"""Period between two looks at the progress [s]."""
Log = TypeVar("Log")
_INVALID = (KeyError, TypeError, ValueError, AttributeError, OSError)


def beside(path: Path, ending: str) -> Path:
    """Return the file next to a log that describes it, whether it exists or not."""
    return path.with_name(stem(path) + ending)


def read_held(
    path: Path,
    made: Callable[[Any, ArrayReader], Log],
    progress: Callable[[float], None] | None = None,
    *,
    mapping: Path | None = None,
    log_number: int | None = None,
    own: bool = False,
) -> Log:
    """Return a log that a held process reads.

    Args:
        path: the log.
        made: makes it from the answer of the process and its arrays.
        progress: called with the share done, 0 .. 1, from another thread.
        mapping: names the columns of a CSV.
        log_number: of the log in a file with several, from 1; None for the longest one.
        own: whether only logs of the workbench are read.

    Raises:
        WorkbenchError: if it cannot be read, or is not a known kind of log.
    """
    seconds, megabytes = _limits(path)
    reads = [path, mapping or beside(path, BESIDE), beside(path, METADATA)]
    with TemporaryDirectory() as folder, _told(Path(folder) / PROGRESS, progress):
        request = {
            "path": str(path),
            "mapping": None if mapping is None else str(mapping),
            "log_number": log_number,
            "own": own,
            "folder": folder,
        }
        try:
            said = run_limited(
                _CHILD,
                request,
                seconds=seconds,
                megabytes=megabytes,
                reads=reads,
                writes=[folder],
            )
            return made(said, ArrayReader(Path(folder) / ARRAYS))
        except LimitedError as error:
            raise WorkbenchError(f"{path}: cannot be read as a log: {error}") from error
        except _INVALID as error:
            raise WorkbenchError(
                f"{path}: cannot be read as a log: its process answered what is no log ({error})"
            ) from error


def _limits(path: Path) -> tuple[float, int]:
    """Return the limits of processor time [s] and memory [MB].

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2_000_000
    with open_plain(path, machine * 1_000_000) as file:
        size = size_of(file) / 1e6 * (PACKED if file.read(len(GZIP)) == GZIP else 1.0)
    return (
        round(min(SECONDS + SECONDS_A_MEGABYTE * size, MOST_SECONDS), 1),
        round(min(MEGABYTES + MEGABYTES_A_MEGABYTE * size, MOST_MEGABYTES, machine)),
    )


@contextmanager
def _told(file: Path, progress: Callable[[float], None] | None) -> Iterator[None]:
    """Tell how far the process is, while it works."""
    if progress is None:
        yield
        return
    file.touch()
    over = threading.Event()

    def follow() -> None:
        while not over.wait(_LOOK_PERIOD):
            progress(min(file.stat().st_size / 100.0, 1.0))

    teller = threading.Thread(target=follow, daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()
    progress(1.0)
