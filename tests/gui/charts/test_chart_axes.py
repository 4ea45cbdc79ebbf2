"""Round ends, round marks, and axes that do not jitter."""

import numpy as np
import pytest

from workbench.common.quantity import number_text
from workbench.gui.charts.chart_window import AXIS_SHRINK_DELAY_S, SteadyRange, round_ends
from workbench.gui.charts.number_axis import NumberAxis
from workbench.gui.charts.numbered_curve import spread_positions
from workbench.gui.charts.ticks import decimals_for, decimals_for_step


@pytest.mark.parametrize(("step", "wanted"), [(5.0, 0), (1.0, 0), (0.5, 1), (0.01, 2)])
def test_decimals_tell_the_steps_of_an_axis_apart(step, wanted):
    assert decimals_for_step(step) == wanted


def test_a_zero_has_no_sign_and_a_minus_is_one():
    assert number_text(-0.001, 2) == "0.00"
    assert number_text(-1.5, 1) == "\N{MINUS SIGN}1.5"
    assert number_text(float("nan"), 1) == "–"


@pytest.mark.parametrize(("span", "wanted"), [(100.0, 0), (10.0, 1), (1.0, 2), (0.02, 4)])
def test_decimals_tell_a_hundredth_of_the_span(span, wanted):
    assert decimals_for(span) == wanted


def test_an_axis_contains_its_data_with_round_ends():
    low, high = round_ends(-1.93, 4.1)
    assert low <= -1.93
    assert high >= 4.1
    assert (low, high) == (-3.0, 5.0)


def test_noise_does_not_move_the_axis():
    axis = SteadyRange()
    rng = np.random.default_rng(1)
    ends = {axis.follow(-1.0, 1.0, 0.0)}
    for step in range(300):
        ends.add(axis.follow(-1.0 + 0.02 * rng.random(), 1.0 - 0.02 * rng.random(), step / 60))
    assert len(ends) == 1


def test_the_axis_widens_at_once_and_shrinks_after_a_while():
    axis = SteadyRange()
    axis.follow(-1.0, 1.0, 0.0)
    wide = axis.follow(-1.0, 30.0, 0.1)
    assert wide[1] >= 30.0
    assert axis.follow(-1.0, 1.0, 0.2) == wide
    assert axis.follow(-1.0, 1.0, 0.2 + 0.9 * AXIS_SHRINK_DELAY_S) == wide
    assert axis.follow(-1.0, 1.0, 0.3 + AXIS_SHRINK_DELAY_S)[1] < 5.0


def test_a_constant_has_room_around_it():
    low, high = SteadyRange().follow(4.7, 4.7, 0.0)
    assert low < 4.7 < high


def test_numbers_at_the_ends_of_curves_are_moved_apart():
    assert spread_positions([10.0, 10.0, 50.0], 0.0, 100.0, 12.0) == [10.0, 22.0, 50.0]
    assert spread_positions([99.0, 100.0], 0.0, 100.0, 12.0) == [88.0, 100.0]


def test_an_axis_of_angles_has_its_numbers_at_parts_of_a_turn(qapp):
    """So that -180 degrees is one of them; a narrow axis, and one of dB, have decimal steps."""
    axis = NumberAxis("left")
    axis.setStyle(tickFont=qapp.font())
    for name, low, high, step in (
        ("Phase °", -370.0, -130.0, 90.0),
        ("Phase °", -8.0, 8.0, 5.0),
        ("Magnitude dB", -60.0, 60.0, 50.0),
    ):
        axis.show_name(name)
        (spacing, ticks), *_ = axis.tickValues(low, high, 66.0)
        assert spacing == step and all(tick % step == 0.0 for tick in ticks)


@pytest.mark.parametrize("noise", [0.0, 3e-12])
def test_values_that_are_all_zero_have_plain_ticks_and_others_a_range_of_their_size(noise):
    """A range of a thousandth around zero had ticks of 0.0005."""
    for chart, wanted in ((1e-3, 1.0), (0.1, 1.0)):
        low, high = round_ends(-noise, noise, chart)
        assert high - low >= wanted and low <= -0.5 and high >= 0.5
    low, high = round_ends(5.0, 5.0 + noise, 1e-3)
    assert low <= 4.75 and high >= 5.25 and high - low < 1.0
    low, high = round_ends(0.0, 0.002, 1e-3)  # small, but not flat
    assert high - low < 0.005
