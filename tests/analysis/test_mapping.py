"""Maps against single predictions."""

import numpy as np
import pytest

from workbench.analysis.questions import DrawMap, Predict, Step
from workbench.common.errors import WorkbenchError
from workbench.scenario.parameters import SIGNAL_PATH, parameter_table

STEP = Step("x", 2.0, 1.5)


def test_each_value_is_that_of_a_step_with_these_gains(answer):
    """The question has every value that the app's sliders have, also those of filters."""
    names = [row.name for system in SIGNAL_PATH for row in parameter_table().of(system)]
    known = parameter_table().defaults()
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
    mapped = answer(DrawMap(unstable, "kp_pitch", "kd_pitch", "overshoot", Step("x", 5.0, 3.0)))
    assert np.isnan(mapped.values).any()


@pytest.mark.parametrize(
    ("x", "y", "metric", "said"),
    [
        ("kp_rol", "kd_roll", "overshoot", "unknown gain 'kp_rol': did you mean 'kp_roll'"),
        ("kp_roll", "kp_roll", "overshoot", "give two different gains"),
        ("kp_roll", "kd_roll", "beauty", "unknown metric"),
        ("kp_roll", "wind_x", "overshoot", "unknown gain 'wind_x'"),
    ],
)
def test_what_makes_no_map_is_refused(answer, x, y, metric, said):
    with pytest.raises(WorkbenchError, match=said):
        answer(DrawMap({}, x, y, metric, STEP))


def test_a_long_step_is_refused_as_margins_would_have_to_wait_for_it(answer):
    with pytest.raises(WorkbenchError, match="too long to predict: give it 10 s at most"):
        answer(DrawMap({}, "kp_roll", "kd_roll", "overshoot", Step("y", 1.0, 11.0)))
