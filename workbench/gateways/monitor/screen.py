"""The full screen in a terminal, with curses; it is drawn completely each time, without flicker."""

import curses
import locale
import time

from workbench.common.plain_text import LONGEST_TEXT, plain_name
from workbench.gateways.monitor.dashboard import dashboard
from workbench.gateways.monitor.picture import Camera
from workbench.gateways.monitor.pilot import Pilot

PERIOD = 0.05
"""Period between checks of the keys [s]."""
FRAME = 0.1
"""Period between pictures [s]."""

NAMES = {
    curses.KEY_UP: "up",
    curses.KEY_DOWN: "down",
    curses.KEY_LEFT: "left",
    curses.KEY_RIGHT: "right",
    ord(" "): "space",
    ord("="): "+",  # where + is on the same key
}
HELP = (
    "C      take control, or give it back: the drone then holds its position",
    "W S    ahead and back, along the heading        A D    to the left and right",
    "up down  climb and sink                         left right  turn",
    "+ -    faster, slower      space  hold          T      take off     L  land",
    "X      stop the rotors at once, wherever the drone is",
    "A terminal does not report that a key is released: a key counts for 0.3 s, then fades in 0.3 "
    "s.",
)
SHORT_WATCHING = "C take control   ? help   Q quit"
SHORT_FLYING = (
    "? help  Q quit  C release  WASD arrows fly at {speed:g} m/s (+-), a key counts 0.3 s  "
    "space hold  T L X"
)


def show(camera: Camera, pilot: Pilot) -> None:
    """Show a flight, and fly it by keys, until Q is pressed.

    Args:
        camera: takes the pictures.
        pilot: handles the keys.
    """
    locale.setlocale(locale.LC_CTYPE, "")
    try:
        curses.wrapper(lambda window: _Screen(window, camera, pilot).run())
    finally:
        pilot.release()


def is_capable() -> bool:
    """Return whether this terminal can move its cursor."""
    try:
        curses.setupterm()
    except curses.error:
        return False
    return curses.tigetstr("cup") is not None


def can_show(text: str, encoding: str) -> bool:
    """Return whether the encoding of a terminal has all characters of a text."""
    try:
        text.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return False
    return True


class _Screen:
    """The window of the terminal."""

    def __init__(self, window: "curses.window", camera: Camera, pilot: Pilot) -> None:
        self._window = window
        self._camera = camera
        self._pilot = pilot
        self._helping = False
        blocks = can_show("\u2588\u00b7", window.encoding)
        self._full, self._empty = ("\u2588", "\u00b7") if blocks else ("#", ".")

    def run(self) -> None:
        """Handle keys and draw until Q is pressed."""
        if curses.tigetstr("civis"):
            curses.curs_set(0)
        self._window.timeout(round(1000.0 * PERIOD))
        drawn = 0.0
        while self._keys():
            self._pilot.tick()
            if time.monotonic() - drawn >= FRAME:
                drawn = time.monotonic()
                self._draw()

    def _keys(self) -> bool:
        """Handle the pressed keys; return whether to go on."""
        wait = True
        while True:
            code = self._window.getch()
            if wait:  # only for the first one
                self._window.timeout(0)
                wait = False
            if code == curses.ERR:
                self._window.timeout(round(1000.0 * PERIOD))
                return True
            key = NAMES.get(code, chr(code).lower() if code < 128 else "")
            if key == "q":
                return False
            if key == "?":
                self._helping = not self._helping
            elif key:
                self._pilot.key(key)

    def _draw(self) -> None:
        height, width = self._window.getmaxyx()
        lines = dashboard(self._camera.picture(), self._full, self._empty)
        foot = [self._pilot.said, self._short()]
        if self._helping:
            foot = [*HELP, "", *foot]
        # If the window is too small, the middle is cut: messages and keys stay.
        lines = [*lines[: max(height - len(foot) - 1, 0)], "", *foot]
        self._window.erase()
        for at, line in enumerate(lines[-height:]):
            style = curses.A_BOLD if at == 0 or line == self._pilot.said else curses.A_NORMAL
            # The last column stays free: a character there would scroll the last line.
            shown = plain_name(line, LONGEST_TEXT)
            self._window.addnstr(at, 0, shown, max(width - 1, 0), style)
        self._window.refresh()

    def _short(self) -> str:
        if self._pilot.flying:
            return SHORT_FLYING.format(speed=self._pilot.speed)
        return SHORT_WATCHING
