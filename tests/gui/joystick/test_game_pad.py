"""Game pads, by one that SDL makes up: plugged in and out, sticks and buttons."""

import subprocess
import sys
import warnings

import pytest

from workbench.gui.joystick.game_pad import SDL_MISSING_TEXT, GamePads, PadButton
from workbench.gui.joystick.piloting import CENTRED_STICKS, Sticks

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it warns of which library it has found
    sdl2 = pytest.importorskip("sdl2")

AXES, BUTTONS = 6, 15
LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y = 0, 1, 2, 3
A, B, BACK, START = 0, 1, 4, 6


class VirtualPad:
    """A pad that SDL makes up; numbers of its parts are those of SDL's own mapping."""

    def __init__(self):
        kind = sdl2.SDL_JOYSTICK_TYPE_GAMECONTROLLER
        self.index = sdl2.SDL_JoystickAttachVirtual(kind, AXES, BUTTONS, 0)
        assert self.index >= 0, sdl2.SDL_GetError()
        self.joystick = sdl2.SDL_JoystickOpen(self.index)

    def move(self, axis, value):
        assert sdl2.SDL_JoystickSetVirtualAxis(self.joystick, axis, value) == 0

    def press(self, button, down=1):
        assert sdl2.SDL_JoystickSetVirtualButton(self.joystick, button, down) == 0

    def unplug(self):
        sdl2.SDL_JoystickClose(self.joystick)
        assert sdl2.SDL_JoystickDetachVirtual(self.index) == 0


@pytest.fixture
def pads():
    made = GamePads()
    made.open()
    assert made.missing == ""
    yield made
    made.close()


def test_a_pad_is_found_when_it_is_plugged_in_and_forgotten_when_it_is_not(pads):
    assert pads.read() is None
    pad = VirtualPad()
    reading = pads.read()
    assert reading is not None
    assert reading.name
    assert reading.sticks == CENTRED_STICKS
    pad.move(RIGHT_Y, -32768)
    assert pads.read().sticks == Sticks(forward=1.0)
    pad.unplug()
    assert pads.read() is None
    again = VirtualPad()
    assert pads.read().sticks == CENTRED_STICKS
    again.unplug()


def test_sticks_are_mode_2_with_up_positive(pads):
    pad = VirtualPad()
    pad.move(LEFT_X, 16384)
    pad.move(LEFT_Y, 16384)
    pad.move(RIGHT_X, -32767)
    pads.read()
    sticks = pads.read().sticks
    assert sticks == pytest.approx((0.5, -0.5, -1.0, 0.0), abs=1e-3)
    pad.unplug()


def test_a_stick_that_rests_beside_its_middle_is_in_it(pads):
    pad = VirtualPad()
    pad.move(LEFT_X, 2000)
    assert pads.read().sticks == CENTRED_STICKS
    pad.unplug()


def test_a_button_is_heard_once_as_it_goes_down(pads):
    pad = VirtualPad()
    pad.press(B)
    assert pads.read().pressed == ()  # it was held while the pad was plugged in
    pad.press(A)
    assert pads.read().pressed == (PadButton.TAKE_OFF,)
    assert pads.read().pressed == ()
    pad.press(A, 0)
    pad.press(BACK)
    assert pads.read().pressed == (PadButton.STOP,)
    pad.unplug()


def test_without_sdl_what_to_install_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "sdl2", None)
    pads = GamePads()
    pads.open()
    assert pads.missing == SDL_MISSING_TEXT
    assert pads.read() is None
    pads.close()


WATCHED_SEARCH = """
import sys
started = []
kinds = ("subprocess.Popen", "os.posix_spawn", "os.fork", "os.exec", "os.system")
sys.addaudithook(lambda kind, how: started.append(how[0]) if kind in kinds else None)
sys.modules["sdl2dll"] = {own}
from workbench.gui.joystick.game_pad import GamePads
pads = GamePads()
pads.open()
print(bool(pads.missing), started)
"""
"""A program that looks for pads and prints whether SDL is missing, and the programs started."""


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the search starts no programs")
def test_looking_for_sdl_starts_no_compiler(case):
    for own, missing in (("__import__('sdl2dll')", {"False"}), ("None", {"False", "True"})):
        with case(own):  # without the package, a system may have an SDL of its own
            command = [sys.executable, "-c", WATCHED_SEARCH.format(own=own)]
            said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
            assert said.split(maxsplit=1)[0] in missing
            assert said.split(maxsplit=1)[1].strip() == "[]"


def test_the_second_pad_flies_when_told_and_not_because_the_first_is_gone(pads):
    first, second = VirtualPad(), VirtualPad()
    pads.read()
    one, two = pads.readings
    assert pads.flying == one.number
    second.move(RIGHT_X, 32767)
    pads.read()
    assert pads.read().sticks == CENTRED_STICKS
    pads.fly(two.number)
    assert pads.read().sticks == Sticks(right=1.0)
    second.press(START)
    pads.read()
    assert not any(each.asks for each in pads.readings if each.number == one.number)
    second.unplug()
    assert pads.read() is None
    assert len(pads.readings) == 1
    first.unplug()
