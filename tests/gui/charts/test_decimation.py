"""Peaks survive the reduction to a few points a column, and a gap stays a gap."""

import numpy as np
import pytest

from workbench.gui.charts.decimation import ColumnReducer, reduce_columns


def test_each_column_keeps_its_least_and_largest_value():
    time = np.arange(12) / 12.0
    values = np.array([0, 5, -3, 1, 2, 2, 2, 2, 9, 7, 8, 6.0])
    _, drawn = reduce_columns(time, values, 0, 3, 1 / 3)
    assert drawn.tolist() == [-3, 5, 2, 2, 9, 6]


def test_what_rises_is_drawn_upwards_and_what_falls_downwards():
    time = np.arange(8) / 8.0
    values = np.array([0, 1, 2, 3, 3, 2, 1, 0.0])
    places, drawn = reduce_columns(time, values, 0, 2, 0.5)
    assert drawn.tolist() == [0, 3, 3, 0]
    assert (np.diff(places) > 0).all()


def test_a_column_without_samples_is_left_out():
    time = np.array([0.1, 0.2, 2.1, 2.2])
    places, drawn = reduce_columns(time, np.array([1, 2, 3, 4.0]), 0, 3, 1.0)
    assert drawn.tolist() == [1, 2, 3, 4]
    assert places.tolist() == [0.25, 0.75, 2.25, 2.75]


def test_what_is_no_number_hides_no_neighbour_and_makes_a_gap():
    time = np.arange(9) / 3.0
    values = np.array([1, np.nan, 2, np.nan, np.inf, np.nan, 5, 4, np.nan])
    _, drawn = reduce_columns(time, values, 0, 3, 1.0)
    assert drawn[:2].tolist() == [1, 2]
    assert np.isnan(drawn[2:4]).all()
    assert sorted(drawn[4:].tolist()) == [4, 5]


def test_few_samples_are_drawn_as_they_are():
    time, values = np.arange(10) / 10.0, np.arange(10.0)
    found = ColumnReducer().reduce(time, values, 0.0, 1.0, 100)
    assert found[0] is time
    assert found[1] is values


def whole(seconds):
    time = np.arange(int(200 * seconds)) / 200.0
    noise = np.random.default_rng(3).standard_normal(len(time))
    return time, np.sin(time) + 0.3 * noise


def test_a_window_that_moves_shows_the_same_as_one_that_is_made_anew():
    time, values = whole(12.0)
    kept = ColumnReducer()
    for now in np.arange(6.0, 12.0, 0.05):
        seen = (time >= now - 5.0) & (time <= now)
        moved = kept.reduce(time[seen], values[seen], now - 5.0, now, 100)
        fresh = ColumnReducer().reduce(time[seen], values[seen], now - 5.0, now, 100)
        inside = moved[0] >= now - 5.0 + 0.05  # the column that is half out has lost samples
        ours = dict(zip(moved[0][inside], moved[1][inside], strict=True))
        theirs = dict(zip(fresh[0], fresh[1], strict=True))
        assert ours.items() <= theirs.items()
        assert len(ours) >= 190


def test_the_largest_peak_is_always_drawn():
    time, values = whole(10.0)
    values[1234] = 50.0
    drawn = ColumnReducer().reduce(time, values, 0.0, 10.0, 150)
    assert drawn[1].max() == 50.0
    assert drawn[0][drawn[1].argmax()] == pytest.approx(time[1234], abs=10.0 / 150)
    assert len(drawn[0]) <= 2 * 151 + 14  # and the samples of the column that is not full


def test_a_flight_that_begins_anew_is_not_mixed_with_the_one_before():
    time, values = whole(10.0)
    kept = ColumnReducer()
    kept.reduce(time, values, 0.0, 10.0, 100)
    again = kept.reduce(time[:500], 0.0 * values[:500] + 7.0, -7.5, 2.5, 100)
    assert set(again[1].tolist()) == {7.0}


def test_a_reset_is_noticed_also_where_the_window_begins_later_than_the_first_one():
    time, values = whole(20.0)
    kept = ColumnReducer()
    kept.reduce(time[:1000], values[:1000], -5.0, 5.0, 100)
    kept.reduce(time[2000:], values[2000:], 10.0, 20.0, 100)
    again = kept.reduce(time[:1200], 0.0 * values[:1200] + 7.0, -4.0, 6.0, 100)
    assert set(again[1].tolist()) == {7.0}
    assert len(again[1]) > 100
