"""A user's own Python file: find, read and execute it, and check its tables.

Controllers and estimators are such files. Their code runs with the rights of the user who names
them.
"""

import hashlib
import importlib.util
import inspect
import math
import signal
import sys
import threading
import traceback
import types
from collections import namedtuple
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from typing import Any

from workbench.common.bounded_loops import LOOP_CHECK_NAMES, bounded_code
from workbench.common.errors import WorkbenchError
from workbench.common.parameter import Parameter, State
from workbench.common.plain_files import read_plain_text

Trace = Callable[[types.FrameType, str, Any], Any]
"""What `sys.settrace` takes."""

MAX_USER_FILE_BYTES = 4_000_000
"""Size limit of a file."""
MAX_CALL_TIME_S, MAX_LOADING_TIME_S = 10.0, 60.0
"""Time after which a function that Python runs, and a file, count as never returning [s]."""
MAX_EXECUTED_LINES = 1_000_000
"""Number of lines after which a file or an update counts as an endless loop."""


def find_user_file(name: str, what: str) -> Path | None:
    """Return the file for a name, None if the name is neither a file nor a module.

    Args:
        name: path of a .py file, or name of an importable module with a dot.
        what: kind of the file, for messages.

    Raises:
        WorkbenchError: if there is no such module.
    """
    if name.endswith(".py"):
        return Path(name)
    if "." not in name:
        return None
    found = importlib.util.find_spec(name) if _importable(name) else None
    if found is None or not found.origin:
        raise WorkbenchError(f"{what} {name}: no such module is installed")
    return Path(found.origin)


def read_user_file(path: Path, what: str) -> str:
    """Return the text of a user's own file.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    try:
        return read_plain_text(path, MAX_USER_FILE_BYTES)
    except WorkbenchError as error:
        raise WorkbenchError(f"{error}: give the {what}'s file") from None


def _importable(name: str) -> bool:
    """Return whether the package of a module can be found."""
    try:
        return importlib.util.find_spec(name.rpartition(".")[0]) is not None
    except (ImportError, ValueError):
        return False


def run_user_file(what: str, name: str, file: Path, text: str) -> types.ModuleType:
    """Return the module from executing a text.

    Args:
        what: kind of the file, "controller" or "estimator".
        name: of the file, without ending.
        file: of the text.
        text: of the file.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    if not name.isidentifier():
        raise WorkbenchError(
            f"{file}: name the file with letters, digits and _ only, as my_{what}.py"
        )
    digest = hashlib.sha256(text.encode()).hexdigest()[:12]  # see `give_unique_name`
    whole = f"workbench_{what}_{name}_{digest}"  # machine code on disk finds the module by it
    loader = _TextLoader(whole, file, text)
    module = types.ModuleType(whole)
    module.__file__ = str(file)
    sys.modules[whole] = module
    with user_code_errors(file, ""):
        module.__spec__ = ModuleSpec(whole, loader, origin=str(file))
        module.__dict__.update(LOOP_CHECK_NAMES)
        with limit_executed_lines(file):
            loader.exec_module(module)
    return module


class _TextLoader(SourceFileLoader):
    """Loads a module from a text that need not be in its file any more."""

    def __init__(self, name: str, file: Path, text: str) -> None:
        super().__init__(name, str(file))
        self._file, self._text = file, text

    def get_code(self, fullname: str) -> types.CodeType:
        return bounded_code(self._text, self._file)


def read_update(file: Path, own: Mapping[str, Any], arguments: Sequence[str]) -> Callable[..., Any]:
    """Return the `update` of a file.

    Raises:
        WorkbenchError: if it is missing, or has other arguments.
    """
    update = own.get("update")
    if not inspect.isfunction(update):
        raise WorkbenchError(f"{file}: has no update: write def update({', '.join(arguments)})")
    given = tuple(inspect.signature(update).parameters)
    if given != tuple(arguments):
        raise WorkbenchError(
            f"{file}:{update.__code__.co_firstlineno}: update takes ({', '.join(given)}): let it "
            f"take ({', '.join(arguments)})"
        )
    return update


