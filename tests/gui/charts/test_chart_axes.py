"""Round ends, round marks, and axes that do not jitter."""

import numpy as np
import pytest

from workbench.gui.charts.canvas import spread
from workbench.gui.charts.chart import PATIENCE, SteadyRange, round_ends
from workbench.gui.charts.ticks import decimals_for, decimals_for_step, number_text


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
    assert axis.follow(-1.0, 1.0, 0.2 + 0.9 * PATIENCE) == wide
    assert axis.follow(-1.0, 1.0, 0.3 + PATIENCE)[1] < 5.0


def test_a_constant_has_room_around_it():
    low, high = SteadyRange().follow(4.7, 4.7, 0.0)
    assert low < 4.7 < high


def test_numbers_at_the_ends_of_curves_are_moved_apart():
    assert spread([10.0, 10.0, 50.0], 0.0, 100.0, 12.0) == [10.0, 22.0, 50.0]
    assert spread([99.0, 100.0], 0.0, 100.0, 12.0) == [88.0, 100.0]
