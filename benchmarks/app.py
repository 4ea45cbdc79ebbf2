"""The speed of the app: frames, the flight beside it, slots, moving gains, and start-up.

The real window runs offscreen at 1280 x 720, with a flight with IMU, GPS, lidar, barometer and
range finder that the demo flies round between obstacles, so alarms come and go. Home has the map of
the GPS. Visualization draws twelve curves, then 48 in eight charts, then a chart of every kind. A
slot is one event in the window's thread, with everything that is painted in it; its processor time
excludes other programs. A frame is a painting of the widget that is painted most often.

On the Tuning screen a gain is moved a little, many times; each time the benchmark waits until the
flight has it for the next control update. Then a slider moves a hundred times a second, with each
page of the screen open in turn; sliders, response and margins are always visible.

If the machine has a graphics processor, the 3-D view is open beside every screen. These figures are
from a machine without one. Other programs ran at the same time, and the app had priority over
them.

Start-up is that of `workbench gui` in a fresh process.
"""

import dataclasses
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported

from app_watchdog import WatchedApplication
from PyQt6.QtCore import QSettings
from spread import Spread, number, spread, text

from workbench.analysis.queries import DrawFrequency, Judge, Predict, Query
from workbench.gui.app import DemoPilot, delete_objects
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.style import apply_style
from workbench.gui.tuning.frequency_card import LOOP_VIEWS
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.gui.view3d.web_engine import RENDER_NODES, can_use_gpu
from workbench.gui.visualization.layouts import LAYOUT_PRESETS, ChartLayout, ChartSpec
from workbench.gui.workspace import make_workspace
from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS_SIGNAL
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
MOVED = 6.0
"""A slider moves while each page of the Tuning screen is open [s]."""
BETWEEN = 0.01
"""Between two of its moves [s]."""
SIX = tuple(f"{each}.v_{axis}" for each in ("velocity_data", "command_velocity") for axis in "xyz")
LAYOUTS = {
    "48 curves": tuple(ChartSpec(f"Chart {number}", SIX) for number in range(1, 9)),
    "every kind": tuple(
        LAYOUT_PRESETS[name][number]
        for name in ("Flight", "Spectra", "Path", "Steps")
        for number in range(2)
    ),
}
"""What Visualization draws, besides its first layout."""


@dataclass(frozen=True)
class ScreenRow:
    """One screen while it is seen.

    Attributes:
        screen: name, and what it draws if that is not its first layout.
        frames: painted a second.
        real_time_factor: real-time factor of the flight.
        slot_99: 99th percentile of events, wall time [ms].
        processor_99: the same in processor time [ms].
        slot_worst: the longest event [ms].
        share: share of a core that the app's process takes [%].
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
        moves: number of moves.
        effect: time from a move until the flight has it for the next control update, median [ms].
        effect_99: the same, 99th percentile [ms].
    """

    moves: int
    effect: float
    effect_99: float


@dataclass(frozen=True)
class PageRow:
    """One page of the Tuning screen while a slider moves.

    Attributes:
        page: name, and the view of Frequency.
        frames: painted a second.
        real_time_factor: real-time factor of the flight.
        slot_99: 99th percentile of events, wall time [ms].
        slot_worst: the longest event [ms].
        judged: margins of all loops a second.
        predicted: predicted responses a second.
        drawn: frequency curves a second, if the page has any.
    """

    page: str
    frames: float
    real_time_factor: float
    slot_99: float
    slot_worst: float
    judged: float
    predicted: float
    drawn: float


@dataclass(frozen=True)
class StartRow:
    """`workbench gui` in a fresh process.

    Attributes:
        window: time until the window is painted [s].
        flight: time until the first flight has started [s].
    """

    window: Spread
    flight: Spread


