"""The whole app for half an hour: does the flight keep real time, and does any process grow?

The window with its 3-D view, a flight with all sensors between obstacles, flown round by the demo,
recording, and a server with its page. A user tunes all the time: between two looks a slider moves
for some seconds on the next page of the Tuning screen, then a fork is flown, and each sixth time
the flight is reset. Run it by hand: half an hour is too long for `make bench`.

Growth is the slope of a line through proportional set sizes (Linux counts a page that two processes
share as half a page of each), from the time on that is to settle.

To hold, where a core is free: a real-time factor of 0.98, and 5 MB a minute in all.

An hour without the 3-D view (`--minutes 60 --settle 10 --no-3d`), beside other load on both cores:
all processes together had 551 MB after 10 minutes, 588 after 20, 597 after 30, 611 after 50 and
606 at the end, and 670 for some minutes in between. The line through all of it rises by 1.2 MB a
minute, that from the 20th minute on by 0.5.

With `QT_QPA_PLATFORM=xcb` under Xvfb it has the window of a desktop without a graphics processor;
without that it is offscreen.
"""

import argparse
import math
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from host import Host

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported

from PyQt6.QtCore import QSettings
from PyQt6.QtWidgets import QApplication

from workbench.gui.app import DEMO_SCENARIO, DemoPilot, delete_objects, make_app
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.style import apply_style
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.gui.workspace import make_workspace
from workbench.link.server.config import ServerConfig
from workbench.live.choice import Choice
from workbench.live.orders import FlightOrder

CHOICE = Choice(DEMO_SCENARIO, world="obstacle_field", sensors=("all",))
BETWEEN = 10.0
"""Between two looks at the processes [s]."""
MOVED = 4.0
"""A slider moves for this long between two looks [s]."""
GAIN = "kp_velocity_x"
RESETS = 6
"""So many looks from one reset to the next."""
LEAST_FACTOR, MOST_GROWTH = 0.98, 5.0
ROLES = {
    "workbench.live.worker": "flight",
    "workbench.link.server.process": "server",
    "workbench.analysis": "analyst",
    "QtWebEngineProcess": "web engine",
}
"""What a process is, by a word of its command line."""


@dataclass
class Grown:
    """One process over time.

    Attributes:
        role: what it does.
        times: of the looks, since the start [s].
        sizes: proportional set size at these [MB].
        processor: time used at the first and the newest look [s].
    """

    role: str
    times: list[float] = field(default_factory=list)
    sizes: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)

    def slope(self, since: float) -> float:
        """Return growth from a time on [MB a minute]; of one that has ended there is none."""
        late = np.array(self.times) >= since
        if np.count_nonzero(late) < 3:
            return 0.0
        slope = np.polyfit(np.array(self.times)[late], np.array(self.sizes)[late], 1)[0]
        return 60.0 * float(slope)