def read_parameters(file: Path, own: Mapping[str, Any]) -> tuple[Parameter, ...]:
    """Return the `PARAMETERS` of a file.

    Raises:
        WorkbenchError: if one is not a valid row, or its default is out of its limits.
    """
    rows = read_user_table(file, own, "PARAMETERS", Parameter, "gain(...)")
    for row in rows:
        if not row.minimum <= row.default <= row.maximum:
            raise WorkbenchError(
                f"{file}: the default of {row.name}, {row.default:g}, is not within "
                f"{row.minimum:g} .. {row.maximum:g}: change one of the three"
            )
    return rows


def read_memory(file: Path, own: Mapping[str, Any]) -> tuple[State, ...]:
    """Return the `MEMORY` of a file.

    Raises:
        WorkbenchError: if one is not a valid row, is repeated, or has an initial value that is not
            finite.
    """
    memory = read_user_table(file, own, "MEMORY", State, "State(...)")
    check_names(file, "state", [each.name for each in memory])
    for state in memory:
        if not math.isfinite(state.initial):
            raise WorkbenchError(
                f"{file}: the state {state.name} begins with {state.initial}: write a finite number"
            )
    return memory


def read_user_table(
    file: Path, own: Mapping[str, Any], name: str, kind: type, make: str
) -> tuple[Any, ...]:
    """Return a table of a file.

    Args:
        file: of the text.
        own: all definitions in the file, by name.
        name: of the table.
        kind: of its rows.
        make: how to write a row, for messages.

    Raises:
        WorkbenchError: if it has rows of other types.
    """
    rows = own.get(name, ())
    if not isinstance(rows, list | tuple) or not all(isinstance(row, kind) for row in rows):
        raise WorkbenchError(f"{file}: {name} is not a table: write {name} = [{make}, ...]")
    return tuple(rows)


def check_names(file: Path, what: str, names: Sequence[str]) -> None:
    """Check that names are valid and unique."""
    for place, name in enumerate(names):
        if not (isinstance(name, str) and name.isidentifier()) or name.startswith("_"):
            raise WorkbenchError(f"{file}: '{name}' is not a name for a {what}: use letters and _")
        if name in names[:place]:
            raise WorkbenchError(f"{file}: the {what} {name} appears twice: leave one out")


def user_record_type(
    name: str, fields: Sequence[str], defaults: Sequence[float] | None = None
) -> Any:
    """Return the type of a named tuple with fields from a user's own file."""
    make: Any = namedtuple
    return make(name, fields, defaults=defaults)


@contextmanager
def user_code_errors(file: Path, what: str) -> Iterator[None]:
    """Turn any exception of the user's code into a sentence with file, line and advice."""
    try:
        yield
    except WorkbenchError:
        raise
    except SyntaxError as error:
        raise WorkbenchError(
            f"{error.filename}:{error.lineno}: is not valid Python, {error.msg}: correct this line"
        ) from None
    except (Exception, SystemExit) as error:
        frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == str(file)]
        line = f":{frames[-1].lineno}" if frames else ""
        doing = f"{what} fails: " if what else ""
        said = " ".join(str(error).split())
        raise WorkbenchError(
            f"{file}{line}: {doing}{type(error).__name__}: {said:.200}: {_advice_on(error)}"
        ) from None


