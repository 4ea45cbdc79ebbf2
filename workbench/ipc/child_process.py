"""A child process and the connection to it: start, end, and the reason for its end.

The child is a fresh interpreter: Drake's threads and compiled code do not survive a fork, and
multiprocessing would run the caller's main file again. It is not in the terminal's foreground
process group, so Ctrl-C reaches only the caller, which then ends the child.
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError

MAX_LAST_LINE_CHARS = 4 * MAX_ECHO_CHARS
"""Largest number of characters of a process's last line that a message repeats."""
CHILD_EXIT_TIMEOUT_S = 5.0
"""Time limit for a process to exit after it closed its end of the connection [s]."""


def start_module(
    module: str, *arguments: str, env: Mapping[str, str] | None = None, **options: Any
) -> subprocess.Popen[bytes]:
    """Start `python -m MODULE ARGUMENTS` with the workbench of this process on its path.

    Args:
        module: full name of the module.
        arguments: command-line arguments.
        env: environment variables to set for it.
        options: keyword arguments of `subprocess.Popen`.

    Raises:
        OSError: if the process cannot be started.
    """
    root = str(Path(__file__).resolve().parents[2])
    paths = [root, *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    return subprocess.Popen(
        # -P: do not import a file such as json.py from the user's folder
        [sys.executable, "-P", "-m", "workbench.ipc.entry", module, *arguments],
        # numpy's threads wait busily for each other where several processes share the cores
        env={"OPENBLAS_NUM_THREADS": "1"}
        | os.environ
        | {"PYTHONPATH": os.pathsep.join(path for path in paths if path)}
        | dict(env or {}),
        **options,
    )


def last_line(output: IO[bytes], longest: int) -> str:
    """Return the last line that a process printed to a file, at most `longest` characters."""
    output.seek(max(0, output.seek(0, os.SEEK_END) - 4 * longest))
    text = output.read().decode(errors="replace").strip()
    return text.rpartition("\n")[2][:longest]


def _temporary_file(name: str) -> IO[bytes]:
    """Return a file for what a process prints; WorkbenchError if none can be made."""
    try:
        return tempfile.TemporaryFile()
    except OSError as error:
        raise WorkbenchError(
            f"no temporary file can be made for the {name}: {error.strerror or error}: make room, "
            "or set TMPDIR to another folder"
        ) from error


class ChildProcess:
    """Starts and ends a child process, and tells why it ended.

    Attributes:
        connection: connection to the child, a `multiprocessing.connection.Connection` over a
            socket. An event loop can watch its file descriptor (see `Channel`), and a thread can
            call `send` and `recv`; when the process ends, `recv` raises EOFError or OSError.

    Args:
        module: module to run as `python -m MODULE FD`, where FD is the other end of the connection.
        name: name for messages: "the NAME's process crashed".

    Raises:
        WorkbenchError: if the process cannot be started.
    """

    def __init__(self, module: str, name: str) -> None:
        from multiprocessing import Pipe  # slow to load, and not always needed

        self.name = name
        with contextlib.ExitStack() as opened:
            try:
                self.connection, other = Pipe()
                opened.callback(self.connection.close)
                self._output = _temporary_file(name)
                opened.callback(self._output.close)
                with other:  # so that the connection ends with the process
                    self._process = start_module(
                        module,
                        str(other.fileno()),
                        stdin=subprocess.DEVNULL,
                        stdout=self._output,
                        stderr=self._output,
                        pass_fds=[other.fileno()],
                        process_group=0,
                    )
            except OSError as error:
                raise WorkbenchError(
                    f"no process can be started for the {name}: {error}"
                ) from error
            opened.pop_all()

    @property
    def pid(self) -> int:
        """Process ID."""
        return self._process.pid

    def end(self, limit: float) -> bool:
        """Wait for its end for a time [s], then kill it; return whether it ended by itself."""
        try:
            self._process.wait(limit)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return False
        return True

    def cause(self) -> str:
        """Return why it ended, as a sentence; kill it if it does not exit within
        `CHILD_EXIT_TIMEOUT_S`.
        """
        self.end(CHILD_EXIT_TIMEOUT_S)
        code = self._process.returncode
        if code == -signal.SIGKILL:
            return f"the {self.name}'s process was killed: by somebody, or because memory ran out"
        if code < 0:
            said = f"the {self.name}'s process crashed ({signal.strsignal(-code) or -code})"
        else:
            said = f"the {self.name}'s process ended with {code}"
        with contextlib.suppress(OSError, ValueError):  # ValueError: `release` closed the file
            if last := last_line(self._output, MAX_LAST_LINE_CHARS):
                return f"{said}: {last}"
        return said

    def release(self) -> None:
        """Close the connection and its output file; must be the last call."""
        self.connection.close()
        self._output.close()
