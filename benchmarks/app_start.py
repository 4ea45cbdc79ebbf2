"""One start of the app, as its user does it; a process of its own, run by `app.py`.

`python app_start.py` prints, in seconds since the process began: when the window was painted, when
its first screen was, and when the first flight began; then it closes.
"""

import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy  # noqa: F401  the app needs it anyway; nothing else comes before its own imports

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ["XDG_CONFIG_HOME"] = tempfile.mkdtemp(prefix="app-start")  # nobody's settings


def age() -> float:
    """Return how long this process has lived [s]."""
    stat = Path("/proc/self/stat").read_text(encoding="ascii")
    began = int(stat.rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")
    return time.clock_gettime(time.CLOCK_BOOTTIME) - began


def main() -> None:
    """Start the app, and close it once it flies."""
    from PyQt6.QtCore import QTimer

    from workbench.commands.cli import main as workbench
    from workbench.gui import main_window

    seen: dict[str, float] = {}
    paint, begin = main_window.MainWindow.paintEvent, main_window.MainWindow._begin

    def painted(window, event):  # type: ignore[no-untyped-def]
        paint(window, event)
        if "window" not in seen:
            seen["window"] = age()
            window.workspace.flight.begun.connect(lambda view: ended(window))

    def first_screen(window):  # type: ignore[no-untyped-def]
        begin(window)
        seen.setdefault("screen", age())

    def ended(window) -> None:  # type: ignore[no-untyped-def]
        seen.setdefault("flight", age())
        QTimer.singleShot(500, window.close)

    main_window.MainWindow.paintEvent = painted
    main_window.MainWindow._begin = first_screen
    code = workbench(["gui", *sys.argv[1:]])
    seen["closed"] = age()
    print(json.dumps({"code": code, **seen}))


if __name__ == "__main__":
    main()
