import math

import pytest

from workbench.gateways.monitor.sticks import Sticks


@pytest.fixture
def sticks():
    return Sticks(level_speed=8.0, climb_rate=2.0, yaw_rate=0.3)


@pytest.mark.parametrize(
    ("key", "asked"),
    [
        ("w", (1.0, 0.0, 0.0, 0.0)),
        ("s", (-1.0, 0.0, 0.0, 0.0)),
        ("a", (0.0, 1.0, 0.0, 0.0)),
        ("d", (0.0, -1.0, 0.0, 0.0)),
        ("up", (0.0, 0.0, 1.0, 0.0)),
        ("down", (0.0, 0.0, -1.0, 0.0)),
        ("left", (0.0, 0.0, 0.0, 0.3)),
        ("right", (0.0, 0.0, 0.0, -0.3)),
    ],
)
def test_each_key_moves_its_stick(sticks, key, asked):
    assert sticks.press(key, 10.0)
    assert sticks.asked(10.1, yaw=0.0) == pytest.approx(asked)


def test_ahead_is_along_the_heading(sticks):
    sticks.press("w", 0.0)
    assert sticks.asked(0.0, math.pi / 2)[:2] == pytest.approx((0.0, 1.0))
    sticks.let_go()
    sticks.press("a", 0.0)
    assert sticks.asked(0.0, math.pi / 2)[:2] == pytest.approx((-1.0, 0.0))


@pytest.mark.parametrize(
    ("time", "speed"), [(0.0, 1.0), (0.3, 1.0), (0.45, 0.5), (0.6, 0.0), (100.0, 0.0)]
)
def test_a_key_counts_a_while_and_fades(sticks, time, speed):
    sticks.press("w", 5.0)
    assert sticks.asked(5.0 + time, 0.0)[0] == pytest.approx(speed)


def test_a_key_that_comes_again_goes_on(sticks):
    for tick in range(20):
        sticks.press("w", 0.25 * tick)
        assert sticks.asked(0.25 * tick + 0.2, 0.0)[0] == 1.0


def test_the_last_of_two_opposite_keys_counts(sticks):
    sticks.press("w", 0.0)
    sticks.press("s", 0.1)
    assert sticks.asked(0.1, 0.0)[0] == -1.0


def test_two_keys_are_no_faster_than_one(sticks):
    sticks.press("w", 0.0)
    sticks.press("d", 0.0)
    x, y, *_ = sticks.asked(0.0, 0.3)
    assert math.hypot(x, y) == pytest.approx(1.0)


def test_letting_go_stops_at_once(sticks):
    for key in ("w", "a", "up", "left"):
        sticks.press(key, 0.0)
    sticks.let_go()
    assert sticks.asked(0.0, 0.0) == (0.0, 0.0, 0.0, 0.0)


def test_speed_goes_up_and_down_within_the_limits(sticks):
    sticks.press("w", 0.0)
    sticks.press("up", 0.0)
    for _ in range(20):
        sticks.faster()
    assert sticks.speed == 8.0
    assert sticks.asked(0.0, 0.0)[0::2] == pytest.approx((8.0, 2.0))
    for _ in range(20):
        sticks.slower()
    assert sticks.speed == 0.1


def test_other_keys_mean_nothing(sticks):
    assert not sticks.press("z", 0.0)
    assert sticks.asked(0.0, 0.0) == (0.0, 0.0, 0.0, 0.0)
