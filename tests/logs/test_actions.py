"""Actions as text and back."""

import json

import numpy as np
import pytest

from workbench.logs.contents import action_text, read_action
from workbench.scenario.scenario import Action, Gust, Injection, Push

THIRD = 1 / 3


@pytest.mark.parametrize(
    "action",
    [
        Action(at=0.5),
        Action(at=0.5, velocity=[THIRD, -0.0, 5e-324], yaw_rate=0.1),
        Action(at=0.5, go_to=[1.0, 2.0, 1e300]),
        Action(at=0.5, request="take_off", height=1.1),
        Action(at=0.5, gust=Gust([1.0, 0.0, THIRD], 0.7), push=Push([0.1, 0.2, 0.3])),
        Action(at=0.5, injection=Injection("acceleration_x", THIRD, 0.5, 40.0, 7)),
        Action(at=0.5, set={"kp_velocity_x": THIRD, "wind_x": -2.0}),
    ],
)
def test_an_action_is_read_back_exactly(action):
    text = action_text(action)
    assert read_action(0.5, text) == action
    assert "at" not in json.loads(text)


def test_the_sign_of_zero_is_kept():
    found = read_action(0.0, action_text(Action(velocity=[-0.0, 0.0, 0.0])))
    assert str(found.velocity) == "[-0.0, 0.0, 0.0]"


def test_numbers_of_numpy_and_tuples_are_numbers():
    action = Action(velocity=np.array([1.0, 2.0, THIRD]), yaw_rate=np.float32(0.5), go_to=(1, 2, 3))
    assert json.loads(action_text(action)) == {
        "velocity": [1.0, 2.0, THIRD],
        "yaw_rate": 0.5,
        "go_to": [1.0, 2.0, 3.0],
    }


@pytest.mark.parametrize("text", ["", "[]", "{", '{"fly": 1}', '{"gust": {"speed": 1}}'])
def test_what_is_no_action_is_refused(text):
    with pytest.raises((ValueError, TypeError, AttributeError)):
        read_action(0.0, text)
