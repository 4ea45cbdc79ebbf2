"""Oracle: the recording of the same flight on the diagram."""

from dataclasses import fields, replace

import numpy as np
import pytest

from workbench.design.scripted_flight import ScriptedFlight, why_no_script
from workbench.design.step_response import step_scenario
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
)
from workbench.session.session import Session
from workbench.setup import make_setup

CLOSE = 1e-9
"""Of the largest value of a field, or of its size."""
SIZES = {"wdot_WB": 100.0, "innovations": 10.0}
"""Of what is larger than 1: rotors that cancel each other each give as much [rad/s²]; the diagram's
GPS tells latitudes, which are rounded to 1e-9 m."""
EXACT = ("time", "reference", "mode", "reason", "clearance", "known_charge")
WIND = {"wind_x": 3.0, "gust_y": 2.0, "gust_start": 0.0, "gust_duration": 1.5, "drag_area": 0.02}
PUSH = {"push_x": 1.0, "push_start": 0.5005, "turbulence": 2.0}


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
    return step_scenario(axis, amplitude, duration, replace(scenario or Scenario(), **changes))


def test_a_step_in_wind_is_recorded_as_by_the_diagram():
    assert_equal(step("x", 1.0, 1.0), WIND | PUSH)


def test_a_lost_rotor_is_recorded_as_by_the_diagram():
    scenario = step("z", 1.0, 0.5)
    scenario.start = ScenarioStart(position=[0.0, 0.0, 20.0])
    assert_equal(scenario, {"rotor_2": 0.0})


def test_a_recording_may_have_fewer_samples():
    scenario = step("x", 1.0, 0.5)
    scenario.rates.record_period = 1 / 32
    assert_equal(scenario, {})


def test_a_turn_of_a_script_is_recorded_as_by_the_diagram():
    scenario = step("yaw", 0.2, 0.6)
    scenario.start = ScenarioStart(
        position=[1.0, 2.0, 9.0],
        roll_pitch_yaw=[0.1, -0.2, 3.0],
        velocity=[0.3, 0.4, -0.5],
        angular_velocity=[0.1, 0.2, 0.3],
    )
    scenario.script.append(Action(at=0.301, velocity=[0.0, 0.0, 1.0]))
    assert_equal(scenario, {})


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["ekf", "complementary"])
def test_an_estimate_is_recorded_as_by_the_diagram(estimator):
    assert_equal(step("z", 1.0, 2.0, estimator=estimator), WIND)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "sensors"),
    [
        ({"position_deviation_limit": 0.1}, {"rates": {"gps": 1.5}}),
        ({}, {"rates": {"gps": 0.5}}),
        ({}, {"rates": {"magnetometer": 0.4}}),
    ],
)
def test_an_estimate_in_doubt_is_left_to_the_diagram(settings, sensors):
    scenario = step("z", 1.0, 3.0, estimator="ekf", sensors=SensorsConfig(**sensors))
    recording, why_not = ScriptedFlight(make_setup(scenario, settings)).fly(
        scenario.script, scenario.duration
    )
    assert recording is None
    assert "doubt" in why_not


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"start": ScenarioStart(mode="off")}, "ground"),
        ({"world": "room"}, "room"),
        ({"figure_eight": FigureEight()}, "eight"),
        ({"script": [Action(go_to=[1.0, 0.0, 2.0])]}, "script"),
        ({"script": [Action(set={"wind_x": 1.0})]}, "script"),
        ({"rates": Rates(record_period=1 / 1024)}, "records"),
    ],
)
def test_other_scenarios_are_not_compiled(changes, why):
    assert why in why_no_script(make_setup(replace(Scenario(), **changes)))


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"sensors": SensorsConfig(use=["gps"])}, "sensors"),
    ],
)
def test_what_is_not_compiled_is_told(changes, why):
    assert why in ScriptedFlight(make_setup(step("x", 1.0, 1.0, **changes))).why_not


@pytest.mark.parametrize(("height", "why"), [(0.3, "ground"), (1.0, "lost")])
def test_a_flight_near_the_ground_is_left_to_the_diagram(height, why):
    scenario = step("z", -1.0, 0.1 if height < 1.0 else 3.0)
    scenario.start.position = [0.0, 0.0, height]
    recording, why_not = ScriptedFlight(make_setup(scenario)).fly(
        scenario.script, scenario.duration
    )
    assert recording is None
    assert why in why_not


def test_a_flight_whose_battery_is_low_is_left_to_the_diagram():
    scenario, settings = step("x", 1.0, 1.0), {"battery_reserve": 0.9, "battery_duration": 60.0}
    _, why_not = ScriptedFlight(make_setup(scenario, settings)).fly(scenario.script, 12.0)
    assert "battery" in why_not
