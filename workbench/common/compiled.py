"""Compile a pure function with numba, and keep the code on disk.

numba's own cache depends only on the file with the compiled function. The law and the rays consist
of several files. So the cache uses a folder named after the content of all of them.
"""

import fcntl
import hashlib
import logging
import os
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from workbench.common.cache import PROGRESS_LOGGER, REPEATED_RECORD, cache_folder, release
from workbench.common.errors import WorkbenchError
from workbench.common.jitable import register_with_numba
from workbench.common.optional_package import has_package, install_command
from workbench.common.resources import PACKAGE_FOLDER

if TYPE_CHECKING:
    from numba.core.dispatcher import Dispatcher
    from numba.core.event import Event
    from numba.core.types import Type

WAIT_MESSAGE_PERIOD_S = 3.0
"""Period between messages about one wait [s]."""
MAX_SILENT_WAIT_S = 1.5
"""Longest wait for another process or thread without a message [s]."""


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
    """A compiled function. Its first call in a process loads numba, and loads or compiles the code.

    One process or thread compiles it with messages; others that need it wait, and load it.
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
        self._run: Callable[..., Any] | None = None
        self._beginning = threading.Lock()

    def __call__(self, *args: Any) -> Any:
        run = self._run or self._begun()
        return run(*args)

    @property
    def signatures(self) -> list[Any]:
        """The types of arguments with compiled code in this process."""
        return list(getattr(self._run, "signatures", ()))

    @property
    def is_kept(self) -> bool:
        """Whether there is machine code for some types of arguments, here or on disk.

        This looks for a file only, as loading numba takes a quarter of a second.
        """
        if self.signatures:
            return True
        folder = self._folder()
        return folder is not None and any(folder.glob("*.nbi"))

    def _begun(self) -> Callable[..., Any]:
        """Return what numba makes of the function.

        It is the function itself if NUMBA_DISABLE_JIT is set, or without numba, with a warning.
        """
        if not has_package("numba"):
            logging.getLogger("workbench").warning(
                "%s: without numba Python computes them, which is slow: run `%s`",
                self._what,
                install_command("numba"),
            )
            self._run = self._function
            return self._run
        import numba  # takes a quarter of a second, and most commands compile nothing

        from workbench.common.code_cache import CodeCache

        with self._beginning:
            if self._run is None:
                run: Any = numba.njit(**self._options)(self._function)
                if run is not self._function:
                    folder = self._folder()
                    if folder:
                        run._cache = CodeCache(folder, self._function)
                    run.compile = partial(self._compile, run, run.compile, folder)
                self._run = run
            return self._run

    def _compile(
        self,
        run: Any,
        compile_: Callable[..., Any],
        folder: Path | None,
        types: "tuple[Type, ...]",
    ) -> Callable[..., Any]:
        """Load or compile the code for types of arguments; numba's dispatcher calls it.

        Args:
            run: the dispatcher.
            compile_: its own method.
            folder: of its cache, or None.
            types: of the arguments.

        Raises:
            WorkbenchError: if a user's own file cannot be compiled.
        """
        from numba.core.compiler_lock import global_compiler_lock
        from numba.core.errors import NumbaError, UnsupportedBytecodeError

        kept = folder and run._cache.holds(types, run.targetctx)
        with (
            _compilation_lock(None if kept else folder, self._what),
            global_compiler_lock,  # threads share the functions marked for numba
            _report_compilation(run, self._what, self._parts),
        ):
            register_with_numba()
            try:
                return compile_(types)
            except (NumbaError, UnsupportedBytecodeError) as error:
                if not self._file:
                    raise
                raise WorkbenchError(
                    numba_error_sentence(str(error), self._file, self._page)
                ) from None

    def _folder(self) -> Path | None:
        """Return the folder of its cache, or None if no folder can be written."""
        try:
            folder = cache_folder(_digest(self._sources, self._text, self._options))
            folder = folder / self._function.__name__
            folder.mkdir(exist_ok=True)
        except (WorkbenchError, OSError):  # it runs without a cache, too
            return None
        return folder


def numba_error_sentence(said: str, file: str, page: str) -> str:
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
def _report_compilation(dispatcher: "Dispatcher", what: str, parts: int) -> Iterator[None]:
    """Report the progress of compiling a function.

    numba reports each function that it compiles, the outermost first, and LLVM processes all of
    them at the end, for longer than a period. So messages follow the clock.
    """
    from numba.core import event

    logger = logging.getLogger(PROGRESS_LOGGER)
    ended = threading.Event()

    class Listener(event.Listener):
        done = 0

        def on_start(self, event: "Event") -> None:
            about: Any = event.data
            if about["dispatcher"] is dispatcher:
                logger.warning("compiling %s for this machine, up to a minute, this once", what)
                clock.start()

        def on_end(self, event: "Event") -> None:
            self.done += clock.is_alive()  # what else compiles is not counted

    listener = Listener()

    def tell() -> None:
        while not ended.wait(WAIT_MESSAGE_PERIOD_S):
            share = min(99, 100 * listener.done // parts)
            seconds = time.monotonic() - began
            logger.warning(
                "compiling %s: %d %%, %.0f s", what, share, seconds, extra=REPEATED_RECORD
            )

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
def _compilation_lock(folder: Path | None, what: str) -> Iterator[None]:
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
            told = time.monotonic() + MAX_SILENT_WAIT_S
            while not _locks(file):
                if time.monotonic() > told:
                    logging.getLogger(PROGRESS_LOGGER).warning(
                        "waiting for another process, which compiles %s",
                        what,
                        extra=REPEATED_RECORD,
                    )
                    told = time.monotonic() + WAIT_MESSAGE_PERIOD_S
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
    """Return a name for the sources as they are, and for what compiles them, and how.

    numba's key for the code names the processor.
    """
    made_by = [sys.version, *map(release, ("numba", "llvmlite", "numpy"))]
    settings = sorted(each for each in os.environ.items() if each[0].startswith("NUMBA_"))
    how = sorted((name, str(value)) for name, value in options.items())
    digest = hashlib.sha256(f"{made_by} {settings} {how} {text}".encode())
    names_code = Path(__file__).with_name("code_cache.py")
    for path in (names_code, *(PACKAGE_FOLDER / name for name in sources)):
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
