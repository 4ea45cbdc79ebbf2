"""Sensitivities, against central differences of the same flight, and against the flown one."""

import math

import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.judge.sensitivity import (
    SENSITIVITY_METRICS,
    SENSITIVITY_STEP_S,
    _body_and_rotors,
    _hover_state,
    step_sensitivity,
)
from workbench.design.step_metrics import STEP_NUMBERS
from workbench.design.step_response import fly_step
from workbench.diagram.core import make_flight_core
from workbench.setup import make_setup

DURATION = 2.0


@pytest.fixture(scope="module")
def found():
    return {each.metric: each for each in step_sensitivity("x", 2.0, duration=DURATION)}


def values(**settings):
    flown = step_sensitivity("x", 2.0, duration=DURATION, settings=settings)
    return {each.metric: each.value for each in flown}


@pytest.mark.parametrize("gain", ["kd_pitch", pytest.param("max_tilt", marks=pytest.mark.slow)])
def test_derivatives_are_those_of_central_differences(found, study, gain):
    value = study.gains[gain]
    h = 1e-5 * value  # at 1e-6 rounding is 3e-5 of the smallest slope
    above, below = values(**{gain: value + h}), values(**{gain: value - h})
    for metric in SENSITIVITY_METRICS:
        slope = (above[metric] - below[metric]) / (2.0 * h)
        scale = abs(found[metric].value / value) * 1e-3
        assert found[metric].derivatives[gain] == pytest.approx(slope, rel=1e-5, abs=1e-5 * scale)


def test_metrics_are_those_of_the_flown_step(found):
    flown = fly_step("x", 2.0, duration=DURATION).metrics
    assert found["rise_time"].value == pytest.approx(flown.rise_time, abs=2 * SENSITIVITY_STEP_S)
    assert found["settling_time"].value == pytest.approx(
        flown.settling_time, abs=2 * SENSITIVITY_STEP_S
    )
    assert found["peak"].value == pytest.approx(flown.peak, rel=2e-3)
    assert set(STEP_NUMBERS) < set(SENSITIVITY_METRICS)


def test_elasticities_are_percent_per_percent(found, study):
    rise = found["rise_time"]
    share = rise.derivatives["kp_velocity_x"] * study.gains["kp_velocity_x"] / rise.value
    assert rise.elasticities["kp_velocity_x"] == pytest.approx(share)
    assert -1.3 < share < -0.7
    assert set(rise.elasticities) == {row.name for row in load_controller().table.of("controller")}
    assert rise.elasticities["kp_velocity_y"] == pytest.approx(0.0, abs=1e-9)


def test_a_step_down_is_a_step_too():
    down = {each.metric: each for each in step_sensitivity("z", -1.0, duration=DURATION)}
    assert down["steady_state_value"].value == pytest.approx(-1.0, abs=0.05)
    assert down["rise_time"].elasticities["kp_velocity_z"] < -0.5
    assert math.isnan(down["overshoot"].elasticities["kp_velocity_z"])


def test_what_is_rounding_counts_as_nothing():
    found = {each.metric: each for each in step_sensitivity("yaw", 0.2, duration=DURATION)}
    for metric in ("overshoot", "undershoot"):
        assert found[metric].value == 0.0
        assert all(map(math.isnan, found[metric].elasticities.values()))


@pytest.mark.parametrize(
    ("axis", "amplitude", "duration", "word"),
    [
        ("w", 1.0, 1.0, "axis"),
        ("x", 0.0, 1.0, "not 0"),
        ("x", math.nan, 1.0, "not 0"),
        ("x", 1.0, 0.0, "0.1 s"),
        ("x", 1.0, math.inf, "0.1 s"),
    ],
)
def test_what_is_no_step_is_refused(axis, amplitude, duration, word):
    with pytest.raises(WorkbenchError, match=word):
        step_sensitivity(axis, amplitude, duration=duration)


def test_the_flight_begins_in_the_hover_that_is_asked_for():
    setup = make_setup()
    core, vehicle = make_flight_core(setup), setup.vehicle
    state = _hover_state(core, vehicle, 0.6)
    own, first = _body_and_rotors(core, vehicle)
    attitude = RollPitchYaw(Quaternion(state[own[:4]])).vector()
    assert attitude == pytest.approx([0.0, 0.0, 0.6], abs=1e-9)
    lift = sum(
        rotor.motor_constant * speed**2
        for rotor, speed in zip(vehicle.rotors, state[first:], strict=False)
    )
    assert lift == pytest.approx(vehicle.mass * 9.81, rel=1e-3)


def test_a_payload_that_the_law_does_not_know_is_refused():
    with pytest.raises(WorkbenchError, match="set known_payload_mass to payload_mass, 0.2 kg"):
        step_sensitivity("x", 1.0, settings={"payload_mass": 0.2})
