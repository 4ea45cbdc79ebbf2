"""Compiled records of the laws of autopilots are those of the diagram."""

from dataclasses import fields, replace

import numpy as np
import pytest

from workbench.design.scripted_flight import ScriptedFlight, why_no_script
from workbench.design.step_response import step_scenario
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session
from workbench.setup import make_setup

CLOSE = 1e-9
"""Of the largest value of a field, or of its size."""
SIZES = {"wdot_WB": 100.0, "innovations": 10.0}
"""Of what is larger than 1: rotors that cancel each other each give as much [rad/s²]; the diagram's
GPS tells latitudes, which are rounded to 1e-9 m."""
EXACT = ("time", "reference", "mode", "reason", "clearance", "known_charge")
WIND = {"wind_x": 3.0, "gust_y": 2.0, "gust_start": 0.0, "gust_duration": 1.5, "drag_area": 0.02}


def both(scenario, settings):
    """Return the recordings of a flight in compiled code and on the diagram."""
    flown = ScriptedFlight(make_setup(scenario, settings))
    assert not flown.why_not
    recording, why_not = flown.fly(scenario.script, scenario.duration)
    assert not why_not
    session = Session(scenario, settings)
    session.run()
    return recording, session.recording()


def assert_equal(scenario, settings):
    compiled, diagram = both(scenario, settings)
    for field in fields(diagram):
        name = field.name
        if name == "vehicle":
            continue
        found, wanted = getattr(compiled, name), getattr(diagram, name)
        assert found.shape == wanted.shape, name
        if name in EXACT:
            assert np.array_equal(found, wanted), name
            continue
        size = max(SIZES.get(name, 1.0), np.nanmax(np.abs(wanted), initial=0.0))
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=CLOSE * size, err_msg=name)


def step(axis, amplitude, duration, scenario=None, **changes):
    whole = make_setup(replace(scenario or Scenario(), **changes)).scenario
    return step_scenario(axis, amplitude, duration, whole)


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["crazyflie", "px4", "betaflight"])
def test_a_fast_law_is_recorded_as_by_the_diagram(controller):
    assert_equal(step("y", 2.0, 1.0, controller=controller), WIND)


def test_a_flight_of_firmware_is_not_compiled():
    setup = make_setup(Scenario(controller="betaflight-sitl"))
    assert "betaflight-sitl is not compiled" in why_no_script(setup)
