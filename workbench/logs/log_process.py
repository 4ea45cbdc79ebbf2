"""Read a log in a process that the system limits, as all of a log is foreign; see `log_child`."""

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import open_file_size, open_plain
from workbench.ipc.limited import LimitedError, run_limited
from workbench.logs.array_files import ArrayReader
from workbench.logs.readers.log_reader import LogFile, companion_files
from workbench.logs.readers.packed import GZIP_MAGIC

LOG_BASE_CPU_S, LOG_CPU_S_PER_MB = 3.0, 4.0
LOG_BASE_MEMORY_MB = 400
LOG_MEMORY_PER_FILE_MB = 30
MAX_LOG_CPU_S = 900.0
MAX_LOG_MEMORY_MB = 12_000
"""Limits of processor time and memory by the size of the file; blackbox logs take some 0.5 s and
32 MB a megabyte."""
GZIP_SIZE_FACTOR = 2.0
"""A file compressed by gzip counts as so many times its size."""
ARRAYS_FOLDER, PROGRESS_FILE = "arrays", "progress"
"""Folder of the answer's arrays, and a file that grows by a byte for each percent read."""
_LOG_CHILD_MODULE = "workbench.logs.log_child"
_PROGRESS_PERIOD_S = 0.1
"""Period between two looks at the progress [s]."""
Log = TypeVar("Log")
_INVALID_ANSWER_ERRORS = (KeyError, TypeError, ValueError, AttributeError, OSError)


def read_in_process(
    file: LogFile,
    made: Callable[[Any, ArrayReader], Log],
    progress: Callable[[float], None] | None = None,
    *,
    own: bool = False,
) -> Log:
    """Return a log that a held process reads.

    Args:
        file: the log.
        made: makes it from the answer of the process and its arrays.
        progress: called with the share done, 0 .. 1, from another thread.
        own: whether only logs of the workbench are read.

    Raises:
        WorkbenchError: if it cannot be read, or is not a known kind of log.
    """
    path, mapping, number = file
    seconds, megabytes = _process_limits(path)
    reads = [path] if own else [path, *filter(None, [mapping]), *companion_files(path)]
    try:
        temporary = TemporaryDirectory()
    except OSError as error:
        raise WorkbenchError(
            f"{path}: cannot be read, as no temporary folder can be made: {error.strerror}: make "
            "room, or set TMPDIR to another folder"
        ) from error
    with temporary as folder, _reported_progress(Path(folder) / PROGRESS_FILE, progress):
        request = {
            "path": str(path),
            "mapping": None if mapping is None else str(mapping),
            "log_number": number,
            "own": own,
            "folder": folder,
        }
        try:
            said = run_limited(
                _LOG_CHILD_MODULE,
                request,
                seconds=seconds,
                megabytes=megabytes,
                reads=reads,
                writes=[folder],
            )
            return made(said, ArrayReader(Path(folder) / ARRAYS_FOLDER))
        except LimitedError as error:
            raise WorkbenchError(f"{path}: cannot be read as a log: {error}") from error
        except _INVALID_ANSWER_ERRORS as error:
            raise WorkbenchError(
                f"{path}: cannot be read as a log: its process answered what is no log ({error})"
            ) from error


def _process_limits(path: Path) -> tuple[float, int]:
    """Return the limits of processor time [s] and memory [MB].

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2_000_000
    with open_plain(path, machine * 1_000_000) as file:
        size = (
            open_file_size(file)
            / 1e6
            * (GZIP_SIZE_FACTOR if file.read(len(GZIP_MAGIC)) == GZIP_MAGIC else 1.0)
        )
    return (
        round(min(LOG_BASE_CPU_S + LOG_CPU_S_PER_MB * size, MAX_LOG_CPU_S), 1),
        round(min(LOG_BASE_MEMORY_MB + LOG_MEMORY_PER_FILE_MB * size, MAX_LOG_MEMORY_MB, machine)),
    )


@contextmanager
def _reported_progress(file: Path, progress: Callable[[float], None] | None) -> Iterator[None]:
    """Tell how far the process is, while it works."""
    if progress is None:
        yield
        return
    file.touch()
    over = threading.Event()

    def follow() -> None:
        while not over.wait(_PROGRESS_PERIOD_S):
            progress(min(file.stat().st_size / 100.0, 1.0))

    teller = threading.Thread(target=follow, daemon=True)
    teller.start()
    try:
        yield
    finally:
        over.set()
        teller.join()
    progress(1.0)
