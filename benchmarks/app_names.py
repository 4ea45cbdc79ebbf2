"""A frame of the app with hostile names, over one with plain names, in one run.

The real window runs offscreen at 1280 x 720 and shows a flight with sensors, sixty times a second.
Plain names take turns with those of `tests/hostile_names.py`: HTML, control characters, reordered
letters, a megabyte. They are the names of the vehicle, its parts and frames, of clients, of the
series of an open log, and in a notice. A frame is everything that the window's thread does between
two views of the flight; its time is processor time. Ends with 1 if a screen takes 10 % more.
"""

import os
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from PyQt6.QtCore import QSettings
from PyQt6.QtWidgets import QApplication
from spread import Spread, ratios, spread, text

from tests.gui.test_foreign_text import log_of, view_of
from tests.hostile_names import NAMES
from workbench.gui.app import delete_objects
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.style import apply_style
from workbench.gui.workspace import make_workspace
from workbench.link.backplane import Published
from workbench.live.messages import Pace, Phase
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action, Scenario, SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

PLAIN = tuple(f"name_{number}" for number in range(len(NAMES)))
PERIOD = 1.0 / 60.0
FRAMES, WARM_UP = 90, 30
TURNS = 6
MOST = 1.1
"""Largest ratio of the medians."""
SENSORS = ["imu", "gps", "lidar", "barometer", "range_finder", "magnetometer"]
Frame = tuple[LiveView, list[Published]]


@dataclass(frozen=True)
class NamesRow:
    """One screen.

    Attributes:
        screen: its name, and whether a log is open.
        plain: processor time of a frame with plain names, medians of the turns [ms].
        hostile: the same with hostile names [ms].
        ratio: of both, turn by turn.
    """

    screen: str
    plain: Spread
    hostile: Spread
    ratio: Spread


def fly() -> list[Frame]:
    """Return three seconds of a flight: views, and what was published until each."""
    script = [Action(at=1.0, velocity=[2.0, 0.0, 0.0])]
    scenario = Scenario(world="room", sensors=SensorsConfig(use=SENSORS), script=script)
    bridge = Bridge()
    session = Session(scenario, bridge=bridge)
    bridge.wanted = True
    begun = LiveView(
        phase=Phase.FLYING,
        said="",
        pace=Pace(1.0, 1.0, 0.0, 0.0, False),
        vehicle=session.vehicle,
        values=session.parameters(),
        scenario=scenario,
        topics=session.topics,
    )
    frames: list[Frame] = []
    for _ in range(FRAMES + WARM_UP):
        session.tick(PERIOD)
        published = [each.published for each in session.drain()]
        frames.append((replace(begun, snapshot=session.snapshot()), published))
    return frames


class Bench:
    """The window, and a flight that it shows again and again."""

    def __init__(self, application: QApplication) -> None:
        self.application = application
        self.frames = fly()
        store = QSettings(f"{tempfile.mkdtemp()}/settings.ini", QSettings.Format.IniFormat)
        self.workspace = make_workspace(Preferences(store))
        # nothing judges the flight: other processes would take turns on the processor
        self.workspace.analysis.ask = lambda question: None  # type: ignore[method-assign]
        self.workspace.analysis.warm_up = lambda: None  # type: ignore[method-assign]
        self.window = MainWindow(self.workspace, first="home", view3d=False)
        self.window.resize(1280, 720)
        apply_style(application, self.workspace.look)
        self.window.show()
        while self.window.stack.name != "home":
            application.processEvents()
        for row in SCREEN_TABLE:
            self.window.stack.screen_of(row.name)

    def turn(self, screen: str, names: tuple[str, ...], with_log: bool) -> float:
        """Return the median processor time of a frame [s]."""
        flight, charts = self.workspace.flight, self.window.stack.screen_of("visualization")
        views = [(view_of(view, names), published) for view, published in self.frames]
        self.window.show_screen(screen)
        flight._view = views[0][0]
        flight.begun.emit(views[0][0])
        self.workspace.notices.warn(names[0], names[1])
        if with_log:
            charts._show_log(log_of(names))
            charts.log_bar.clock.loops = True
            charts.log_bar.play.click()
        times = [self.frame(view, published) for view, published in views]
        if with_log:
            charts.close_log()
        self.window.banner.dismiss()
        return statistics.median(times[WARM_UP:])

    def frame(self, view: LiveView, published: list[Published]) -> float:
        """Show a view and return the processor time that it takes [s]."""
        due = time.perf_counter() + PERIOD
        begin = time.thread_time()
        flight = self.workspace.flight
        flight._view = view
        flight.streamed.emit(published)
        flight.viewed.emit(view)
        self.application.processEvents()
        while time.perf_counter() < due:
            self.application.processEvents()
            idle = time.thread_time()
            time.sleep(0.0005)
            begin += time.thread_time() - idle
        return time.thread_time() - begin

    def row(self, screen: str, with_log: bool = False) -> NamesRow:
        """Compare both kinds of names on a screen."""
        plain, hostile = [], []
        for turn in range(TURNS):
            first = turn * len(NAMES) // TURNS
            plain.append(1e3 * self.turn(screen, PLAIN, with_log))
            hostile.append(1e3 * self.turn(screen, NAMES[first:] + NAMES[:first], with_log))
        name = f"{screen}, a log" if with_log else screen
        return NamesRow(name, spread(plain), spread(hostile), ratios(hostile, plain))

    def close(self) -> None:
        """Close the window."""
        self.window.close()
        self.workspace.close()


def measure() -> list[NamesRow]:
    """Return a row for each screen."""
    application = QApplication(sys.argv[:1])
    bench = Bench(application)
    rows = [bench.row(row.name) for row in SCREEN_TABLE]
    rows.append(bench.row("visualization", with_log=True))
    bench.close()
    delete_objects()
    return rows


def show(rows: list[NamesRow]) -> None:
    """Print the table."""
    print("screen | plain, ms a frame | hostile, ms a frame | hostile over plain")
    for row in rows:
        print(f"{row.screen} | {text(row.plain)} | {text(row.hostile)} | {text(row.ratio)}")


if __name__ == "__main__":
    found = measure()
    show(found)
    sys.exit(any(row.ratio.median > MOST for row in found))
