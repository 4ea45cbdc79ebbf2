"""Actions go in and come out as they were, and many take little room."""

import sys

import pytest

from workbench.live.log_keeper import History
from workbench.scenario.scenario import Action, Gust, Push

ACTIONS = [
    Action(0.0, velocity=[1.0, -2.0, 0.1], yaw_rate=0.3),
    Action(0.25, velocity=[1.0, 0.0, 0.0]),
    Action(0.25, yaw_rate=0.1),
    Action(0.5, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0, request="land"),
    Action(0.75, request="take_off", height=2.0),
    Action(1.0, go_to=[1.0, 2.0, 3.0]),
    Action(1.25, set={"kp_roll": 90.0}),
    Action(1.5, gust=Gust([1.0, 0.0, 0.0], 2.0), push=Push([0.0, 1.0, 0.0])),
    Action(0.1 + 0.2, velocity=[5e-324, 1e300, -0.0], yaw_rate=1 / 3),
]


@pytest.fixture
def history() -> History:
    history = History()
    for index, action in enumerate(ACTIONS):
        history.append(action, ("one", "operator", "link")[index % 3])
    return history


def test_all_come_back_to_the_bit_and_in_their_order(history):
    assert len(history) == len(ACTIONS)
    assert list(map(repr, history.actions)) == list(map(repr, ACTIONS))
    assert [by for _, by in history] == ["one", "operator", "link"] * 3


def test_nothing_is_left_once_it_is_cleared(history):
    history.clear()
    assert list(history) == []
    history.append(ACTIONS[5], "two")
    assert list(history) == [(ACTIONS[5], "two")]


def test_an_hour_of_steering_takes_a_few_megabytes():
    history = History()
    for index in range(20 * 3600):
        history.append(Action(index / 20, velocity=[1.0, 0.0, 0.0], yaw_rate=0.1), "one")
    assert sys.getsizeof(history._numbers) + sys.getsizeof(history._who) < 5_000_000
    assert not history._others
