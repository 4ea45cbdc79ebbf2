"""Compile a pure function with numba, and keep the machine code on disk.

numba's own cache looks at the one file that the compiled function stands in, and loads all of numba
to load what is there. The law stands in several files, and so do rays: the cache lies in a folder
named after the content of all of them, and `machine_code` loads it.
"""

import fcntl
import hashlib
import logging
import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from workbench.common.cache import PROGRESS_LOGGER, cache_folder, release
from workbench.common.errors import WorkbenchError
from workbench.common.jitable import tell_numba
from workbench.common.machine_code import (
    Kind,
    OtherKindError,
    code_file,
    has_code,
    keep,
    kinds_of,
    load,
)

_PACKAGE = Path(__file__).parent.parent
PERIOD = 3.0
"""Between two messages about one wait [s]."""
PATIENCE = 1.5
"""A shorter wait for another process or thread is not told of [s]."""
_COMPILING = threading.RLock()
"""One thread at a time: what numba was told of is the process's."""


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
    numba itself is loaded by who makes it, and for arguments or results that `machine_code` does
    not know; it is compiled in every process for those. Arguments are those of `compile_cached`.
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
        self._made: dict[tuple[Kind, ...], Callable[..., Any]] = {}
        self._making = threading.Lock()
        self._run: Callable[..., Any] = _nothing

    def __call__(self, *args: Any) -> Any:
        try:
            return self._run(*args)
        except OtherKindError:
            run = self._prepared(args)
        try:
            return run(*args)
        except OtherKindError:  # `machine_code` holds what it refuses for the kinds it has made
            self._compile(args)
        return self._dispatcher(*args)

    @property
    def signatures(self) -> list[Any]:
        """The kinds of arguments for which there is machine code in this process."""
        return list(self._made)

    @property
    def is_made(self) -> bool:
        """Whether there is machine code here or on disk, so that the first call is short."""
        if self._made:
            return True
        try:
            return has_code(self._folder())
        except (WorkbenchError, OSError):
            return False

    def _prepared(self, args: tuple[Any, ...]) -> Callable[..., Any]:
        """Return what runs for such arguments: machine code that is there, or is made now."""
        kinds = kinds_of(args)
        if kinds is None:
            self._compile(args)
            return self._dispatcher
        with self._making:
            if kinds not in self._made:
                self._made[kinds] = self._load_or_make(kinds, args)
        self._run = self._made[kinds]
        return self._run

    def _load_or_make(self, kinds: tuple[Kind, ...], args: tuple[Any, ...]) -> Callable[..., Any]:
        """Load machine code for arguments of some kinds; make and keep it where there is none."""
        try:
            folder: Path | None = self._folder()
        except (WorkbenchError, OSError):  # it runs without a cache, too
            folder = None
        file = code_file(folder, self._function, kinds) if folder else None
        if found := file and load(file):
            return found
        with _alone(folder, self._what):
            if found := file and load(file):  # another one has made it meanwhile
                return found
            result = self._compile(args)
            if file and result:
                with suppress(WorkbenchError):  # as above; numba's own can be called
                    keep(file, result, kinds)
        return (file and load(file)) or self._dispatcher

    def _compile(self, args: tuple[Any, ...]) -> Any:
        """Let numba compile for such arguments, and return its `CompileResult`.

        None where NUMBA_DISABLE_JIT is set: people debug a law that way, as plain Python.

        Raises:
            WorkbenchError: if it cannot be compiled, of a file of the user's own.
        """
        import numba  # half a second, which only those pay who compile
        from numba.core.errors import NumbaError, UnsupportedBytecodeError

        if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
            self._dispatcher = self._function
            return None
        types = tuple(map(numba.typeof, args))
        if self._dispatcher is not None and types in self._dispatcher.overloads:
            return self._dispatcher.overloads[types]
        with _COMPILING:
            tell_numba()
            if self._dispatcher is None:
                self._dispatcher = numba.njit(**self._options)(self._function)
            with _told(self._dispatcher, self._what, self._parts):
                try:
                    self._dispatcher.compile(types)
                except (NumbaError, UnsupportedBytecodeError) as error:
                    if not self._file:
                        raise
                    raise WorkbenchError(uncompilable(str(error), self._file, self._page)) from None
        return self._dispatcher.overloads[types]

    def _folder(self) -> Path:
        """Return the folder of its cache.

        Raises:
            WorkbenchError, OSError: if there is none.
        """
        folder = cache_folder(_digest(self._sources, self._text, self._options))
        folder = folder / self._function.__name__
        folder.mkdir(exist_ok=True)
        return folder


def _nothing(*args: Any) -> Any:
    """Run in the place of machine code that is not there yet."""
    raise OtherKindError


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

    numba reports each function that it compiles, first the outermost one, and LLVM has all of them
    at the end, for longer than a period: so it is told by the clock.
    """
    from numba.core import event

    logger = logging.getLogger(PROGRESS_LOGGER)
    ended = threading.Event()

    class Listener(event.Listener):
        done = 0

        def on_start(self, event: Any) -> None:
            if event.data["dispatcher"] is dispatcher:
                logger.warning("compiling %s for this machine, up to a minute, this once", what)
                clock.start()

        def on_end(self, event: Any) -> None:
            self.done += clock.is_alive()  # what else compiles is not counted

    listener = Listener()

    def tell() -> None:
        while not ended.wait(PERIOD):
            share = min(99, 100 * listener.done // parts)
            logger.warning("compiling %s: %d %%, %.0f s", what, share, time.monotonic() - began)

    clock = threading.Thread(target=tell, daemon=True)
    began = time.monotonic()
    try:
        with event.install_listener("numba:compile", listener):
            yield
    finally:
        ended.set()
        if clock.ident is not None:  # it has begun
            clock.join()
    if clock.ident is not None:
        logger.warning("compiled %s in %.0f s", what, time.monotonic() - began)


@contextmanager
def _alone(folder: Path | None, what: str) -> Iterator[None]:
    """Wait until no other process compiles the same; its result is in the cache then."""
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
                    told = time.monotonic() + PERIOD
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
    digest = hashlib.sha256(f"{release('numba')} {how} {text}".encode())
    for name in sources:
        path = _PACKAGE / name
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
