"""When a flight is lost, by hand on a recording that is changed."""

import dataclasses

import numpy as np
import pytest

from workbench.control.mode import FlightMode
from workbench.design.lost import find_loss
from workbench.design.step_response import fly_step
from workbench.scenario.scenario import Action, Scenario, ScenarioStart
from workbench.session.session import Session

OVER = [0.0, 1.0, 0.0, 0.0]
AT = 100


@pytest.fixture(scope="module")
def recording():
    return fly_step("z", 0.5, duration=0.5).recording


def changed(recording, **values):
    """Return the recording with other values from a sample on."""
    new = {name: getattr(recording, name).copy() for name in values}
    for name, value in values.items():
        new[name][AT:] = value
    return dataclasses.replace(recording, **new)


def test_a_flight_is_lost(case, recording):
    for values, how in [
        ({"q_WB": OVER, "w_WB": [0.0, 8.0, 8.0]}, "upside down and turning at 11 rad/s"),
        ({"q_WB": OVER, "v_WB": [15.0, 0.0, -15.0]}, "upside down and moving at 21 m/s"),
        ({"p_WB": [0.0, 0.0, 0.01]}, "it has come down to the ground"),
        ({"v_WB": [np.nan, 0.0, 0.0]}, "its state is no longer finite"),
        ({"w_WB": [0.0, np.inf, 0.0]}, "its state is no longer finite"),
        ({"p_WB": [0.0, 0.0, np.inf]}, "its state is no longer finite"),
        ({"q_WB": [np.nan] * 4}, "its state is no longer finite"),
        ({"q_WB": [np.inf] * 4}, "its state is no longer finite"),
        ({"q_WB": OVER, "v_WB": [1e200] * 3}, "upside down and moving at inf m/s"),
    ]:
        with case(values, how):
            loss = find_loss(changed(recording, **values))
            assert (loss.time, loss.how) == (recording.time[AT], how)
            assert loss.sentence == f"the flight is lost at t = {loss.time:.3f} s: {how}"


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"q_WB": OVER, "w_WB": [0.0, 7.0, 7.0], "v_WB": [14.0, 0.0, -14.0]},
        {"w_WB": [0.0, 50.0, 0.0], "v_WB": [150.0, 0.0, 0.0]},
        {"q_WB": [0.7072, 0.7070, 0.0, 0.0], "w_WB": [0.0, 50.0, 0.0]},  # not quite on edge
        {"mode": FlightMode.LANDING, "p_WB": [0.0, 0.0, 0.01]},
    ],
)
def test_a_flight_is_not_lost(recording, values):
    assert find_loss(changed(recording, **values)) is None


@pytest.mark.slow
def test_up_and_down_again_is_a_flight():
    script = [Action(at=0.0, request="take_off", height=0.5), Action(at=4.0, request="land")]
    session = Session(Scenario(start=ScenarioStart(mode="off"), duration=10.0, script=script))
    session.run()
    flown = session.recording()
    assert set(flown.mode) >= {FlightMode.HOVERING, FlightMode.LANDING}
    assert flown.mode[-1] == FlightMode.OFF
    assert find_loss(flown) is None
