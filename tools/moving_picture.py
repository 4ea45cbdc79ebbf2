"""Write docs/tour.webp, twenty seconds of the app: `python tools/moving_picture.py`.

The drone flies to two places; it is excited on the Tuning screen while a gain moves; Bode's plot
follows; charts show the flight.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from app_pictures import Photographer
from PIL import Image

from workbench.analysis.queries import Predict
from workbench.control.controller_file import load_controller
from workbench.control.mode import FlightMode
from workbench.gui.app import make_app
from workbench.gui.style import apply_style
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.scenario.scenario import Action

OUT = Path(__file__).resolve().parent.parent / "docs" / "tour.webp"
WINDOW_SIZE_PX = (1280, 720)
PICTURE_SIZE_PX = (960, 540)
FRAME_PERIOD_S = 0.2
QUALITY = 55
SETTLING_S = 2.0
"""Until the curves of a loop are there."""
MAX_BYTES = 3_000_000
PLACES = ([-1.5, 0.8, 1.8], [-2.0, -0.6, 1.4])
FACTORS = (0.9, 0.8, 0.7, 0.6, 0.5)
STEP_GAIN = "kp_velocity_x"
LOOP = load_controller().loop("pitch")
"""Its last gain, that of the rate, moves while Bode's plot of it is shown."""


class Film:
    """Frames of the app's window, at even times of the clock.

    Attributes:
        frames: so far.
        slow: how many show a flight slower than real time.
    """

    def __init__(self, photographer: Photographer) -> None:
        self.frames: list[Image.Image] = []
        self.slow = 0
        self._photographer = photographer

    def roll(self, seconds: float) -> None:
        """Let the app live for a time [s], and keep its frames."""
        for _ in range(round(seconds / FRAME_PERIOD_S)):
            self._photographer.run(FRAME_PERIOD_S)
            pace = self._photographer.workspace.flight.view.pace
            self.slow += pace is None or pace.slow
            frame = self._photographer.grab().convert("RGB")
            self.frames.append(frame.resize(PICTURE_SIZE_PX, Image.Resampling.LANCZOS))

    def write(self, path: Path) -> None:
        """Write them, over and over again."""
        first, *others = self.frames
        first.save(
            path,
            save_all=True,
            append_images=others,
            duration=round(1e3 * FRAME_PERIOD_S),
            loop=0,
            quality=QUALITY,
            method=6,
        )


def fly(photographer: Photographer, film: Film) -> None:
    """Fly, excite, move a gain, look at the loop and at the signals."""
    window, flight = photographer.window, photographer.workspace.flight
    tuning = window.stack.screen_of("tuning")
    for place in PLACES:
        flight.do(Action(go_to=[*place]))
        film.roll(2.4)
    flight.do(Action(request="hold"))
    answers = []
    photographer.workspace.analysis.answered.connect(lambda question, _: answers.append(question))
    window.show_screen("tuning")
    photographer.until(lambda: any(isinstance(each, Predict) for each in answers))
    photographer.until(lambda: flight.view.snapshot.mode is FlightMode.HOVERING)
    film.roll(0.8)
    tuning.excitation.button.click()
    film.roll(3.6)
    move_gain(film, tuning, STEP_GAIN, FACTORS)
    film.roll(2.4)
    tuning.excitation.button.click()
    tuning.tabs.setCurrentWidget(tuning.frequency)
    tuning.frequency.show_view("Bode")
    tuning.frequency.choose_loop(LOOP.name)
    photographer.run(SETTLING_S)
    film.roll(0.8)
    move_gain(film, tuning, LOOP.gains[-1], FACTORS)
    film.roll(1.0)
    window.show_screen("visualization")
    film.roll(2.6)


def move_gain(film: Film, tuning: TuningScreen, gain: str, factors: Sequence[float]) -> None:
    """Move a gain's slider from its flown value by these factors."""
    begun = tuning.gains.flown[gain]
    for factor in factors:
        tuning.gains.propose(gain, factor * begun)
        film.roll(0.4)


def main() -> int:
    """Film and write."""
    application = make_app()
    photographer = Photographer(application)
    try:
        photographer.workspace.preferences.set("theme", "light")
        apply_style(application, photographer.workspace.look)
        photographer.window.resize(*WINDOW_SIZE_PX)
        photographer.window.show_screen("home")
        photographer.run(2.0)
        photographer.show_calm(paused=False)
        film = Film(photographer)
        fly(photographer, film)
    finally:
        photographer.close()
    film.write(OUT)
    size, seconds = OUT.stat().st_size, FRAME_PERIOD_S * len(film.frames)
    print(f"{OUT}: {seconds:.0f} s, {size // 1000} kB, {film.slow} frames slower than real time")
    return int(size > MAX_BYTES or film.slow > 0)


if __name__ == "__main__":
    sys.exit(main())
