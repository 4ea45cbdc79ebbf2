"""The band around a baseline."""

import numpy as np
import pytest

from workbench.design.regress.band import Curve, band
from workbench.design.regress.spec import Tolerance

TIME = np.linspace(0.0, 2.0, 9)
RAMP = Curve(TIME, 3.0 * TIME)


def test_a_tolerance_widens_the_baseline_both_ways():
    found = band(RAMP, Tolerance(absolute=0.5), TIME)
    assert found.low == pytest.approx(3.0 * TIME - 0.5)
    assert found.high == pytest.approx(3.0 * TIME + 0.5)


def test_a_relative_tolerance_is_a_share_of_the_largest_distance_from_the_start():
    curve = Curve(TIME, 10.0 - 4.0 * TIME)  # from 10 to 2: an amplitude of 8
    found = band(curve, Tolerance(relative=0.05, absolute=0.1), TIME)
    assert found.high - curve.values == pytest.approx(np.full(9, 0.4))


def test_the_larger_of_both_tolerances_counts():
    found = band(RAMP, Tolerance(relative=0.05, absolute=0.9), TIME)
    assert found.high - RAMP.values == pytest.approx(np.full(9, 0.9))


def test_a_ramp_shifted_to_and_fro_sweeps_slope_times_shift():
    found = band(RAMP, Tolerance(time_shift=0.1), TIME)
    assert found.low[1:-1] == pytest.approx(3.0 * TIME[1:-1] - 0.3)
    assert found.high[1:-1] == pytest.approx(3.0 * TIME[1:-1] + 0.3)
    assert (found.low[0], found.high[-1]) == (0.0, 6.0)  # nothing is known beyond the ends


def test_a_peak_within_the_shift_belongs_to_the_band():
    tent = Curve(TIME, 1.0 - np.abs(TIME - 1.0))
    found = band(tent, Tolerance(time_shift=0.3), np.array([0.8, 1.0, 1.2]))
    assert found.high == pytest.approx([1.0, 1.0, 1.0])
    assert found.low == pytest.approx([0.5, 0.7, 0.5])


def test_the_band_is_what_many_shifted_copies_cover():
    random = np.random.default_rng(1)
    time = np.sort(random.uniform(0.0, 5.0, 40))
    curve = Curve(time, random.normal(size=40))
    wanted = np.linspace(0.5, 4.5, 57)
    shift = 0.23
    found = band(curve, Tolerance(time_shift=shift), wanted)
    copies = np.stack(
        [np.interp(wanted + by, time, curve.values) for by in np.linspace(-shift, shift, 4001)]
    )
    assert found.low == pytest.approx(copies.min(axis=0), abs=5e-3)
    assert found.high == pytest.approx(copies.max(axis=0), abs=5e-3)
    assert (found.low <= copies.min(axis=0) + 1e-12).all()
    assert (found.high >= copies.max(axis=0) - 1e-12).all()
