"""Places and steps of values on a slider."""

import math

import pytest

from workbench.gui.gains.gain_scale import GainScale, StepSize, decimals
from workbench.gui.units import Unit
from workbench.scenario.parameters import parameter_table

SI = Unit("")


def scale_of(name):
    return GainScale(parameter_table().find(name), SI)


def test_every_row_rises_from_end_to_end_and_comes_back(case):
    for row in parameter_table():
        with case(row):
            scale = GainScale(row, SI)
            assert scale.place(row.minimum) == pytest.approx(0.0, abs=1e-12)
            assert scale.place(row.maximum) == pytest.approx(1.0)
            values = [scale.value(index / 200) for index in range(201)]
            assert values == sorted(values)
            assert values[0] == row.minimum
            assert values[-1] == pytest.approx(row.maximum)
            if not row.whole:
                for place in (0.1, 0.5, 0.9):
                    assert scale.place(scale.value(place)) == pytest.approx(place)


def test_positive_values_over_a_decade_stand_by_their_ratio():
    scale = scale_of("kp_velocity_z")  # 0.5 .. 30
    assert scale.value(0.5) == pytest.approx((0.5 * 30.0) ** 0.5)


def test_where_zero_is_allowed_doublings_are_even_far_from_it():
    scale = scale_of("kp_roll")  # 0 .. 2500, 150 by default
    first = scale.place(400.0) - scale.place(200.0)
    second = scale.place(800.0) - scale.place(400.0)
    assert first == pytest.approx(second, rel=0.01)
    assert scale.place(0.0) == 0.0


def test_a_share_whose_default_is_an_end_is_spread_evenly():
    assert scale_of("rotor_1").value(0.25) == pytest.approx(0.25)


def test_whole_numbers_stay_whole():
    scale = scale_of("imu_fault")
    assert {scale.value(index / 50) for index in range(51)} == {0.0, 1.0, 2.0, 3.0}
    assert scale.step(2.0) == 1.0


@pytest.mark.parametrize(
    ("name", "value", "step"),
    [
        ("kp_velocity_x", 4.45, 0.1),
        ("kp_roll", 225.0, 5.0),
        ("kd_roll", 27.0, 0.5),
        ("kd_velocity_x", 0.1, 0.002),
        ("kd_velocity_x", 0.0, 0.0002),
    ],
)
def test_a_step_is_some_two_percent_and_round(name, value, step):
    assert scale_of(name).step(value) == step


def test_a_value_beyond_the_limits_stands_at_the_end():
    scale = scale_of("kp_velocity_x")
    assert (scale.place(-5.0), scale.place(99.0)) == (0.0, pytest.approx(1.0))


def test_three_digits_are_kept_as_they_are_shown():
    scale = scale_of("kp_velocity_x")
    assert scale.round_value(0.6) == float(f"{scale.value(0.6):.3g}")
    degrees = GainScale(parameter_table().find("max_tilt"), Unit("°", 180.0 / math.pi))
    shown = math.degrees(degrees.round_value(0.5))
    assert shown == pytest.approx(float(f"{shown:.3g}"), abs=1e-12)
    assert degrees.round_value(0.0) == parameter_table().find("max_tilt").minimum


def test_steps_stay_within_the_limits():
    scale = scale_of("kp_velocity_x")
    assert scale.stepped(3.0, 1, StepSize.FINE) == 3.05
    assert scale.stepped(3.0, -1, StepSize.COARSE) == 2.75
    assert scale.stepped(29.9, 1, StepSize.COARSE) == 30.0
    assert scale_of("imu_fault").stepped(2.0, 1, StepSize.FINEST) == 3.0


def test_decimals_show_a_step():
    assert [decimals(step) for step in (0.5, 0.01, 1.0, 20.0, 0.002)] == [1, 2, 0, 0, 3]
