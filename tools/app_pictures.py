"""Write pictures of every screen of the app: `python tools/app_pictures.py [FOLDER]`.

Each screen, light and dark, at 1280 x 720 and, as a 4K desktop shows it, at 3840 x 2160, before a
real flight, into FOLDER (default out/screens). With `--docs` it writes those of README and
docs/app.md instead.
"""

import argparse
import io
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")  # before Qt is imported

from PIL import Image
from PyQt6.QtCore import QBuffer, QSettings
from PyQt6.QtWidgets import QApplication

from workbench.commands.cli import main as run_command
from workbench.control.mode import FlightMode
from workbench.extras.flightdata.cards import DRAW_COUNTS, WHAT_IF
from workbench.extras.flightdata.flying_again_question import FlyAgain
from workbench.gui.app import make_app
from workbench.gui.main_window import MIN_WINDOW_SIZE_PX, MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.style import apply_style
from workbench.gui.workspace import make_workspace
from workbench.link import Client
from workbench.link.server.config import ServerConfig
from workbench.live.choice import Choice
from workbench.scenario.scenario import Action

ROOT = Path(__file__).resolve().parent.parent
SMALL, LARGE = (1280, 720), (1920, 1080)
"""Of the window; the large one with two points a pixel, as a 4K desktop has it."""
THEMES = ("light", "dark")
COLOURS = 256
CHOICE = Choice(
    world="obstacle_field",
    sensors=("imu", "gps", "lidar", "barometer", "range_finder"),
)
POINTS = """
title: points
script:
  - {at: 0.1, set: {wind_x: 2.0, turbulence: 3.0}}
  - {at: 0.2, go_to: [1.0, 0.0, 1.5]}
  - {at: 3.0, go_to: [1.0, 1.0, 2.0]}
  - {at: 6.0, go_to: [0.0, 0.0, 1.5]}

duration: 9.0
"""
"""A scenario whose log is flown again."""
LONG = 120.0
"""For a slow machine [s]."""


@dataclass(frozen=True)
class Shot:
    """A picture for the docs: its file, screen and theme.

    `prepare` is called before, and the window has `size`.
    """

    file: str
    screen: str
    theme: str
    prepare: Callable[["Photographer"], None] = lambda _: None
    size: tuple[int, int] = SMALL


