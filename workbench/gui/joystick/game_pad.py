"""Game pads, by SDL: found as they are plugged in, read when asked; needs no window and no screen.

SDL is the extra `gamepad`; without it there is no pad, and `GamePads.missing` says what to install.
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
"""Of an axis."""
START = "SDL_CONTROLLER_BUTTON_START"
"""By which a pad takes over from another one."""


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
        number: SDL's, of this pad while it is plugged in.
        guid: of its kind; its mapping is kept under that.
        raw: its axes, -1 .. 1.
        asks: whether its button Start has gone down: it wants to fly.
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
    """A pad that is plugged in; `down` has the buttons that are held, by SDL's names."""

    handle: Any
    name: str
    guid: str
    down: frozenset[str] = field(default_factory=frozenset)


class GamePads:
    """The game pads that are plugged in, one of which flies.

    The first one flies. Another one takes over when it is told to, never because one is unplugged.

    Args:
        mapping: returns what the axes of a pad move, by its GUID.

    Attributes:
        missing: what to install, "" where game pads can be read.
        readings: of all pads, as they were at the last look.
        flying: number of the pad that flies, None while none does.
    """

    def __init__(self, mapping: Callable[[str], PadMapping] = lambda guid: PadMapping()) -> None:
        self.missing = ""
        self.readings: tuple[PadReading, ...] = ()
        self.flying: int | None = None
        self._mapping = mapping
        self._sdl: Any = None
        self._pads: dict[int, _OpenPad] = {}

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
        """Look at all pads, and return how the one is that flies, None while none does."""
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
        """Let a pad fly from now on, as of the next reading."""
        if number in self._pads:
            self.flying = number

    def close(self) -> None:
        """Let go of everything."""
        if self._sdl is not None:
            for number in tuple(self._pads):
                self._let_go(number)
            self._sdl.SDL_QuitSubSystem(self._sdl.SDL_INIT_GAMECONTROLLER)
            self._sdl = None
            self.readings = ()

    def _find(self) -> None:
        """Open the pads that have been plugged in; the first of them flies, if it is alone."""
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
                pad.down = self._down(pad)  # what is held while it is plugged in is not pressed
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
        warnings.simplefilter("ignore")  # it warns of which library it has found
        return importlib.import_module("sdl2")
