"""Game pads, by SDL: detected when plugged in, and polled; works without a window or screen.

SDL is the optional extra `gamepad`; without it there are no pads, and `GamePads.missing` says what
to install.
"""

import importlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from types import ModuleType
from typing import Any

from workbench.gui.joystick.pad_mapping import AXES, PadMapping, Raw
from workbench.gui.joystick.piloting import Sticks

INSTALL = "Game pads need PySDL2: pip install PySDL2 pysdl2-dll, then start again."
FULL = 32767.0
"""Full deflection of an axis."""
START = "SDL_CONTROLLER_BUTTON_START"
"""Button with which a pad takes over from another one."""


class PadButton(Enum):
    """Buttons with a function: the request, the button's position, and SDL's name."""

    TAKE_OFF = ("take_off", "A, below", "SDL_CONTROLLER_BUTTON_A")
    LAND = ("land", "B, right", "SDL_CONTROLLER_BUTTON_B")
    HOLD = ("hold", "X, left", "SDL_CONTROLLER_BUTTON_X")
    STOP = ("stop", "Back", "SDL_CONTROLLER_BUTTON_BACK")

    @property
    def request(self) -> str:
        """The request to the flight mode."""
        return self.value[0]

    @property
    def words(self) -> str:
        """The request in words."""
        return "stop the rotors" if self is PadButton.STOP else self.request.replace("_", " ")

    @property
    def place(self) -> str:
        """The button's position, in words."""
        return self.value[1]


@dataclass(frozen=True)
class PadReading:
    """A pad at one time.

    Attributes:
        name: name of the pad.
        sticks: positions of the sticks.
        pressed: buttons pressed since the last reading.
        number: SDL's number of this pad while it is plugged in.
        guid: SDL's GUID of its model; the mapping is stored under it.
        raw: its axes, -1 .. 1.
        asks: whether Start was pressed: it asks to fly.
    """

    name: str
    sticks: Sticks
    pressed: tuple[PadButton, ...]
    number: int = -1
    guid: str = ""
    raw: Raw = (0.0,) * len(AXES)
    asks: bool = False


@dataclass
class _OpenPad:
    """A plugged-in pad; `down` has the pressed buttons, by SDL's names."""

    handle: Any
    name: str
    guid: str
    down: frozenset[str] = field(default_factory=frozenset)


class GamePads:
    """The plugged-in game pads, one of which flies.

    The first one flies. Another one takes over on request, but never because one is unplugged.

    Args:
        mapping: returns the mapping of a pad's axes, by its GUID.

    Attributes:
        missing: what to install, "" if game pads can be read.
        readings: last readings of all pads.
        flying: number of the pad that flies, None without one.
    """

    def __init__(self, mapping: Callable[[str], PadMapping] = lambda guid: PadMapping()) -> None:
        self.missing = ""
        self.readings: tuple[PadReading, ...] = ()
        self.flying: int | None = None
        self._mapping = mapping
        self._sdl: Any = None
        self._pads: dict[int, _OpenPad] = {}

    def open(self) -> None:
        """Start to look for pads."""
        if self._sdl is not None or self.missing:
            return
        try:
            sdl = _load()
        except ImportError:  # not installed, or installed without SDL's own library
            self.missing = INSTALL
            return
        # Leave Ctrl-C to Python; SDL needs no window of its own here.
        sdl.SDL_SetHint(b"SDL_NO_SIGNAL_HANDLERS", b"1")
        sdl.SDL_SetHint(b"SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", b"1")
        if sdl.SDL_InitSubSystem(sdl.SDL_INIT_GAMECONTROLLER) != 0:
            said = sdl.SDL_GetError().decode(errors="replace")
            self.missing = f"Game pads cannot be read here: {said}."
            return
        self._sdl = sdl

    def read(self) -> PadReading | None:
        """Read all pads, and return the reading of the one that flies, None without one."""
        sdl = self._sdl
        if sdl is None:
            return None
        sdl.SDL_GameControllerUpdate()
        sdl.SDL_FlushEvents(sdl.SDL_FIRSTEVENT, sdl.SDL_LASTEVENT)
        for number, pad in tuple(self._pads.items()):
            if not sdl.SDL_GameControllerGetAttached(pad.handle):
                self._let_go(number)
        self._find()
        self.readings = tuple(self._look(number, pad) for number, pad in self._pads.items())
        return next((each for each in self.readings if each.number == self.flying), None)

    def fly(self, number: int) -> None:
        """Let another pad fly from the next reading on."""
        if number in self._pads:
            self.flying = number

    def close(self) -> None:
        """Close all pads and SDL."""
        if self._sdl is not None:
            for number in tuple(self._pads):
                self._let_go(number)
            self._sdl.SDL_QuitSubSystem(self._sdl.SDL_INIT_GAMECONTROLLER)
            self._sdl = None
            self.readings = ()

    def _find(self) -> None:
        """Open newly plugged-in pads; the first of them flies, if it is alone."""
        sdl, were_none = self._sdl, not self._pads
        for index in range(sdl.SDL_NumJoysticks()):
            number = sdl.SDL_JoystickGetDeviceInstanceID(index)
            if number in self._pads or not sdl.SDL_IsGameController(index):
                continue
            handle = sdl.SDL_GameControllerOpen(index)
            if handle:
                name = sdl.SDL_GameControllerName(handle) or b"game pad"
                guid = bytes(sdl.SDL_JoystickGetDeviceGUID(index).data).hex()
                pad = _OpenPad(handle, name.decode(errors="replace"), guid)
                pad.down = self._down(pad)  # buttons held while plugging in do not count as pressed
                self._pads[number] = pad
        if were_none and self._pads:
            self.flying = next(iter(self._pads))

    def _let_go(self, number: int) -> None:
        self._sdl.SDL_GameControllerClose(self._pads.pop(number).handle)
        if number == self.flying:
            self.flying = None

    def _look(self, number: int, pad: _OpenPad) -> PadReading:
        sdl, down = self._sdl, self._down(pad)
        new, pad.down = down - pad.down, down
        raw = tuple(
            max(-1.0, sdl.SDL_GameControllerGetAxis(pad.handle, axis) / FULL)
            for axis in range(len(AXES))
        )
        pressed = tuple(button for button in PadButton if button.value[2] in new)
        sticks = self._mapping(pad.guid).sticks(raw)
        return PadReading(pad.name, sticks, pressed, number, pad.guid, raw, START in new)

    def _down(self, pad: _OpenPad) -> frozenset[str]:
        names = (*(button.value[2] for button in PadButton), START)
        pressed = self._sdl.SDL_GameControllerGetButton
        return frozenset(each for each in names if pressed(pad.handle, getattr(self._sdl, each)))


def _load() -> ModuleType:
    """Return SDL.

    Raises:
        ImportError: if it is not installed.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # prints a warning about the library that it found
        return importlib.import_module("sdl2")
