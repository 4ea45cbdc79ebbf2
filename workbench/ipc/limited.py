"""Processes untrusted data in a child process with limits on time, memory, output and access.

The parent calls `run_limited`; the module that it names calls `serve_one_request` when it runs. The
kernel holds the child to reading the files named for it, see `sandbox`. `run_trusted` is for code
of ours or of the user, which may also start programs.
"""

import ctypes
import errno
import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import IO, Any

from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import last_line, start_module
from workbench.ipc.sandbox import confine
from workbench.ipc.system_call import SandboxError

MAX_CHILD_FILE_BYTES = 128_000_000
"""Largest file that the process may write, its answer included [bytes]."""
_FULL_DEVICE_ERRORS = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT}
"""Errors of a full device, or of a limit that acts like one."""
_WALL_TIME_FACTOR, _START_ALLOWANCE_S = 3.0, 10.0
"""Limit of wall time as a multiple of the computing time, plus a time to start [s], as machines are
shared."""
_MAX_CAUSE_CHARS = 300
_SET_DEATH_SIGNAL = 1
"""Number of `PR_SET_PDEATHSIG`, see prctl(2)."""
_THREAD_VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
"""Numbers of threads that libraries start at import: Landlock binds only its caller's thread."""
FORBIDDEN_CLAUSE = "it tried to do more than read its own files"
"""Beginning of the clause about a process that the kernel stopped."""


class LimitedError(WorkbenchError):
    """Tells why a process gave no answer, in a clause that names no file."""


def run_limited(
    module: str,
    request: object,
    *,
    seconds: float,
    megabytes: int,
    reads: Iterable[Path | str] = (),
    writes: Iterable[Path | str] = (),
) -> Any:
    """Run `python -m MODULE` on a request and return its answer, within limits of the kernel.

    The function of the module starts no process, has no network, and opens only the files named
    here and those of Python.

    Args:
        module: full name of a module that calls `serve_one_request`.
        request: argument of its function; anything that JSON can hold.
        seconds: limit of computing time; wall time has a larger limit.
        megabytes: limit of address space.
        reads: files that it may read, and folders with all that is below them.
        writes: folders in which it may also make, change and delete files.

    Returns:
        The function's result, after a round trip through JSON.

    Raises:
        LimitedError: if it exceeded a limit, died, or raised an exception other than
            WorkbenchError.
        WorkbenchError: the function's own.
    """
    bounds = {"reads": [str(path) for path in reads], "writes": [str(path) for path in writes]}
    return _answer(module, request, seconds, megabytes, bounds)


def run_trusted(module: str, request: object, *, seconds: float, megabytes: int) -> Any:
    """Run code of ours or of the user as `run_limited` does, with access to all files."""
    return _answer(module, request, seconds, megabytes, None)


def _answer(
    module: str,
    request: object,
    seconds: float,
    megabytes: int,
    bounds: dict[str, list[str]] | None,
) -> Any:
    """Return the answer to a request; `bounds` are the arguments of `confine`."""
    try:
        message = json.dumps(
            {
                "caller": os.getpid(),
                "seconds": seconds,
                "megabytes": megabytes,
                "bounds": bounds,
                "request": request,
            }
        )
        with (
            tempfile.TemporaryFile() as given,  # files: of limited size, and never blocking
            tempfile.TemporaryFile() as answer,
            tempfile.TemporaryFile() as noise,
        ):
            given.write(message.encode())
            given.seek(0)
            wall = _WALL_TIME_FACTOR * seconds + _START_ALLOWANCE_S
            code = _run(module, given, answer, noise, wall)
            if code is None:
                raise LimitedError(f"it did not end within {wall:g} s")
            if code != 0:
                raise LimitedError(_cause(code, seconds, noise))
            answer.seek(0)
            said = json.loads(answer.read(MAX_CHILD_FILE_BYTES + 1))
    except OSError as error:
        if error.errno in _FULL_DEVICE_ERRORS:
            raise LimitedError(
                f"a file in {tempfile.gettempdir()} cannot be written: {error.strerror}: make room "
                "there, or set TMPDIR to another folder"
            ) from error
        raise LimitedError(f"no process can be started for it: {error}") from error
    except (ValueError, RecursionError) as error:
        raise LimitedError(f"the answer cannot be read: {one_line_message(error)}") from error
    match said:
        case {"answer": value}:
            return value
        case {"refused": str(sentence)}:
            raise WorkbenchError(sentence)
        case {"error": reason}:
            raise LimitedError(str(reason))
    raise LimitedError("the answer is empty")