@contextmanager
def locate_non_finite(file: Path, what: str) -> Iterator[None]:
    """Raise an error that names the line of a file which first makes a number not finite.

    NaN counts before infinity, which may be an intended bound. Without any, nothing is raised.

    Args:
        file: the user's.
        what: runs in the block.

    Raises:
        WorkbenchError: naming file, line and number.
    """
    found: dict[bool, str] = {}

    def note(line: int, name: str, value: float) -> None:
        said = f"{file}:{line}: {what} makes {name} {value:g}: let it be a finite number"
        found.setdefault(math.isnan(value), said)

    def trace(frame: types.FrameType, event: str, _: object) -> Trace | None:
        if frame.f_code.co_filename != str(file):
            return None
        known, line = _non_finite(frame.f_locals), frame.f_lineno

        def inside(frame: types.FrameType, event: str, result: object) -> Trace:
            nonlocal known, line
            there = _non_finite(frame.f_locals)
            for name, value in there.items():
                if name not in known or math.isnan(value) > math.isnan(known[name]):
                    note(line, name, value)
            known = there
            if event == "return":
                for value in _non_finite({"": result}).values():
                    note(frame.f_lineno, "its result", value)
            line = frame.f_lineno
            return inside

        return inside

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(before)
    for is_nan in (True, False):
        if is_nan in found:
            raise WorkbenchError(found[is_nan])


def _non_finite(values: Mapping[str, Any]) -> dict[str, float]:
    """Return of each value that is not finite the first number that is not."""
    first = {
        name: next((number for number in _numbers(value) if not math.isfinite(number)), None)
        for name, value in values.items()
    }
    return {name: number for name, number in first.items() if number is not None}


def _numbers(value: object) -> Iterator[float]:
    """Yield the numbers of a number, an array, or nested tuples and lists."""
    if isinstance(value, float):
        yield value
    elif isinstance(value, list | tuple):
        for each in value:
            yield from _numbers(each)
    elif hasattr(value, "tolist"):
        yield from _numbers(value.tolist())


def _advice_on(error: BaseException) -> str:
    """Return advice on what to write instead of a line that raises an error."""
    if isinstance(error, ImportError):
        if str(error.name).startswith("workbench."):
            return f"import what {error.name} names"
        return "install what is missing"
    if "AutoDiffXd" in str(error):
        return (
            "linear models take derivatives through it, which support only + - * / ** and "
            "comparisons: write the function with those"
        )
    if isinstance(error, AttributeError) and hasattr(error.obj, "_fields"):
        return f"it has {', '.join(error.obj._fields)}"
    return "correct this line"


@contextmanager
def limit_executed_lines(file: Path) -> Iterator[None]:
    """Stop the user's code after a number of lines: nothing else ends a loop in a thread."""
    left = MAX_EXECUTED_LINES

    def count(frame: types.FrameType, event: str, _: object) -> Trace | None:
        nonlocal left
        if frame.f_code.co_filename != str(file):
            return None
        if event == "line":
            left -= 1
            if left < 0:
                raise WorkbenchError(
                    f"{file}:{frame.f_lineno}: does not end: it has an endless loop"
                )
        return count

    before = sys.gettrace()
    sys.settrace(count)
    try:
        with limit_call_time(file, "it", MAX_LOADING_TIME_S):
            yield
    finally:
        sys.settrace(before)


@contextmanager
def limit_call_time(file: Path, what: str, most: float = 0.0) -> Iterator[None]:
    """Stop the user's code after a time [s], as when it waits for something.

    A signal does that, so only in the main thread, and only code that Python runs.

    Args:
        file: with the code.
        what: runs in the block, for the message.
        most: the time; 0 for `MAX_CALL_TIME_S`.
    """
    most = most or MAX_CALL_TIME_S
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, frame: types.FrameType | None) -> None:
        while frame and frame.f_code.co_filename != str(file):
            frame = frame.f_back
        where = f"{file}:{frame.f_lineno}" if frame else str(file)
        raise WorkbenchError(f"{where}: {what} has not returned for {most:g} s: let it end")

    handler = signal.signal(signal.SIGALRM, end)
    try:
        timer = signal.setitimer(signal.ITIMER_REAL, most, most)
    except signal.ItimerError:  # a held process may not: its caller limits its time
        signal.signal(signal.SIGALRM, handler)
        yield
        return
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, *timer)
        signal.signal(signal.SIGALRM, handler)
