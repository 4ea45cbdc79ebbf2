"""A process of our own beside this one: how it is started, and why it ended.

It is a fresh interpreter: Drake's threads and compiled code do not survive a fork, and
multiprocessing would run the caller's main file again. It is no member of the terminal's
foreground group, so that Ctrl-C reaches the caller alone, who closes the flight.
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path

from workbench.common.errors import LONGEST_ECHO, WorkbenchError

LONGEST_TAIL = 4 * LONGEST_ECHO
"""Of what a process said last, a sentence repeats so many characters."""
DYING = 5.0
"""Time that a process has to be gone once its end of the connection is [s]."""


class ChildProcess:
    """A process and the connection to it.

    Args:
        module: that runs there, as `python -m MODULE FD`, a socket to this process.
        name: of what it does, for messages.

    Raises:
        WorkbenchError: if no process can be started.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name
        root = str(Path(__file__).resolve().parents[2])
        paths = [root, *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
        try:
            self.connection, other = Pipe()

            self._noise = tempfile.TemporaryFile()  # noqa: SIM115
        except OSError as error:
            raise WorkbenchError(f"no process can be started for the {name}: {error}") from error
        try:
            self._process = self._start(other, paths)
        except OSError as error:
            self.connection.close()
            self._noise.close()
            raise WorkbenchError(f"no process can be started for the {name}: {error}") from error
        finally:
            other.close()  # so that the connection ends when the worker does

    def _start(self, other: Connection, paths: list[str]) -> subprocess.Popen[bytes]:
        fd = other.fileno()
        return subprocess.Popen(
            # -P: a file json.py in the user's folder is not to be imported
            [sys.executable, "-P", "-m", self._module, str(fd)],
            stdin=subprocess.DEVNULL,
            stdout=self._noise,
            stderr=self._noise,
            pass_fds=[fd],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in paths if path)},
            process_group=0,
        )

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid

    def end(self, limit: float) -> bool:
        """Wait for it to end, and kill it after a time [s]; return whether it ended by itself."""
        try:
            self._process.wait(limit)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            return False
        return True

    def cause(self) -> str:
        """Say why it ended; it must be about to, and is killed otherwise."""
        self.end(DYING)
        code = self._process.returncode
        if code == -signal.SIGKILL:
            return f"the {self._name}'s process was killed: by somebody, or as memory ran out"
        if code < 0:
            said = f"the {self._name}'s process crashed ({signal.strsignal(-code) or -code})"
        else:
            said = f"the {self._name}'s process ended with {code}"
        last = self._last_words()
        return f"{said}: {last}" if last else said

    def release(self) -> None:
        """Let go of what belongs to it."""
        self.connection.close()
        self._noise.close()

    def _last_words(self) -> str:
        """Return the last line that it printed, short."""
        with contextlib.suppress(OSError, ValueError):  # ValueError: closed
            self._noise.seek(max(0, self._noise.seek(0, os.SEEK_END) - 4 * LONGEST_TAIL))
            text = self._noise.read().decode(errors="replace").strip()
            return text.rpartition("\n")[2][:LONGEST_TAIL]
        return ""
