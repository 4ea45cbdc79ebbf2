"""Game pads, by SDL: detected when plugged in, and polled; works without a window or screen.

SDL is the optional extra `gamepad`; without it there are no pads, and `GamePads.missing` says what
to install.
"""

import ctypes.util
import importlib
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from types import ModuleType
from typing import Any

from workbench.gui.joystick.pad_mapping import (
    DEFAULT_PAD_MAPPING,
    PAD_AXIS_NAMES,
    PadMapping,
    RawPadAxes,
    mapped_sticks,
)
from workbench.gui.joystick.piloting import Sticks

SDL_MISSING_TEXT = "Game pads need PySDL2: pip install PySDL2 pysdl2-dll, then start again."
FULL_AXIS_VALUE = 32767.0
"""Full deflection of an axis."""
TAKE_OVER_BUTTON = "SDL_CONTROLLER_BUTTON_START"
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
        down: names of the buttons that are down, as SDL's.
    """

    name: str
    sticks: Sticks
    pressed: tuple[PadButton, ...]
    number: int = -1
    guid: str = ""
    raw: RawPadAxes = (0.0,) * len(PAD_AXIS_NAMES)
    asks: bool = False
    down: frozenset[str] = frozenset()


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

    def __init__(
        self, mapping: Callable[[str], PadMapping] = lambda guid: DEFAULT_PAD_MAPPING
    ) -> None:
        self.missing = ""
        self.readings: tuple[PadReading, ...] = ()
        self.flying: int | None = None
        self._mapping = mapping
        self._sdl: Any = None
        self._handles: dict[int, Any] = {}  # SDL's handle of each pad, by its number

    def open(self) -> None:
        """Start to look for pads."""
        if self._sdl is not None or self.missing:
            return
        try:
            sdl = _import_sdl()
        except ImportError:  # not installed, or installed without SDL's own library
            self.missing = SDL_MISSING_TEXT
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
        for number, handle in tuple(self._handles.items()):
            if not sdl.SDL_GameControllerGetAttached(handle):
                self._let_go(number)
        before = {reading.number: reading.down for reading in self.readings}
        self._open_new_pads()
        self.readings = tuple(
            self._look(number, handle, before.get(number))
            for number, handle in self._handles.items()
        )
        return next((each for each in self.readings if each.number == self.flying), None)

    def fly(self, number: int) -> None:
        """Let another pad fly from the next reading on."""
        if number in self._handles:
            self.flying = number

    def close(self) -> None:
        """Close all pads and SDL."""
        if self._sdl is not None:
            for number in tuple(self._handles):
                self._let_go(number)
            self._sdl.SDL_QuitSubSystem(self._sdl.SDL_INIT_GAMECONTROLLER)
            self._sdl = None
            self.readings = ()

    def _open_new_pads(self) -> None:
        """Open newly plugged-in pads; the first of them flies, if it is alone."""
        sdl, were_none = self._sdl, not self._handles
        for index in range(sdl.SDL_NumJoysticks()):
            number = sdl.SDL_JoystickGetDeviceInstanceID(index)
            if number not in self._handles and sdl.SDL_IsGameController(index):
                handle = sdl.SDL_GameControllerOpen(index)
                if handle:
                    self._handles[number] = handle
        if were_none and self._handles:
            self.flying = next(iter(self._handles))

    def _let_go(self, number: int) -> None:
        self._sdl.SDL_GameControllerClose(self._handles.pop(number))
        if number == self.flying:
            self.flying = None

    def _look(self, number: int, handle: Any, before: frozenset[str] | None) -> PadReading:
        """Return the reading of a pad; buttons held while it is plugged in were not pressed."""
        sdl = self._sdl
        buttons = (*(button.value[2] for button in PadButton), TAKE_OVER_BUTTON)
        down = frozenset(
            name for name in buttons if sdl.SDL_GameControllerGetButton(handle, getattr(sdl, name))
        )
        new = down - (down if before is None else before)
        raw = tuple(
            max(-1.0, sdl.SDL_GameControllerGetAxis(handle, axis) / FULL_AXIS_VALUE)
            for axis in range(len(PAD_AXIS_NAMES))
        )
        joystick = sdl.SDL_GameControllerGetJoystick(handle)
        guid = bytes(sdl.SDL_JoystickGetGUID(joystick).data).hex()
        return PadReading(
            name=(sdl.SDL_GameControllerName(handle) or b"game pad").decode(errors="replace"),
            sticks=mapped_sticks(self._mapping(guid), raw),
            pressed=tuple(button for button in PadButton if button.value[2] in new),
            number=number,
            guid=guid,
            raw=raw,
            asks=TAKE_OVER_BUTTON in new,
            down=down,
        )


def _import_sdl() -> ModuleType:
    """Return SDL.

    Raises:
        ImportError: if it is not installed.
    """
    search = ctypes.util.find_library
    if sys.platform == "linux":
        ctypes.util.find_library = _find_library
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # prints a warning about the library that it found
            return importlib.import_module("sdl2")
    finally:
        ctypes.util.find_library = search


def _find_library(name: str) -> str | None:
    """Return the file name of a library that the loader finds.

    The standard search starts ldconfig, gcc and ld for each name, which PySDL2 asks for six of even
    if it has its own library: the window would stand still meanwhile.
    """
    file = f"lib{name}.so.0"
    try:
        ctypes.CDLL(file)
    except OSError:
        return None
    return file