class Bench:
    """The app, driven by turns of its event loop."""

    def __init__(self, application: WatchedApplication) -> None:
        self.application = application
        self._moves = 0
        folder = tempfile.mkdtemp(prefix="app")
        store = QSettings(f"{folder}/settings.ini", QSettings.Format.IniFormat)
        self.workspace = make_workspace(Preferences(store))
        draws = can_use_gpu(RENDER_NODES.glob("renderD*"))
        self.window = MainWindow(self.workspace, first="home", view3d=draws)
        self.window.control.fly(CHOICE)
        apply_style(application, self.workspace.look)
        self.window.show()
        self.until(lambda: self.workspace.flight.is_flying, 60.0)
        DemoPilot(self.workspace.flight, self.workspace.notices, self.window)
        for row in SCREEN_TABLE:
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

    def screen(self, name: str, layout: str = "") -> ScreenRow:
        """Return how a screen does, with a layout of `LAYOUTS`."""
        self.window.show_screen(name)
        if layout:
            shown = self.window.stack.screen_of(name)
            shown.charts.show_layout(ChartLayout(charts=LAYOUTS[layout]))  # type: ignore[union-attr]
        self.run(SETTLING)
        used = time.process_time()
        wall, factor = self.watch(lambda: self.run(SECONDS))
        used = time.process_time() - used
        walls, processors = self.application.walls, self.application.processors
        return ScreenRow(
            screen=f"{name}, {layout}" if layout else name,
            frames=self.application.frames / wall,
            real_time_factor=factor,
            slot_99=1e3 * float(np.percentile(walls, 99)),
            processor_99=1e3 * float(np.percentile(processors, 99)),
            slot_worst=1e3 * max(walls),
            share=100.0 * used / wall,
        )

    def watch(self, live: Callable[[], object]) -> tuple[float, float]:
        """Count events while the app lives; return how long it did [s], and the flight's factor."""
        flight = self.workspace.flight
        self.application.forget()
        wall, flown = time.perf_counter(), flight.view.snapshot
        live()
        wall, now = time.perf_counter() - wall, flight.view.snapshot
        assert flown is not None and now is not None
        return wall, (now.time - flown.time) / wall

    def gains(self) -> GainRow:
        """Return how a moved gain does."""
        self.window.show_screen("tuning")
        gains = self.tuning.gains
        self.until(lambda: gains.has_fresh_ranges, 60.0)
        applied: list[int] = []
        self.workspace.flight.streamed.connect(lambda each: applied.extend(_set_at(each)))
        start, took = gains.flown[GAIN], []
        for move in range(MOVES):
            applied.clear()
            begun = time.time_ns()
            gains.propose(GAIN, start * (1.0 + 0.01 * (move % 2 + 1)))
            self.until(lambda: bool(applied), 10.0)
            took.append(1e-9 * (applied[0] - begun))
            self.run(0.25)
        low, high = np.percentile(took, [50, 99])
        return GainRow(MOVES, 1e3 * float(low), 1e3 * float(high))

    def pages(self) -> Iterator[PageRow]:
        """Yield how each page of the Tuning screen does while a slider moves."""
        self.window.show_screen("tuning")
        frequency, tabs = self.tuning.frequency, self.tuning.tabs
        for view in LOOP_VIEWS:
            tabs.setCurrentWidget(frequency)
            frequency.show_view(view)
            yield self._page(f"{tabs.tabText(tabs.currentIndex())}: {view}")
        for index in range(tabs.count()):
            if tabs.widget(index) is not frequency:
                tabs.setCurrentIndex(index)
                yield self._page(tabs.tabText(index))

    def _page(self, name: str) -> PageRow:
        """Return how the open page does."""
        gains, analysis = self.tuning.gains, self.workspace.analysis
        start = gains.kept[GAIN]
        counts: Counter[type[Query]] = Counter()

        def count_answer(question: Query, _: object) -> None:
            counts[type(question)] += 1

        def move() -> None:
            for step in range(round(MOVED / BETWEEN)):
                self._moves += 1  # another value each time: what is known is not asked again
                gains.propose(GAIN, start * (1.0 + 0.001 * (step % 100) + 1e-8 * self._moves))
                self.run(BETWEEN)

        self.run(SETTLING)
        analysis.answered.connect(count_answer)
        wall, factor = self.watch(move)
        analysis.answered.disconnect(count_answer)
        walls = self.application.walls
        judged, predicted, drawn = (counts[kind] / wall for kind in (Judge, Predict, DrawFrequency))
        return PageRow(
            page=name,
            frames=self.application.frames / wall,
            real_time_factor=factor,
            slot_99=1e3 * float(np.percentile(walls, 99)),
            slot_worst=1e3 * max(walls),
            judged=judged,
            predicted=predicted,
            drawn=drawn or math.nan,
        )

    @property
    def tuning(self) -> TuningScreen:
        """The Tuning screen."""
        screen = self.window.stack.screen_of("tuning")
        assert isinstance(screen, TuningScreen)
        return screen

    def close(self) -> None:
        """End the app."""
        self.window.close()
        self.application.processEvents()
        delete_objects()


def measure() -> dict[str, list]:
    """Return the rows of all tables."""
    begun = [_start() for _ in range(STARTS)]
    bench = Bench(WatchedApplication(sys.argv[:1]))
    try:
        gains = [bench.gains()]
        pages = list(bench.pages())
        screens = [bench.screen(row.name) for row in SCREEN_TABLE]
        screens += [bench.screen("visualization", layout) for layout in LAYOUTS]
    finally:
        bench.close()
    windows, flights = zip(*begun, strict=True)
    return {
        "screens": screens,
        "gains": gains,
        "pages": pages,
        "starts": [StartRow(spread(windows), spread(flights))],
    }


def _set_at(published: list[Published]) -> list[int]:
    """Return when the flight set parameters, by its own clock on the wall [ns]."""
    return [
        each.wall_ns
        for each in published
        for number, _ in each.payloads
        if number == PARAMETERS_SIGNAL.id
    ]


def _start() -> tuple[float, float]:
    """Start the app once; return when its window was painted and when its flight began [s]."""
    command = [sys.executable, str(HERE / "app_start.py"), "--no-3d", "--screen", "home"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout.splitlines()[-1])
    return found["window"], found["flight"]


def show(rows: dict[str, list]) -> None:
    """Print the tables."""
    print(f"{'screen':25} {'frames/s':>9} {'RTF':>6} {'p99 [ms]':>9} {'of processor':>13} worst")
    for each in rows["screens"]:
        print(
            f"{each.screen:25} {each.frames:9.1f} {each.real_time_factor:6.3f} {each.slot_99:9.2f} "
            f"{each.processor_99:13.2f} {each.slot_worst:5.1f}  {each.share:.0f} % of a core"
        )
    for each in rows["gains"]:
        print(f"a gain moves: {each.effect:.1f} ms, p99 {each.effect_99:.1f} ms")
    heads = ("frames/s", "RTF", "p99 [ms]", "worst", "margins/s", "steps/s", "curves/s")
    print(f"{'page while a slider moves':25} {' '.join(f'{each:>9}' for each in heads)}")
    for each in rows["pages"]:
        name, *numbers = dataclasses.astuple(each)
        print(f"{name:25} {' '.join(f'{number(value):>9}' for value in numbers)}")
    for each in rows["starts"]:
        print(f"start: window {text(each.window)} s, flight {text(each.flight)} s")


if __name__ == "__main__":
    show(measure())
