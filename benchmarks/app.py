"""The speed of the app: frames, the flight beside it, slots, moving gains, and start-up.

The real window runs offscreen at 1280 x 720, with a flight with IMU, GPS, lidar, barometer and
range finder between obstacles; Visualization draws twelve curves. A slot is one event in the
window's thread, with everything that is painted in it; its processor time excludes other programs.
On the Tuning screen a gain is then moved a little, many times, until the flight has it for the next
control update; and moved continuously, to count the margins that follow.

Start-up is that of `workbench gui` in a fresh process.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported

from app_watchdog import WatchedApplication
from PyQt6.QtCore import QSettings
from spread import Spread, number, spread, text

from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREENS
from workbench.gui.style import apply_style
from workbench.gui.workspace import make_workspace
from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS
from workbench.live.choice import Choice

HERE = Path(__file__).parent
CHOICE = Choice(
    world="obstacle_field", sensors=("imu", "gps", "lidar", "barometer", "range_finder")
)
SECONDS = 8.0
"""Of each screen."""
SETTLING = 2.0
MOVES = 200
STARTS = 5
GAIN = "kp_velocity_x"


@dataclass(frozen=True)
class ScreenRow:
    """One screen while it is seen.

    Attributes:
        screen: its name.
        frames: painted a second.
        real_time_factor: of the flight beside it.
        slot_99: 99th percentile of events, wall time [ms].
        processor_99: the same of processor time [ms].
        slot_worst: the longest [ms].
        share: of a core that the app's process takes [%].
    """

    screen: str
    frames: float
    real_time_factor: float
    slot_99: float
    processor_99: float
    slot_worst: float
    share: float


@dataclass(frozen=True)
class GainRow:
    """A gain that moves.

    Attributes:
        moves: so many.
        effect: from a move until the flight has it, for the next control update, median [ms].
        effect_99: 99th percentile [ms].
        judged: margins of all loops a second while it moves all the time.
    """

    moves: int
    effect: float
    effect_99: float
    judged: float


@dataclass(frozen=True)
class StartRow:
    """`workbench gui` in a fresh process.

    Attributes:
        window: until it is painted [s].
        flight: until the first flight has begun [s].
    """

    window: Spread
    flight: Spread


class Bench:
    """The app, driven by turns of its event loop."""

    def __init__(self, application: WatchedApplication) -> None:
        self.application = application
        folder = tempfile.mkdtemp(prefix="app")
        store = QSettings(f"{folder}/settings.ini", QSettings.Format.IniFormat)
        self.workspace = make_workspace(Preferences(store))
        self.window = MainWindow(self.workspace, first="home", view3d=False)
        self.window.control.fly(CHOICE)
        apply_style(application, self.workspace.look)
        self.window.show()
        self.until(lambda: self.workspace.flight.is_flying, 60.0)
        for row in SCREENS:
            self.window.show_screen(row.name)
            self.run(0.3)

    def run(self, seconds: float) -> None:
        """Let the app live for a time [s]."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() >= end, seconds + 60.0)

    def until(self, reached: Callable[[], bool], limit: float) -> None:
        """Let the app live until something is so.

        Raises:
            TimeoutError: if it is not within a time [s].
        """
        end = time.monotonic() + limit
        while not reached():
            if time.monotonic() > end:
                raise TimeoutError
            self.application.processEvents()
            time.sleep(0.0005)

    def screen(self, name: str, seconds: float) -> ScreenRow:
        """Return how a screen does."""
        self.window.show_screen(name)
        self.run(SETTLING)
        flight = self.workspace.flight
        self.application.forget()
        wall, used, flown = time.perf_counter(), time.process_time(), flight.view.snapshot
        self.run(seconds)
        wall, used = time.perf_counter() - wall, time.process_time() - used
        now = flight.view.snapshot
        assert flown is not None and now is not None
        walls, processors = self.application.walls, self.application.processors
        return ScreenRow(
            screen=name,
            frames=self.application.frames / wall,
            real_time_factor=(now.time - flown.time) / wall,
            slot_99=1e3 * float(np.percentile(walls, 99)),
            processor_99=1e3 * float(np.percentile(processors, 99)),
            slot_worst=1e3 * max(walls),
            share=100.0 * used / wall,
        )

    def gains(self, moves: int) -> GainRow:
        """Return how a moved gain does."""
        self.window.show_screen("tuning")
        screen = self.window.stack.screen_of("tuning")
        gains = screen.gains  # type: ignore[union-attr]
        judged: list[object] = []
        self.workspace.analysis.judged.connect(judged.append)
        self.until(lambda: gains.has_fresh_ranges, 60.0)
        applied: list[int] = []
        self.workspace.flight.streamed.connect(lambda each: applied.extend(_set_at(each)))
        start, took = gains.flown[GAIN], []
        for move in range(moves):
            applied.clear()
            begun = time.time_ns()
            gains.propose(GAIN, start * (1.0 + 0.01 * (move % 2 + 1)))
            self.until(lambda: bool(applied), 10.0)
            took.append(1e-9 * (applied[0] - begun))
            self.run(0.25)
        judged.clear()
        begun = time.perf_counter()
        for move in range(300):
            gains.propose(GAIN, start * (1.0 + 0.001 * (move % 100)))
            self.run(0.01)
        rate = len(judged) / (time.perf_counter() - begun)
        low, high = np.percentile(took, [50, 99])
        return GainRow(moves, 1e3 * float(low), 1e3 * float(high), rate)

    def close(self) -> None:
        """End the app."""
        self.window.close()
        self.application.processEvents()


def measure(seconds: float = SECONDS, moves: int = MOVES, starts: int = STARTS) -> dict[str, list]:
    """Return the rows of all tables."""
    begun = [_start() for _ in range(starts)]
    bench = Bench(WatchedApplication(sys.argv[:1]))
    try:
        screens = [bench.screen(row.name, seconds) for row in SCREENS]
        gains = [bench.gains(moves)]
    finally:
        bench.close()
    windows, flights = zip(*begun, strict=True)
    return {
        "screens": screens,
        "gains": gains,
        "starts": [StartRow(spread(windows), spread(flights))],
    }


def _set_at(published: list[Published]) -> list[int]:
    """Return when the flight set parameters, by its own clock on the wall [ns]."""
    return [
        each.wall_ns for each in published for number, _ in each.payloads if number == PARAMETERS
    ]


def _start() -> tuple[float, float]:
    """Start the app once; return when its window was painted and when its flight began [s]."""
    command = [sys.executable, str(HERE / "app_start.py"), "--no-3d", "--screen", "home"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout.splitlines()[-1])
    return found["window"], found["flight"]


def show(rows: dict[str, list]) -> None:
    """Print the tables."""
    print(f"{'screen':14} {'frames/s':>9} {'RTF':>6} {'p99 [ms]':>9} {'of processor':>13} worst")
    for each in rows["screens"]:
        print(
            f"{each.screen:14} {each.frames:9.1f} {each.real_time_factor:6.3f} {each.slot_99:9.2f} "
            f"{each.processor_99:13.2f} {each.slot_worst:5.1f}  {each.share:.0f} % of a core"
        )
    for each in rows["gains"]:
        print(
            f"a gain moves: {each.effect:.1f} ms, p99 {each.effect_99:.1f} ms; margins "
            f"{number(each.judged)} times a second"
        )
    for each in rows["starts"]:
        print(f"start: window {text(each.window)} s, flight {text(each.flight)} s")


if __name__ == "__main__":
    show(measure())
