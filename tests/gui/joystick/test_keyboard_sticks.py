"""Held keys as sticks."""

import pytest

from workbench.gui.joystick.keyboard_sticks import (
    FULL_DEFLECTION_TIME_S,
    KEY_DIRECTIONS,
    KeyboardSticks,
)
from workbench.gui.joystick.piloting import CENTRED_STICKS


@pytest.fixture
def keys(workspace):
    """Sticks of the workspace's keys, none of which is held."""
    return KeyboardSticks(workspace.keys)


def test_a_held_key_runs_up_to_full_stick(keys):
    keys.press("stick_forward")
    assert keys.advance(FULL_DEFLECTION_TIME_S / 4).forward == pytest.approx(0.25)
    assert keys.advance(FULL_DEFLECTION_TIME_S).forward == 1.0
    assert keys.sticks[:2] == (0.0, 0.0)


def test_a_tap_is_gentle(keys):
    keys.press("stick_climb")
    assert keys.advance(0.05).climb == pytest.approx(0.1)
    keys.release("stick_climb")
    assert keys.sticks == CENTRED_STICKS


def test_opposite_keys_cancel_and_a_turn_begins_in_the_middle(keys):
    keys.press("stick_left")
    keys.advance(FULL_DEFLECTION_TIME_S)
    assert keys.sticks.right == -1.0
    keys.press("stick_right")
    assert keys.advance(0.1).right == 0.0
    keys.release("stick_left")
    assert keys.advance(FULL_DEFLECTION_TIME_S / 2).right == pytest.approx(0.5)
    keys.press("stick_left")  # both change between two steps
    keys.release("stick_right")
    assert keys.advance(FULL_DEFLECTION_TIME_S / 4).right == pytest.approx(-0.25)


def test_two_keys_stay_in_the_circle(keys):
    keys.press("stick_sink")
    keys.press("stick_turn_right")
    for _ in range(20):
        keys.advance(FULL_DEFLECTION_TIME_S / 10)
    assert keys.sticks.turn == pytest.approx(0.7071, abs=1e-4)
    assert keys.sticks.climb == pytest.approx(-0.7071, abs=1e-4)


def test_all_keys_are_let_go_at_once(keys):
    for key in KEY_DIRECTIONS:
        keys.press(key)
    keys.advance(1.0)
    keys.release_all()
    assert keys.sticks == CENTRED_STICKS
    assert not keys.is_held
    assert keys.advance(1.0) == CENTRED_STICKS