class LongRun:
    """The app, driven by turns of its event loop."""

    def __init__(self, application: QApplication, view3d: bool) -> None:
        self._application = application
        self._folder = tempfile.TemporaryDirectory(prefix="app_long")
        preferences = Preferences(
            QSettings(f"{self._folder.name}/settings.ini", QSettings.Format.IniFormat)
        )
        preferences.set("log_folder", self._folder.name)
        self.workspace = make_workspace(preferences)
        self.workspace.notices.told.connect(lambda notice: print(f"  told: {notice.what}"))
        self.window = MainWindow(self.workspace, first="home", view3d=view3d)
        self.window.control.fly(CHOICE)
        apply_style(application, self.workspace.look)
        self.window.show()
        self._demo = DemoPilot(self.workspace.flight, self.workspace.notices, self.window)
        while not self.workspace.flight.is_flying:
            self.run(0.1)
        config = ServerConfig(port=0, web=True)
        self.workspace.flight.do(config)
        self.window.recorder.toggle()
        for row in SCREEN_TABLE:  # each starts what it needs
            self.window.show_screen(row.name)
            self.run(2.0)
        self.window.show_screen("visualization")
        self._looks = 0
        self._before = 0.0

    def tune(self, seconds: float) -> None:
        """Tune as a user does, for a time [s]."""
        end, self._looks = time.monotonic() + seconds, self._looks + 1
        self.window.show_screen("tuning")
        screen = self.window.stack.screen_of("tuning")
        assert isinstance(screen, TuningScreen)
        screen.tabs.setCurrentIndex(self._looks % screen.tabs.count())
        gains = screen.gains
        gains.begin_edit()
        until = time.monotonic() + MOVED
        while time.monotonic() < until:
            share = 0.2 * math.sin(3.0 * time.monotonic())
            gains.propose(GAIN, gains.kept[GAIN] * (1.0 + share))
            self.run(0.02)
        gains.end_edit()
        screen.fork.fork()
        self.run(2.0)
        if self._looks % RESETS == 0:
            begun, self._before = self.workspace.flight.view.flight, self.time
            self.workspace.flight.do(FlightOrder.RESET)
            while self.workspace.flight.view.flight == begun:
                self.run(0.01)
        self.window.show_screen("visualization")
        self.run(end - time.monotonic())

    def run(self, seconds: float) -> None:
        """Let the app live for a time [s]."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._application.processEvents()
            time.sleep(0.002)

    @property
    def time(self) -> float:
        """Simulated time of all flights [s]."""
        snapshot = self.workspace.flight.view.snapshot
        assert snapshot is not None
        return self._before + snapshot.time

    def close(self) -> None:
        """End the app."""
        self.window.close()
        self._application.processEvents()
        delete_objects()
        self._folder.cleanup()


def main() -> int:
    """Run, print, and return 1 where what is to hold does not."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=30.0, help="to measure")
    parser.add_argument("--settle", type=float, default=10.0, help="minutes of these to settle")
    parser.add_argument("--no-3d", action="store_true", help="without the 3-D view")
    arguments = parser.parse_args()
    run = LongRun(make_app(), not arguments.no_3d)
    processes: dict[int, Grown] = {}
    begun, settled = time.monotonic(), 60.0 * arguments.settle
    first: tuple[float, float] | None = None
    host = Host()
    while (now := time.monotonic() - begun) < 60.0 * arguments.minutes:
        if first is None and now >= settled:
            first = (now, run.time)
            host = Host()
        _look(processes, now)
        total = sum(each.sizes[-1] for each in processes.values() if each.times[-1] == now)
        print(f"{now / 60.0:5.1f} min  simulated {run.time:7.1f} s  {total:7.1f} MB", flush=True)
        run.tune(BETWEEN)
    wall, simulated = first or (0.0, 0.0)
    factor = (run.time - simulated) / (time.monotonic() - begun - wall)
    run.close()
    print(f"\nthe host took {host.stolen:.1f} % of the processors")
    return _tell(list(processes.values()), settled, factor)


def _look(processes: dict[int, Grown], now: float) -> None:
    """Take note of all processes of the app."""
    for pid in _family(os.getpid()):
        try:
            process = processes.setdefault(pid, Grown(_role(pid)))
            size, used = _size(pid), _processor(pid)
        except OSError:  # it has just ended
            continue
        process.times.append(now)
        process.sizes.append(size)
        process.processor = [*process.processor[:1], used]


def _tell(processes: list[Grown], settled: float, factor: float) -> int:
    """Print the table, and return the exit code."""
    print(f"\n{'process':12} {'MB at first':>12} {'at the end':>11} {'MB a minute':>12}  of a core")
    for each in processes:
        if each.sizes:
            span = max(each.times[-1] - each.times[0], 1e-9)
            share = 100.0 * (each.processor[-1] - each.processor[0]) / span
            print(
                f"{each.role:12} {each.sizes[0]:12.1f} {each.sizes[-1]:11.1f} "
                f"{each.slope(settled):12.2f}  {share:5.1f} %"
            )
    growth = sum(each.slope(settled) for each in processes)
    print(f"\nreal-time factor {factor:.3f}, to be at least {LEAST_FACTOR}")
    print(f"growth in all {growth:.2f} MB a minute, to be at most {MOST_GROWTH:g}")
    return int(factor < LEAST_FACTOR or growth > MOST_GROWTH)


def _family(pid: int) -> Iterator[int]:
    """Yield a process and all that it has started."""
    yield pid
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            children = task.read_text(encoding="ascii").split()
        except OSError:
            continue
        for child in children:
            yield from _family(int(child))


def _role(pid: int) -> str:
    command = Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8", errors="replace")
    return next((role for word, role in ROLES.items() if word in command), "window")


def _size(pid: int) -> float:
    """Return the proportional set size [MB]."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) / 1024.0 for line in lines if line.startswith("Pss:"))


def _processor(pid: int) -> float:
    """Return the processor time used [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    sys.exit(main())