def _run(
    module: str, given: IO[bytes], answer: IO[bytes], noise: IO[bytes], wall: float
) -> int | None:
    """Return the exit code: negative for a signal, None if the time was up."""
    process = start_module(
        module,
        stdin=given,
        stdout=answer,
        stderr=noise,
        start_new_session=True,
        env=dict.fromkeys(_THREAD_VARIABLES, "1"),
    )
    # A thread, because `wait(timeout)` polls only every 50 ms.
    timer = threading.Timer(wall, _kill, (process,))
    end = time.monotonic() + wall
    timer.start()
    try:
        code = process.wait()
    finally:  # on Ctrl-C, too
        timer.cancel()
        _kill(process)
        process.wait()
    return None if code == -signal.SIGKILL and time.monotonic() >= end else code


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a running process and its children."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)


def _cause(code: int, seconds: float, noise: IO[bytes]) -> str:
    """Return why a process ended without an answer."""
    if code == -signal.SIGXCPU:
        return f"it took more than {seconds:g} s"
    if code == -signal.SIGKILL:
        return "its process was killed: it took too much time or memory"
    if code < 0:
        return f"its process crashed ({signal.strsignal(-code) or -code})"
    return f"its process ended with {code}: {last_line(noise, _MAX_CAUSE_CHARS)}"


def serve_one_request(function: Callable[[Any], Any]) -> None:
    """Answer the request on standard input with the result of a function.

    Output of libraries goes to standard error.
    """
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    message = json.loads(sys.stdin.buffer.read())
    _end_with(message["caller"])
    seconds, megabytes = math.ceil(message["seconds"]), message["megabytes"]
    _limit(resource.RLIMIT_CORE, 0, 0)
    _limit(resource.RLIMIT_CPU, seconds, seconds + 1)
    if sys.platform == "linux":  # macOS refuses such a limit
        _limit(resource.RLIMIT_AS, megabytes * 1_000_000, megabytes * 1_000_000)
    _limit(resource.RLIMIT_FSIZE, MAX_CHILD_FILE_BYTES, MAX_CHILD_FILE_BYTES)
    try:
        if message["bounds"] is not None:
            confine(**message["bounds"])
        text = json.dumps({"answer": function(message["request"])})
        if len(text) > MAX_CHILD_FILE_BYTES:
            text = json.dumps(
                {"error": f"it came to more than {MAX_CHILD_FILE_BYTES // 1_000_000} MB"}
            )
    except WorkbenchError as error:
        text = json.dumps({"refused": str(error)})
    except MemoryError:
        text = json.dumps({"error": f"it took more than {megabytes} MB of memory"})
    except RecursionError:
        text = json.dumps({"error": "it is nested too deeply"})
    except SandboxError as error:
        text = json.dumps(
            {"error": f"the kernel does not bound its process: {one_line_message(error)}"}
        )
    except PermissionError as error:
        text = json.dumps({"error": f"{FORBIDDEN_CLAUSE}: {one_line_message(error)}"})
    except Exception as error:
        text = json.dumps({"error": one_line_message(error)})
    with answer:
        answer.write(text.encode())


def _end_with(caller: int) -> None:
    """Let the kernel end this process when its caller ends, however that does; Linux can."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, ctypes.c_ulong(signal.SIGKILL))
    if os.getppid() != caller:  # it has ended already
        os._exit(1)


def _limit(what: int, soft: int, hard: int) -> None:
    """Set a limit, unless a stricter one is already set."""
    most = resource.getrlimit(what)[1]
    if most != resource.RLIM_INFINITY:
        soft, hard = min(soft, most), min(hard, most)
    resource.setrlimit(what, (soft, hard))


def one_line_message(error: BaseException) -> str:
    """Return an exception's message, short and in one line; its type if the message is empty."""
    text = " ".join(str(error)[: 10 * _MAX_CAUSE_CHARS].split())
    short = text if len(text) <= _MAX_CAUSE_CHARS else f"{text[:_MAX_CAUSE_CHARS]}..."
    return short or type(error).__name__