class Photographer:
    """The app, brought to a state that is worth a picture."""

    def __init__(self, application: QApplication) -> None:
        self._application = application
        self._stack = ExitStack()
        self._folder = tempfile.TemporaryDirectory(prefix="app-pictures")
        store = QSettings(f"{self._folder.name}/kept.ini", QSettings.Format.IniFormat)
        self.workspace = make_workspace(Preferences(store))
        self.window = MainWindow(self.workspace, first="home", view3d=False)
        self.window.control.fly(CHOICE)
        apply_style(application, self.workspace.look)
        self.window.show()
        self.until(lambda: self.workspace.flight.is_flying)

    def run(self, seconds: float) -> None:
        """Let the app live for a time [s]."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end)

    def until(self, so: Callable[[], bool], else_said: str = "") -> None:
        """Let the app live until something is so.

        Raises:
            SystemExit: with a sentence, if it is not so within a long time.
        """
        end = time.monotonic() + LONG
        while not so():
            if time.monotonic() > end:
                raise SystemExit(else_said or f"The app did not get ready within {LONG:g} s.")
            self._application.processEvents()
            time.sleep(0.002)

    def fly(self, seconds: float) -> None:
        """Let the app live for a time of the flight [s], however slow the machine is."""
        flight = self.workspace.flight
        end = flight.view.snapshot.time + seconds
        self.until(lambda: flight.view.snapshot.time >= end)

    def prepare(self) -> None:
        """Fly some way, be watched, try a gain, and excite the drone."""
        flight = self.workspace.flight
        flight.do(ServerConfig(port=0))
        self.until(lambda: flight.view.network.server is not None)
        self._watch(flight.view.network.server.address)
        for place in ([-1.5, 0.8, 1.8], [-2.0, -0.6, 1.4], [-1.0, 0.0, 1.5]):
            flight.do(Action(go_to=[*place]))
            self.fly(3.5)
        flight.do(Action(request="hold"))
        self.window.show_screen("tuning")
        tuning = self.window.stack.screen_of("tuning")
        self.until(lambda: bool(tuning.gains.flown))
        self.until(lambda: self.workspace.flight.view.snapshot.mode is FlightMode.HOVERING)
        self.fly(2.0)
        tuning.excitation.button.click()
        self.until(lambda: tuning.response.history.numbers is not None)
        tuning.gains.propose("kp_velocity_x", 0.7 * tuning.gains.flown["kp_velocity_x"])
        self.fly(3.5)
        self.until(lambda: tuning.gains.has_fresh_ranges)
        tuning.excitation.button.click()
        self.until(lambda: flight.view.exciting is None)

    def _watch(self, address: str) -> None:
        """Let two clients watch, as on an afternoon in the laboratory."""
        for name in ("ground station", "logger"):
            client = Client(address, name=name)
            self._stack.enter_context(client)
            threading.Thread(target=lambda each=client: [None for _ in each], daemon=True).start()

    def take(self, screen: str, theme: str, size: tuple[int, int]) -> Image.Image:
        """Return a picture of a screen."""
        self.workspace.preferences.set("theme", theme)
        self.window.resize(*size)
        self.window.show_screen(screen)
        self.run(1.5)
        start = self.window.stack.screen_of("start")
        self.until(lambda: not start.sketches.is_waiting)
        self.show_calm()
        return self.grab()

    def grab(self) -> Image.Image:
        """Return a picture of the window as it is."""
        buffer = QBuffer()
        buffer.open(QBuffer.OpenModeFlag.WriteOnly)
        self.window.grab().save(buffer, "PNG")
        return Image.open(io.BytesIO(bytes(buffer.data())))

    def show_calm(self) -> None:
        """Wait until the flight keeps real time, and dismiss all notices."""
        flight, banner = self.workspace.flight, self.window.banner
        slow = "The machine is too busy for pictures: flights are slower than real time."
        self.until(lambda: flight.view.pace and not flight.view.pace.too_slow, slow)
        while banner.shown is not None:
            banner.dismiss()
        self.run(0.3)

    def show_phases(self) -> None:
        """Put the table of phases in front, and a filter on."""
        tuning = self.window.stack.screen_of("tuning")
        tuning.gains.propose("gyro_lowpass", 40.0)
        tuning.tabs.setCurrentWidget(tuning.frequency)
        tuning.frequency.show_view("Phase")

    def show_what_if(self) -> None:
        """Fly from point to point, open the log of that, and fly it again with less gain."""
        folder = Path(self._folder.name)
        scenario, log = folder / "points.yaml", folder / "points.mcap"
        scenario.write_text(POINTS)
        made = ["--log", str(log), "--no-plots", "--output", str(folder)]
        run_command(["fly", str(scenario), *made])
        self.window.resize(*MIN_WINDOW_SIZE_PX)
        self.workspace.log.open(log)
        self.workspace.log.card_wanted.emit(WHAT_IF.title)
        tuning = self.window.stack.screen_of("tuning")
        answers = []
        self.workspace.analysis.answered.connect(lambda question, _: answers.append(question))
        tuning.gains.propose("kp_velocity_x", 0.4 * tuning.gains.flown["kp_velocity_x"])
        self.until(
            lambda: any(isinstance(a, FlyAgain) and a.draws == max(DRAW_COUNTS) for a in answers)
        )

    def close(self) -> None:
        """End the app."""
        self._stack.close()
        self.window.close()
        self._folder.cleanup()


DOCS = (
    *(
        Shot(f"app-{row.name}.png", row.name, "light")
        for row in SCREEN_TABLE
        if row.name != "start"  # which no page shows
    ),
    Shot("app-tuning-dark.png", "tuning", "dark", Photographer.show_phases),
    Shot("app-what-if.png", "tuning", "light", Photographer.show_what_if, MIN_WINDOW_SIZE_PX),
)


def main() -> None:
    """Take all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out/screens"))
    parser.add_argument("--docs", action="store_true", help="write docs/app*.png")
    parser.add_argument("--large", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    photographer = Photographer(make_app())
    try:
        photographer.prepare()
        if arguments.docs:
            take_for_docs(photographer)
        else:
            take_all(photographer, arguments.folder, LARGE if arguments.large else SMALL)
    finally:
        photographer.close()
    if not arguments.docs and not arguments.large:
        environment = os.environ | {"QT_SCALE_FACTOR": "2"}  # read when Qt starts
        command = [sys.executable, __file__, str(arguments.folder), "--large"]
        subprocess.run(command, env=environment, check=True)


def take_for_docs(photographer: Photographer) -> None:
    """Write the pictures of README and docs."""
    for shot in DOCS:
        shot.prepare(photographer)
        picture = photographer.take(shot.screen, shot.theme, shot.size)
        path = ROOT / "docs" / shot.file
        picture.convert("RGB").quantize(COLOURS).save(path, optimize=True)
        print(path.name)


def take_all(photographer: Photographer, folder: Path, size: tuple[int, int]) -> None:
    """Write pictures of all screens."""
    folder.mkdir(parents=True, exist_ok=True)
    for theme in THEMES:
        for row in SCREEN_TABLE:
            picture = photographer.take(row.name, theme, size)
            path = folder / f"{row.name}-{theme}-{picture.width}x{picture.height}.png"
            picture.save(path)
            print(path)


if __name__ == "__main__":
    main()
