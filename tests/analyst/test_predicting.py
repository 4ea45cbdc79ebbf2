"""Predicted steps against the same steps flown on the full diagram."""

import numpy as np
import pytest

from workbench.analyst.questions import Predict, Step
from workbench.analyst.subject import Subject
from workbench.design.step_response import fly_step
from workbench.errors import WorkbenchError
from workbench.scenario import Scenario


@pytest.mark.parametrize(("axis", "amplitude"), [("x", 2.0), ("z", -1.0), ("yaw", 0.2)])
def test_a_step_is_as_the_diagram_flies_it(answer, axis, amplitude):
    """Within 1 mm/s, or 1 mrad/s."""
    gains = {"kp_velocity_x": 6.0, "kp_pitch": 180.0, "kp_yaw_rate": 6.0, "kp_velocity_z": 6.0}
    predicted = answer(Predict(gains, Step(axis, amplitude, 2.0)))
    flown = fly_step(axis, amplitude, duration=2.0, settings=gains)
    assert predicted.time == pytest.approx(flown.time, abs=1e-9)
    assert np.abs(predicted.response - flown.response).max() < 1e-3
    assert predicted.numbers.rise_time == pytest.approx(flown.metrics.rise_time, abs=0.01)
    assert predicted.numbers.overshoot == pytest.approx(flown.metrics.overshoot, abs=0.1)
    assert predicted.numbers.peak_rotor_use == pytest.approx(flown.peak_rotor_use, abs=0.005)
    assert not predicted.lost


def test_the_wind_of_the_settings_blows(answer):
    settings = {"wind_x": 8.0, "gps_fault": 1.0}
    windy = Subject(Scenario(), settings)
    predicted = answer(Predict({}, Step("x", 2.0, 1.0)), windy)
    flown = fly_step("x", 2.0, duration=1.0, settings={"wind_x": 8.0})
    calm = answer(Predict({}, Step("x", 2.0, 1.0)))
    assert np.abs(predicted.response - flown.response).max() < 1e-3
    assert np.abs(predicted.response - calm.response).max() > 0.01


def test_a_drone_that_is_lost_is_said_to_be(answer):
    predicted = answer(Predict({"kp_pitch": 2500.0, "kd_pitch": 0.5}, Step("x", 5.0, 3.0)))
    assert predicted.lost
    assert np.isnan(predicted.response[-1])
    assert np.isnan(predicted.numbers.rise_time)


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (Step("w", 1.0, 1.0), "unknown axis 'w'"),
        (Step("x", 0.0, 1.0), "the amplitude is 0"),
        (Step("x", float("nan"), 1.0), "the amplitude is nan"),
        (Step("x", 1.0, 0.0), "a step cannot be measured in 0 s"),
        (Step("x", 1.0, 100.0), "is too long to be shown at once"),
    ],
)
def test_what_makes_no_step_is_refused(answer, step, said):
    with pytest.raises(WorkbenchError, match=said):
        answer(Predict({}, step))
