"""Compile a pure function with numba, and keep the machine code on disk.

numba's own cache depends only on the file with the compiled function, and needs all of numba to
load its code. The law and the rays consist of several files. So this cache uses a folder named
after the content of all of them, and `machine_code` loads it.
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

from workbench.common.cache import PROGRESS_LOGGER, REPEATED, cache_folder, release
from workbench.common.errors import WorkbenchError
from workbench.common.jitable import tell_numba
from workbench.common.machine_code import (
    Kind,
    OtherKindError,
    code_file,
    keep,
    kinds_of,
    load,
)

_PACKAGE = Path(__file__).parent.parent
PERIOD = 3.0
"""Period between messages about one wait [s]."""
PATIENCE = 1.5
"""Longest wait for another process or thread without a message [s]."""
_COMPILING = threading.RLock()
"""Lock for one thread at a time, as functions marked for numba are shared by the process."""


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
    """Return `function`, compiled at its first call, which takes up to a minute once per machine.

    Without a writable cache folder it is compiled in every process.

    Args:
        function: to be compiled.
        sources: files and folders below `workbench/` with all functions that it calls and the types
            of its arguments; a change in them compiles it again.
        what: description of its result, for messages.
        parts: approximate number of functions compiled for it, for the progress.
        text: identifies a source elsewhere, such as a user's own file.
        file: of that source, for error messages.
        page: of the docs that explains what can be compiled.
        options: of `numba.njit`, such as `nogil=True`, which lets other Python threads run during a
            long call.
    """
    return Compiled(function, sources, what, parts, text, file, page, options)


class Compiled:
    """A compiled function. Its first call in a process loads or compiles the machine code.

    One process or thread compiles it with messages; others that need it wait, and load it. numba
    itself is only loaded to compile, and for types of arguments or results that `machine_code` does
    not support; for those the function is compiled in every process. Arguments are those of
    `compile_cached`.

    Attributes:
        run: the machine code that ran last, a third of a microsecond faster to call. For arguments
            of other kinds, and before the first call, it raises `OtherKindError`.
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
        self.run: Callable[..., Any] = _nothing

    def __call__(self, *args: Any) -> Any:
        try:
            return self.run(*args)
        except OtherKindError:
            run = self._prepared(args)
        try:
            return run(*args)
        except OtherKindError:  # `machine_code` holds what it refuses for the kinds it has made
            self._compile(args)
        return self._dispatcher(*args)

    @property
    def signatures(self) -> list[Any]:
        """The kinds of arguments with machine code in this process."""
        return list(self._made)

    def _prepared(self, args: tuple[Any, ...]) -> Callable[..., Any]:
        """Return the machine code for arguments, compiled now if missing."""
        kinds = kinds_of(args)
        if kinds is None:
            self._compile(args)
            return self._dispatcher
        with self._making:
            if kinds not in self._made:
                self._made[kinds] = self._load_or_make(kinds, args)
        self.run = self._made[kinds]
        return self.run

    def _load_or_make(self, kinds: tuple[Kind, ...], args: tuple[Any, ...]) -> Callable[..., Any]:
        """Load machine code for kinds of arguments; compile and store it if missing."""
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
        """Compile with numba for arguments, and return the `CompileResult`.

        Return None if NUMBA_DISABLE_JIT is set, to debug a law as plain Python.

        Raises:
            WorkbenchError: if a user's own file cannot be compiled.
        """
        import numba  # takes half a second, only needed to compile
        from numba.core.errors import NumbaError, UnsupportedBytecodeError

        if numba.config.DISABLE_JIT:  # pyrefly: ignore[missing-attribute]
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
    """Placeholder for machine code that is not loaded yet."""
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
    """Report the progress of compiling a function.

    numba reports each function that it compiles, the outermost first, and LLVM processes all of
    them at the end, for longer than a period. So messages follow the clock.
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
            seconds = time.monotonic() - began
            logger.warning("compiling %s: %d %%, %.0f s", what, share, seconds, extra=REPEATED)

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
    """Wait until no other process compiles the same function; its result is then in the cache."""
    try:
        file = None if folder is None else (folder / "lock").open("w")
    except OSError:  # a read-only cache
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
                        "waiting for another process, which compiles %s", what, extra=REPEATED
                    )
                    told = time.monotonic() + PERIOD
                time.sleep(0.01)  # loading the result takes less
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
