"""Held keys as sticks."""

import pytest

from workbench.gui.joystick.keyboard_sticks import RUN_UP, KeyboardSticks, StickKey
from workbench.gui.joystick.piloting import NEUTRAL


def test_a_held_key_runs_up_to_full_stick():
    keys = KeyboardSticks()
    keys.press(StickKey.FORWARD)
    assert keys.advance(RUN_UP / 4).right.y == pytest.approx(0.25)
    assert keys.advance(RUN_UP).right.y == 1.0
    assert keys.sticks.left.is_neutral


def test_a_tap_is_gentle():
    keys = KeyboardSticks()
    keys.press(StickKey.CLIMB)
    assert keys.advance(0.05).left.y == pytest.approx(0.1)
    keys.release(StickKey.CLIMB)
    assert keys.sticks == NEUTRAL


def test_opposite_keys_cancel_and_a_turn_begins_in_the_middle():
    keys = KeyboardSticks()
    keys.press(StickKey.LEFT)
    keys.advance(RUN_UP)
    assert keys.sticks.right.x == -1.0
    keys.press(StickKey.RIGHT)
    assert keys.advance(0.1).right.x == 0.0
    keys.release(StickKey.LEFT)
    assert keys.advance(RUN_UP / 2).right.x == pytest.approx(0.5)


def test_two_keys_stay_in_the_circle():
    keys = KeyboardSticks()
    keys.press(StickKey.SINK)
    keys.press(StickKey.TURN_RIGHT)
    for _ in range(20):
        keys.advance(RUN_UP / 10)
    assert keys.sticks.left.x == pytest.approx(0.7071, abs=1e-4)
    assert keys.sticks.left.y == pytest.approx(-0.7071, abs=1e-4)


def test_all_keys_are_let_go_at_once():
    keys = KeyboardSticks()
    for key in StickKey:
        keys.press(key)
    keys.advance(1.0)
    keys.release_all()
    assert keys.sticks == NEUTRAL
    assert not keys.is_held
    assert keys.advance(1.0) == NEUTRAL
