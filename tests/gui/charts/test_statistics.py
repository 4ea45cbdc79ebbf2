"""Statistics of a window by hand and by numpy."""

import math

import numpy as np
import pytest

from workbench.gui.charts.statistics import value_at, window_statistics

TIME = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
VALUES = np.array([9.0, 3.0, -1.0, 4.0, 100.0])


def test_only_samples_within_the_window_count_its_ends_included():
    *ends, mean, rms, deviation = window_statistics(TIME, VALUES, 1.0, 3.0)
    assert ends == [4.0, -1.0, 4.0]
    assert mean == pytest.approx(2.0)
    assert rms == pytest.approx(math.sqrt((9 + 1 + 16) / 3))
    assert deviation == pytest.approx(math.sqrt((1 + 9 + 4) / 3))


def test_long_series_agree_with_numpy():
    values = np.random.default_rng(0).normal(2.0, 3.0, 5000)
    *_, mean, rms, deviation = window_statistics(np.arange(5000) / 100.0, values, 10.0, 20.0)
    seen = values[1000:2001]
    assert mean == pytest.approx(np.mean(seen))
    assert deviation == pytest.approx(np.std(seen))
    assert rms**2 == pytest.approx(mean**2 + deviation**2)


def test_what_is_no_number_is_left_out():
    found = window_statistics(TIME, np.array([1.0, np.nan, np.inf, 3.0, -np.inf]), 0.0, 4.0)
    assert found[:4] == (3.0, 1.0, 3.0, 2.0)


def test_an_empty_window_has_no_numbers():
    assert math.isnan(window_statistics(TIME, VALUES, 1.2, 1.8)[3])
    assert math.isnan(window_statistics(TIME[:0], VALUES[:0], 0.0, 1.0)[0])


@pytest.mark.parametrize(("when", "wanted"), [(1.4, 3.0), (1.6, -1.0), (4.0, 100.0), (-0.4, 9.0)])
def test_the_cursor_reads_the_nearest_sample(when, wanted):
    assert value_at(TIME, VALUES, when) == wanted


def test_the_cursor_reads_nothing_far_from_the_samples():
    assert math.isnan(value_at(TIME, VALUES, 9.0))
    assert math.isnan(value_at(TIME[:0], VALUES[:0], 0.0))
