"""Compile a pure function with numba, and keep the machine code on disk.

numba's own cache looks at the one file that the compiled function stands in; the law stands in
several, and so do rays. So the cache lies in a folder named after the content of all of them.
"""

import fcntl
import hashlib
import logging
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import IO, Any

from workbench.common.cache import PROGRESS_LOGGER, cache_folder
from workbench.common.errors import WorkbenchError
from workbench.common.jitable import tell_numba

_PACKAGE = Path(__file__).parent.parent
PERIOD = 4.0
"""Between two messages about one compilation [s]."""
PATIENCE = 1.5
"""A shorter wait for another process or thread is not told of [s]."""
_PREPARING = threading.Lock()
"""One thread at a time: where numba's cache lies, and what it was told of, are the process's."""


def compile_cached(
    function: Callable[..., Any],
    sources: Sequence[str],
    what: str,
    parts: int = 1,
    text: str = "",
    file: str = "",
    page: str = "docs/controllers.md",
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
        text: what tells a source that stands elsewhere, as a user's own, from any other.
        file: where that stands, for the sentence about what cannot be compiled.
        page: of the docs, which says what can be.
        options: of `numba.njit`, such as `nogil=True`, which lets other Python threads run
            meanwhile: worth it where a call takes long.
    """
    return Compiled(function, sources, what, parts, text, file, page, options)


class Compiled:
    """A compiled function. Its first call in a process loads the machine code, or makes it.

    One process or thread makes it and says so; others that need it meanwhile wait, and load it.
    Arguments are those of `compile_cached`.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        sources: Sequence[str],
        what: str,
        parts: int,
        text: str,
        file: str,
        page: str,
        options: Mapping[str, Any],
    ) -> None:
        self._function = function
        self._sources = sources
        self._what = what
        self._parts = parts
        self._text = text
        self._file = file
        self._page = page
        self._options = options
        self._dispatcher: Any = None
        self._ready = False

    def __call__(self, *args: Any) -> Any:
        if self._ready:
            return self._dispatcher(*args)
        with _PREPARING:
            folder = self._prepare()
        with _alone(folder, self._what), _told(self._dispatcher, self._what, self._parts):
            result = self._first(*args)
        self._ready = True
        return result

    def _first(self, *args: Any) -> Any:
        """Call it for the first time; what numba cannot compile is said in a sentence."""
        from numba.core.errors import NumbaError, UnsupportedBytecodeError

        try:
            return self._dispatcher(*args)
        except (NumbaError, UnsupportedBytecodeError) as error:
            if not self._file:
                raise
            raise WorkbenchError(uncompilable(str(error), self._file, self._page)) from None

    @property
    def signatures(self) -> list[Any]:
        """The types of arguments for which there is machine code in this process."""
        return list(self._dispatcher.signatures) if self._dispatcher else []

    @property
    def is_made(self) -> bool:
        """Whether there is machine code here or on disk, so that the first call is short."""
        if self._ready:
            return True
        try:
            # numba writes its index first: one without code is of a process that was killed
            return any(self._folder().rglob("*.nbc"))
        except (WorkbenchError, OSError):
            return False

    def _folder(self) -> Path:
        """Return the folder of its cache.

        Raises:
            WorkbenchError, OSError: if there is none.
        """
        folder = cache_folder(_digest(self._sources, self._text, self._options))
        folder = folder / self._function.__name__
        folder.mkdir(exist_ok=True)
        return folder

    def _prepare(self) -> Path | None:
        """Make numba's dispatcher, once; return the folder of its cache, None without one."""
        import numba  # half a second, which only those pay who compile
        from numba.core import config

        try:
            folder: Path | None = self._folder()
        except (WorkbenchError, OSError):  # it runs without a cache, too
            folder = None
        if self._dispatcher is not None:
            return folder
        tell_numba()
        if folder is None:
            self._dispatcher = numba.njit(**self._options)(self._function)
            return None
        before = config.CACHE_DIR  # type: ignore[attr-defined]
        config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
        try:
            made = numba.njit(cache=True, **self._options)(self._function)
        finally:
            config.CACHE_DIR = before  # type: ignore[attr-defined]
        # the folder says all that decides; numba's own key would have the function's inner
        # functions, in bytes that are others in every process
        made._cache._index_key = lambda signature, codegen: (signature, codegen.magic_tuple())
        self._dispatcher = made
        return folder


def uncompilable(said: str, file: str, page: str) -> str:
    """Return numba's complaint about a user's file as a sentence.

    Args:
        said: by numba, which names every function on the way.
        file: of the user.
        page: see `compile_cached`.
    """
    plain = re.sub(r"\x1b\[\d*m", "", said)
    lines = re.findall(rf"(?:{re.escape(file)}|{re.escape(Path(file).name)}) \((\d+)\)", plain)
    reasons = re.findall(
        r"^\s*(?:>>> (\w[^(]*)\(|(Untyped global name [^\n]*)|(Cannot [^\n]*)|(Unknown [^\n]*)"
        r"|(Invalid use [^\n]*)|(Use of unsupported [^\n]*)|(cannot [^\n]*))",
        plain,
        re.MULTILINE,
    )
    words = [next(filter(None, found)) for found in reasons]
    what = " ".join(words[-1].split()) if words else plain.strip().splitlines()[-1]
    what = what.partition(" Raised from ")[0]
    where = f"{file}:{lines[-1]}" if lines else file
    return (
        f"{where}: cannot be compiled at '{what:.120}': write it with numbers, tuples, + - * / ** "
        f"and comparisons, see {page}"
    )


@contextmanager
def _told(dispatcher: Any, what: str, parts: int) -> Iterator[None]:
    """Say that a function compiles, and how far it is.

    numba reports each function that it compiles, first the outermost one; none where the machine
    code comes from the cache.
    """
    from numba.core import event

    logger = logging.getLogger(PROGRESS_LOGGER)

    class Listener(event.Listener):
        began: float | None = None
        said = 0.0
        done = 0

        def on_start(self, event: Any) -> None:
            if event.data["dispatcher"] is dispatcher:
                self.began = self.said = time.monotonic()
                logger.warning("compiling %s for this machine, up to a minute, this once", what)

        def on_end(self, event: Any) -> None:
            if self.began is None:  # of something else
                return
            self.done += 1
            now = time.monotonic()
            if event.data["dispatcher"] is dispatcher:
                logger.warning("compiled %s in %.0f s", what, now - self.began)
                self.began = None
            elif now > self.said + PERIOD:
                self.said = now
                share = min(99, 100 * self.done // parts)
                logger.warning("compiling %s: %d %%", what, share)

    with event.install_listener("numba:compile", Listener()):
        yield


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
            told = time.monotonic() + PATIENCE
            while not _locks(file):
                if time.monotonic() > told:
                    logging.getLogger(PROGRESS_LOGGER).warning(
                        "waiting for another process, which compiles %s", what
                    )
                    fcntl.flock(file, fcntl.LOCK_EX)
                    break
                time.sleep(0.01)  # who loads what is made takes less
        yield


def _locks(file: IO[str]) -> bool:
    """Return whether a file is locked now by this process and thread."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _digest(sources: Sequence[str], text: str, options: Mapping[str, Any]) -> str:
    """Return a name for the sources as they are, and for how they are compiled."""
    how = sorted((name, str(value)) for name, value in options.items())
    digest = hashlib.sha256(f"{version('numba')} {how} {text}".encode())
    for name in sources:
        path = _PACKAGE / name
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
