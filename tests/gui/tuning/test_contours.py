import numpy as np
import pytest

from workbench.gui.tuning.contours import contour_levels, contour_segments, value_range


def test_a_line_of_equal_value_lies_where_the_value_is():
    x, y = np.meshgrid(np.arange(11.0), np.arange(11.0))
    pieces = contour_segments(np.hypot(x - 5.0, y - 5.0), 3.0)
    ends = np.array(pieces).reshape(-1, 2)
    assert len(pieces) > 12
    assert np.hypot(*(ends - 5.0).T) == pytest.approx(3.0, abs=0.1)


def test_there_is_no_line_beside_what_was_lost():
    values = np.tile(np.arange(5.0), (5, 1))
    values[2, 2] = np.nan
    for x0, y0, x1, y1 in contour_segments(values, 1.5):
        assert not (1.0 < (y0 + y1) / 2.0 < 3.0)
        assert x0 == x1 == 1.5


def test_levels_are_round_and_inside():
    assert contour_levels(0.0, 10.0, 5) == (2.0, 4.0, 6.0, 8.0)
    assert contour_levels(0.31, 0.58, 5) == pytest.approx((0.4, 0.5))
    assert contour_levels(3.0, 3.0, 5) == ()


def test_a_few_values_far_away_do_not_hide_the_others():
    values = np.linspace(0.0, 10.0, 100).reshape(10, 10)
    assert value_range(values) == (0.0, 10.0)
    values[9, 5:] = 1e6
    low, high = value_range(values)
    assert low == 0.0
    assert high < 10.0


def test_a_map_of_nothing_has_no_range():
    assert value_range(np.full((3, 3), np.nan)) == (0.0, 0.0)
