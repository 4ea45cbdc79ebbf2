"""Cache folders for results that are slow to compute and can always be computed again."""

import importlib.util
import os
import stat
import tempfile
from functools import lru_cache
from pathlib import Path

from workbench.common.errors import WorkbenchError

_CACHE_FOLDER_NAME = "drake-drone-workbench"
PROGRESS_LOGGER = "workbench.progress"
"""Name of the logger for the progress of slow computations."""
REPEATED_RECORD = {"repeated": True}
"""Marks a record of that logger as one of many about the same work."""


def cache_folder(name: str) -> Path:
    """Return a folder in the user's cache, created if missing.

    If the cache is not writable, this is a private temporary folder.

    Args:
        name: of the folder; the same name yields the same folder.

    Raises:
        WorkbenchError: if no folder is writable.
    """
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME", ""))
        if not home.is_absolute():  # the specification says to ignore relative ones
            home = Path.home() / ".cache"
        return _writable(home / _CACHE_FOLDER_NAME / name)
    except (OSError, RuntimeError):  # a read-only home, or (RuntimeError) no home
        return _temporary(name)


@lru_cache(maxsize=8)
def release(package: str) -> str:
    """Return the installed release of a package, as cached results may depend on it.

    It is in the name of the metadata folder; reading the metadata loads a mail parser.

    Args:
        package: its name, in the metadata and for import.
    """
    spec = importlib.util.find_spec(package)
    for place in (spec and spec.submodule_search_locations) or ():
        found = [each.name for each in Path(place).parent.glob(f"{package}-*.dist-info")]
        if len(found) == 1:  # more of them remain after a failed installation
            return found[0]
    from importlib import metadata

    return metadata.version(package)


def _temporary(name: str) -> Path:
    try:
        return _writable(_private_folder() / name)
    except OSError as error:
        raise WorkbenchError(
            f"no folder for the cache can be written ({error}): set XDG_CACHE_HOME to one"
        ) from error


def _writable(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.R_OK | os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} is not writable")
    return folder


def _private_folder() -> Path:
    """Return a private folder of the user in a shared place.

    Its name can be guessed, so another user may have created it: then it is not used.
    """
    folder = Path(tempfile.gettempdir()) / f"{_CACHE_FOLDER_NAME}-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    shut = stat.S_ISDIR(status.st_mode) and not status.st_mode & 0o077
    if shut and status.st_uid == os.getuid():
        return folder
    return Path(tempfile.mkdtemp(prefix=f"{_CACHE_FOLDER_NAME}-"))
