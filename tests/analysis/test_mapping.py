"""Maps against single predictions."""

import numpy as np
import pytest

from workbench.analysis.queries import DrawMap, Predict, RequestedStep
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.parameters.flight_parameters import SIGNAL_PATH

STEP = RequestedStep("x", 2.0, 1.5)


def test_each_value_is_that_of_a_step_with_these_gains(answer):
    """The question has every value that the app's sliders have, also those of filters."""
    names = [row.name for system in SIGNAL_PATH for row in load_controller().table.of(system)]
    known = load_controller().table.defaults()
    asked = {name: known[name] for name in names} | {"kd_pitch": 20.0, "gyro_lowpass": 60.0}
    mapped = answer(DrawMap(asked, "kp_pitch", "kp_velocity_x", "overshoot", STEP))
    assert mapped.values.shape == (len(mapped.y), len(mapped.x)) == (25, 25)
    assert np.isfinite(mapped.values).mean() > 0.5  # others have not settled
    for row, column in ((0, 0), (3, 20), (12, 12), (24, 7), (23, 24)):
        gains = {
            **asked,
            "kp_pitch": float(mapped.x[column]),
            "kp_velocity_x": float(mapped.y[row]),
        }
        single = answer(Predict(gains, STEP)).numbers.overshoot
        value = mapped.values[row, column]
        assert value == pytest.approx(single, abs=0.01, nan_ok=True), (row, column)


def test_the_gains_themselves_are_in_the_middle_and_the_map_goes_from_half_to_twice(answer):
    mapped = answer(DrawMap({"kp_pitch": 160.0}, "kp_pitch", "kd_pitch", "rise_time", STEP))
    assert mapped.x[12] == pytest.approx(160.0)
    assert (mapped.x[0], mapped.x[-1]) == pytest.approx((80.0, 320.0))
    assert mapped.unit == "s"


def test_a_map_stays_within_the_limits_of_a_gain(answer):
    mapped = answer(DrawMap({"kp_pitch": 2000.0}, "kp_pitch", "kd_velocity_x", "peak", STEP))
    assert mapped.x[-1] == pytest.approx(2500.0)
    assert mapped.unit == "m/s"
    mapped = answer(DrawMap({"kd_velocity_x": 0.0}, "kd_velocity_x", "kp_pitch", "peak", STEP))
    assert (mapped.x[0], mapped.x[-1]) == (0.0, 0.1)


def test_what_is_lost_has_no_value(answer):
    unstable = {"kp_pitch": 2500.0, "kd_pitch": 2.0}
    mapped = answer(
        DrawMap(unstable, "kp_pitch", "kd_pitch", "overshoot", RequestedStep("x", 5.0, 3.0))
    )
    assert np.isnan(mapped.values).any()


def test_what_does_not_settle_within_the_longest_step_of_a_map_has_no_value(answer):
    """With 0.1 1/s a speed needs some 40 s; the largest value of all in 10 s says nothing."""
    slow = answer(DrawMap({"kp_velocity_x": 0.1}, "kp_velocity_x", "kp_pitch", "peak", STEP))
    assert np.isnan(slow.values).all()


@pytest.mark.parametrize(
    ("x", "y", "metric", "said"),
    [
        ("kp_rol", "kd_roll", "overshoot", "unknown parameter of pd 'kp_rol': .*'kp_roll'"),
        ("kp_roll", "kp_roll", "overshoot", "give two different gains"),
        ("kp_roll", "kd_roll", "beauty", "unknown metric"),
        ("kp_roll", "wind_x", "overshoot", "unknown parameter of pd 'wind_x'"),
    ],
)
def test_what_makes_no_map_is_refused(answer, x, y, metric, said):
    with pytest.raises(WorkbenchError, match=said):
        answer(DrawMap({}, x, y, metric, STEP))


def test_a_long_step_is_refused_as_margins_would_have_to_wait_for_it(answer):
    with pytest.raises(WorkbenchError, match="too long to predict: give it 10 s at most"):
        answer(DrawMap({}, "kp_roll", "kd_roll", "overshoot", RequestedStep("y", 1.0, 11.0)))
