"""What a reader of another program's logs is, and those that packages add.

Our own logs, in MCAP, are read by `mcap_log`; all other formats are extensions.
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.common.extensions import ExtensionGroup, find_extensions, load_extension
from workbench.common.flight import Flight
from workbench.logs.readers.packed import log_stem

LOG_HEAD_BYTES = 256
"""Number of bytes of a file that its reader is found by."""
OWN_LOG_ENDING, PACKED_LOG_ENDING = ".mcap", ".gz"
OWN_LOG = "a log of the workbench (.mcap)"


class LogFile(NamedTuple):
    """A file to read.

    Attributes:
        path: of the file, or of a decompressed copy for a reader that `needs_plain`.
        mapping: a file that names the columns of a table, if the user names one.
        number: of the log in a file with several, from 1; None for the longest one.
    """

    path: Path
    mapping: Path | None = None
    number: int | None = None


class LogReader(NamedTuple):
    """A format of logs; an entry of `workbench.log_readers` names one, or a tuple of them.

    It runs in a process that opens only the log, the files next to it that describe it, and those
    of Python, see `log_process`.

    Attributes:
        format: name, as "PX4 ULog".
        listed: how a list of known formats names it, as "PX4's .ulg".
        recognises: whether a file is of the format, from its path and the first `LOG_HEAD_BYTES`
            bytes of its content, decompressed.
        read: returns the flight; it raises WorkbenchError if it cannot.
        place: a file is that of the first reader by place that recognises it.
        endings: of the names of its files, in lower case.
        package: the package that it imports, "" if it needs none.
        needs_plain: whether it reads a decompressed copy of a compressed file.
        has_several: whether its files may have several logs.
        takes_mapping: whether it reads a file for which the user names a mapping.
        firmware: name of the autopilot whose parameters its logs have, as `gains import --for` has
            it; several have a space between them, and "" is none.
        companions: endings of the names of files next to a log that describe it, after the name of
            the log without its own: its reader may open them.
    """

    format: str
    listed: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[LogFile], Flight]
    place: int
    endings: tuple[str, ...] = ()
    package: str = ""
    needs_plain: bool = False
    has_several: bool = False
    takes_mapping: bool = False
    firmware: str = ""
    companions: tuple[str, ...] = ()


def begins_with(head: bytes, magic: bytes) -> bool:
    """Return whether a file begins with these bytes; of a shorter one all bytes must be of them."""
    return bool(head) and head.startswith(magic[: len(head)])


def companion_file(path: Path, ending: str) -> Path:
    """Return the file next to a log that describes it, whether it exists or not."""
    return path.with_name(log_stem(path) + ending)


def companion_files(path: Path) -> list[Path]:
    """Return the files next to a log that its reader may open, whether they exist or not."""
    endings = dict.fromkeys(ending for each in log_readers() for ending in each.companions)
    return [companion_file(path, ending) for ending in endings]


def log_readers() -> tuple[LogReader, ...]:
    """Return the readers that packages add, in the order in which they are asked."""
    return _loaded_readers()[0]


def reader_of(path: Path, head: bytes) -> LogReader | None:
    """Return the first reader that recognises a file, None if there is none."""
    return next((each for each in log_readers() if each.recognises(path, head)), None)


def log_endings() -> tuple[str, ...]:
    """Return the endings of the names of log files, in lower case; some logs have none."""
    others = [ending for each in log_readers() for ending in each.endings]
    return tuple(dict.fromkeys([OWN_LOG_ENDING, *others, PACKED_LOG_ENDING]))


def known_log_formats() -> str:
    """Return a list of the known formats; it ends with what cannot be loaded."""
    readers, failures = _loaded_readers()
    listed = [OWN_LOG, *(each.listed for each in readers)]
    text = f"{', '.join(listed[:-1])}, or {listed[-1]}" if readers else OWN_LOG
    if failures:
        names, first = ", ".join(failures), next(iter(failures.values()))
        text += f"; some readers of other formats are not there ({names}): {first}"
    return text


@cache
def _loaded_readers() -> tuple[tuple[LogReader, ...], dict[str, str]]:
    """Return the readers in order, and by their names why others cannot be loaded."""
    group = ExtensionGroup.LOG_READERS
    found: list[LogReader] = []
    failures: dict[str, str] = {}
    for name in find_extensions(group):
        try:
            entry = load_extension(group, name)
        except WorkbenchError as error:
            failures[name] = str(error)
        else:
            found += [entry] if isinstance(entry, LogReader) else entry
    return tuple(sorted(found, key=lambda each: each.place)), failures
