"""Run as `python -m workbench.autopilots.keeper FD`: owns a program that knows nothing of us.

A firmware reads no connection, so it cannot see that its caller has gone. This process does, and
ends it then, however the caller ended. It starts what it is told, one after the other, and says how
each ended.
"""

import contextlib
import ctypes
import subprocess
import sys
import threading
from multiprocessing.connection import Connection
from pathlib import Path

SLACK = 29
"""Of Linux's prctl: by how much the system may be late with a sleep, which children inherit."""


def sleep_exactly() -> None:
    """Let programs that are started sleep as short as they ask, and not 50 us longer.

    Betaflight's scheduler sleeps 50 us between looks at what is due every 125 us. Late ones leave
    no time for anything but the control loop: its receiver then hears no sticks.
    """
    with contextlib.suppress(AttributeError, OSError):  # there is none on other systems
        ctypes.CDLL(None).prctl(SLACK, 1000, 0, 0, 0)


def keep(connection: Connection) -> None:
    """Start programs until the connection ends.

    Each message is a command line, a working folder, and a file for what the program prints, or
    None to end what runs. Answers are its process ID, and once it has ended its exit code.
    """
    running: list[subprocess.Popen[bytes]] = []
    try:
        while True:
            told = connection.recv()
            if told is None:
                running[-1].kill()
                continue
            command, folder, output = told
            with Path(output).open("wb") as printed:
                child = subprocess.Popen(
                    command,
                    cwd=folder,
                    stdin=subprocess.DEVNULL,
                    stdout=printed,
                    stderr=subprocess.STDOUT,
                )
            running.append(child)
            connection.send(child.pid)
            threading.Thread(target=_tell_end, args=(child, connection), daemon=True).start()
    except (EOFError, OSError):  # the caller has gone, or the program cannot be started
        for child in running:
            child.kill()


def _tell_end(child: "subprocess.Popen[bytes]", connection: Connection) -> None:
    code = child.wait()
    with contextlib.suppress(OSError):  # nobody listens any more
        connection.send(code)


if __name__ == "__main__":
    sleep_exactly()
    keep(Connection(int(sys.argv[1])))
