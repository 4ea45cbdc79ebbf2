"""Run as a module with the number of a connection: owns a program that cannot detect our end.

A firmware has no connection that shows the end of its caller. This process has one, and then ends
the firmware, whatever ended the caller. It starts programs one after the other, and reports how
each ended.
"""

import contextlib
import ctypes
import subprocess
import sys
import threading
from multiprocessing.connection import Connection
from pathlib import Path

PR_SET_TIMERSLACK = 29
"""Option of Linux's prctl for the largest delay of a sleep, which children inherit."""


def remove_timer_slack() -> None:
    """Let started programs sleep exactly as long as requested, and not 50 us longer.

    Betaflight's scheduler sleeps 50 us between checks for tasks that are due every 125 us. Late
    wake-ups leave no time for anything but the control loop: its receiver then ignores sticks.
    """
    with contextlib.suppress(AttributeError, OSError):  # missing on other systems
        ctypes.CDLL(None).prctl(PR_SET_TIMERSLACK, 1000, 0, 0, 0)


def start_programs(connection: Connection) -> None:
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
            threading.Thread(target=_report_exit, args=(child, connection), daemon=True).start()
    except (EOFError, OSError):  # the caller has ended, or the program cannot be started
        for child in running:
            child.kill()


def _report_exit(child: "subprocess.Popen[bytes]", connection: Connection) -> None:
    code = child.wait()
    with contextlib.suppress(OSError):  # nobody listens
        connection.send(code)


if __name__ == "__main__":
    remove_timer_slack()
    start_programs(Connection(int(sys.argv[1])))
