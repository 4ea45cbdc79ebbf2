"""A child process and the connection to it: how it is started, ended, and why it ended.

It is a fresh interpreter: Drake's threads and compiled code do not survive a fork, and
multiprocessing would run the caller's main file again. It is not in the terminal's foreground
group, so Ctrl-C reaches the caller alone, who ends the child.
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import IO, Any

from workbench.common.errors import LONGEST_ECHO, WorkbenchError

LONGEST_TAIL = 4 * LONGEST_ECHO
"""Characters of a process's last line that a sentence repeats."""
DYING = 5.0
"""Time in which a process must end once it has closed its end of the connection [s]."""


def start_module(module: str, *arguments: str, **options: Any) -> subprocess.Popen[bytes]:
    """Start `python -m MODULE ARGUMENTS` with the workbench of this process on its path.

    Args:
        module: full name of the module.
        arguments: its command line.
        options: of `subprocess.Popen`.

    Raises:
        OSError: if no process can be started.
    """
    root = str(Path(__file__).resolve().parents[2])
    paths = [root, *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    return subprocess.Popen(
        # -P: a file json.py in the user's folder is not to be imported
        [sys.executable, "-P", "-m", module, *arguments],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in paths if path)},
        **options,
    )


def last_line(output: IO[bytes], longest: int) -> str:
    """Return the last line that a process printed into a file, so many characters at most."""
    output.seek(max(0, output.seek(0, os.SEEK_END) - 4 * longest))
    text = output.read().decode(errors="replace").strip()
    return text.rpartition("\n")[2][:longest]


class ChildProcess:
    """Owns a process of this machine: starts it, ends it, and says why it ended.

    Attributes:
        connection: to it, a `multiprocessing.connection.Connection` over a socket. Its file
            descriptor serves an event loop (see `Channel`), `send` and `recv` serve a thread; at
            the process's end, `recv` raises EOFError or OSError.

    Args:
        module: runs there as `python -m MODULE FD`, where FD is the other end of the connection.
        name: what it is, for messages: "the NAME's process crashed".

    Raises:
        WorkbenchError: if no process can be started.
    """

    def __init__(self, module: str, name: str) -> None:
        from multiprocessing import Pipe  # slow to load, and most who import this start none

        self.name = name
        with contextlib.ExitStack() as opened:
            try:
                self.connection, other = Pipe()
                opened.callback(self.connection.close)
                self._output = tempfile.TemporaryFile()  # noqa: SIM115
                opened.callback(self._output.close)
                with other:  # so that the connection ends when the process does
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
        """Return why it ended, a sentence; it is killed if it does not end within `DYING`."""
        self.end(DYING)
        code = self._process.returncode
        if code == -signal.SIGKILL:
            return f"the {self.name}'s process was killed: by somebody, or as memory ran out"
        if code < 0:
            said = f"the {self.name}'s process crashed ({signal.strsignal(-code) or -code})"
        else:
            said = f"the {self.name}'s process ended with {code}"
        with contextlib.suppress(OSError, ValueError):  # ValueError: `release` closed the file
            if last := last_line(self._output, LONGEST_TAIL):
                return f"{said}: {last}"
        return said

    def release(self) -> None:
        """Close the connection and the file of its output; the last call."""
        self.connection.close()
        self._output.close()
