"""Game pads, by SDL: found as they are plugged in, read when asked; needs no window and no screen.

SDL is the extra `gamepad`; without it there is no pad, and `GamePads.missing` says what to install.
"""

import importlib
import warnings
from dataclasses import dataclass
from enum import Enum
from types import ModuleType
from typing import Any

from workbench.gui.joystick.piloting import Stick, Sticks, within_circle

INSTALL = "Game pads need PySDL2: pip install PySDL2 pysdl2-dll, then start again."
FULL = 32767.0
"""Of an axis."""
CREEP = 0.08
"""A resting stick of a pad is seldom quite in the middle: up to here it is taken as being there."""


class PadButton(Enum):
    """Buttons that mean something here, by what is asked; where they are, and SDL's name."""

    TAKE_OFF = ("take_off", "A, below", "SDL_CONTROLLER_BUTTON_A")
    LAND = ("land", "B, right", "SDL_CONTROLLER_BUTTON_B")
    HOLD = ("hold", "X, left", "SDL_CONTROLLER_BUTTON_X")
    STOP = ("stop", "Back", "SDL_CONTROLLER_BUTTON_BACK")

    @property
    def request(self) -> str:
        """What is asked of the flight mode."""
        return self.value[0]

    @property
    def words(self) -> str:
        """What is asked, as it is read."""
        return "stop the rotors" if self is PadButton.STOP else self.request.replace("_", " ")

    @property
    def place(self) -> str:
        """Which button it is, in words."""
        return self.value[1]


@dataclass(frozen=True)
class PadReading:
    """A pad at one time.

    Attributes:
        name: of the pad.
        sticks: where they are.
        pressed: buttons that have gone down since the last reading.
    """

    name: str
    sticks: Sticks
    pressed: tuple[PadButton, ...]


class GamePads:
    """The first game pad that is plugged in.

    Attributes:
        missing: what to install, "" where game pads can be read.
    """

    def __init__(self) -> None:
        self.missing = ""
        self._sdl: Any = None
        self._pad: Any = None
        self._name = ""
        self._down: frozenset[PadButton] = frozenset()

    def open(self) -> None:
        """Begin to look for pads."""
        if self._sdl is not None or self.missing:
            return
        try:
            sdl = _load()
        except ImportError:  # not there, or there without SDL's own library
            self.missing = INSTALL
            return
        # Ctrl-C stays Python's; a window of SDL's own, which it would wait for, there is none.
        sdl.SDL_SetHint(b"SDL_NO_SIGNAL_HANDLERS", b"1")
        sdl.SDL_SetHint(b"SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", b"1")
        if sdl.SDL_InitSubSystem(sdl.SDL_INIT_GAMECONTROLLER) != 0:
            said = sdl.SDL_GetError().decode(errors="replace")
            self.missing = f"Game pads cannot be read here: {said}."
            return
        self._sdl = sdl

    def read(self) -> PadReading | None:
        """Return how the pad is, None while none is plugged in."""
        sdl = self._sdl
        if sdl is None:
            return None
        sdl.SDL_GameControllerUpdate()
        sdl.SDL_FlushEvents(sdl.SDL_FIRSTEVENT, sdl.SDL_LASTEVENT)
        if self._pad is not None and not sdl.SDL_GameControllerGetAttached(self._pad):
            self._let_go()
        if self._pad is None and not self._find():
            return None
        down = frozenset(button for button in PadButton if self._is_down(button))
        pressed = tuple(button for button in PadButton if button in down - self._down)
        self._down = down
        return PadReading(self._name, self._sticks(), pressed)

    def close(self) -> None:
        """Let go of everything."""
        if self._sdl is not None:
            self._let_go()
            self._sdl.SDL_QuitSubSystem(self._sdl.SDL_INIT_GAMECONTROLLER)
            self._sdl = None

    def _find(self) -> bool:
        """Open the first pad that SDL knows how to read, if there is one."""
        sdl = self._sdl
        for index in range(sdl.SDL_NumJoysticks()):
            if sdl.SDL_IsGameController(index):
                pad = sdl.SDL_GameControllerOpen(index)
                if pad:
                    self._pad = pad
                    name = sdl.SDL_GameControllerName(pad) or b"game pad"
                    self._name = name.decode(errors="replace")
                    # What is held while it is plugged in is not pressed.
                    self._down = frozenset(each for each in PadButton if self._is_down(each))
                    return True
        return False

    def _let_go(self) -> None:
        if self._pad is not None:
            self._sdl.SDL_GameControllerClose(self._pad)
        self._pad, self._name, self._down = None, "", frozenset()

    def _is_down(self, button: PadButton) -> bool:
        number = getattr(self._sdl, button.value[2])
        return bool(self._sdl.SDL_GameControllerGetButton(self._pad, number))

    def _sticks(self) -> Sticks:
        sdl = self._sdl
        left = self._stick(sdl.SDL_CONTROLLER_AXIS_LEFTX, sdl.SDL_CONTROLLER_AXIS_LEFTY)
        right = self._stick(sdl.SDL_CONTROLLER_AXIS_RIGHTX, sdl.SDL_CONTROLLER_AXIS_RIGHTY)
        return Sticks(left, right)

    def _stick(self, across: int, along: int) -> Stick:
        x = self._sdl.SDL_GameControllerGetAxis(self._pad, across) / FULL
        y = -self._sdl.SDL_GameControllerGetAxis(self._pad, along) / FULL  # down is positive there
        return within_circle(x, y) if max(abs(x), abs(y)) > CREEP else Stick()


def _load() -> ModuleType:
    """Return SDL.

    Raises:
        ImportError: if it is not installed.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns of which library it has found
        return importlib.import_module("sdl2")
