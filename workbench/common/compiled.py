"""Compile a pure function with numba, and keep the machine code on disk.

numba's own cache looks at the one file that the compiled function stands in; the law stands in
several, and so do rays. So the cache lies in a folder named after the content of all of them.
"""

import fcntl
import hashlib
import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numba
from numba.core import config, event

from workbench.common.cache import PROGRESS_LOGGER, cache_folder
from workbench.common.errors import WorkbenchError

_PACKAGE = Path(__file__).parent.parent
PERIOD = 4.0
"""Between two messages about one compilation [s]."""


def compile_cached(
    function: Callable[..., Any],
    sources: Sequence[str],
    what: str,
    parts: int = 1,
    **options: Any,
) -> "Compiled":
    """Return `function` compiled at its first call, up to a minute once a machine.

    Where no folder can be written, it is compiled anew in every process.

    Args:
        function: which compiles.
        sources: files and folders of all that it calls, and of its arguments' types, below
            `workbench/`; a change there compiles anew.
        what: it computes, for people.
        parts: about how many functions are compiled for it, for the progress that is told.
        options: of `numba.njit`, such as `nogil=True`, which lets other Python threads run
            meanwhile: worth it where a call takes long.
    """
    try:
        folder = cache_folder(_digest(sources, options)) / function.__name__
        folder.mkdir(exist_ok=True)
    except (WorkbenchError, OSError):  # it runs without a cache, too
        return Compiled(numba.njit(**options)(function), what, parts, None)
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        compiled = numba.njit(cache=True, **options)(function)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]
    return Compiled(compiled, what, parts, folder)


class Compiled:
    """A compiled function. Its first call in a process loads the machine code, or makes it.

    One process or thread makes it and says so; others that need it meanwhile wait, and load it.

    Args:
        dispatcher: numba's.
        what: it computes, for people.
        parts: about how many functions are compiled for it.
        folder: of the cache, None without one.
    """

    def __init__(self, dispatcher: Any, what: str, parts: int, folder: Path | None) -> None:
        self._dispatcher = dispatcher
        self._what = what
        self._parts = parts
        self._folder = folder
        self._ready = False

    def __call__(self, *args: Any) -> Any:
        if self._ready:
            return self._dispatcher(*args)
        listener = _Listener(self._dispatcher, self._what, self._parts)
        with _alone(self._folder, self._what), event.install_listener("numba:compile", listener):
            result = self._dispatcher(*args)
        self._ready = True
        return result

    @property
    def signatures(self) -> list[Any]:
        """The types of arguments for which there is machine code in this process."""
        return list(self._dispatcher.signatures)


class _Listener(event.Listener):
    """Says that a function compiles, and how far it is.

    numba reports each function that it compiles, first the outermost one; none where the machine
    code comes from the cache.
    """

    def __init__(self, dispatcher: Any, what: str, parts: int) -> None:
        self._dispatcher = dispatcher
        self._what = what
        self._parts = parts
        self._logger = logging.getLogger(PROGRESS_LOGGER)
        self._done = 0
        self._began: float | None = None
        self._said = 0.0

    def on_start(self, event: Any) -> None:
        if event.data["dispatcher"] is self._dispatcher:
            self._began = self._said = time.monotonic()
            self._logger.warning(
                "compiling %s for this machine, up to a minute, this once", self._what
            )

    def on_end(self, event: Any) -> None:
        if self._began is None:  # of something else
            return
        self._done += 1
        now = time.monotonic()
        if event.data["dispatcher"] is self._dispatcher:
            self._logger.warning("compiled %s in %.0f s", self._what, now - self._began)
            self._began = None
        elif now > self._said + PERIOD:
            self._said = now
            share = min(99, 100 * self._done // self._parts)
            self._logger.warning("compiling %s: %d %%", self._what, share)


@contextmanager
def _alone(folder: Path | None, what: str) -> Iterator[None]:
    """Wait until nobody else compiles the same; what they made is in the cache then."""
    try:
        file = None if folder is None else (folder / "lock").open("w")
    except OSError:  # a cache that can be read alone
        file = None
    if file is None:
        yield
        return
    with file:
        with suppress(OSError):  # some network file systems have no locks
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                logging.getLogger(PROGRESS_LOGGER).warning(
                    "waiting for another process, which compiles %s", what
                )
                fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _digest(sources: Sequence[str], options: Mapping[str, Any]) -> str:
    """Return a name for the sources as they are, and for how they are compiled."""
    how = sorted((name, str(value)) for name, value in options.items())
    digest = hashlib.sha256(f"{numba.__version__} {how}".encode())
    for name in sources:
        path = _PACKAGE / name
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
