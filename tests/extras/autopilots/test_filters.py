"""The autopilots' filters, beside SciPy's."""

import pytest
import scipy.signal

from workbench.extras.autopilots.filters import butterworth

PERIOD = 1 / 400


@pytest.mark.parametrize("cutoff", [1.0, 30.0, 120.0, 199.0])
def test_a_butterworth_filter_is_scipys(cutoff):
    b, a = scipy.signal.butter(2, cutoff, fs=1.0 / PERIOD)
    assert butterworth(cutoff, PERIOD) == pytest.approx([*b, *a[1:]], rel=1e-9)


@pytest.mark.parametrize("cutoff", [-1.0, 0.0, 200.0, 300.0, 1000.0])
def test_a_cut_off_of_nought_or_beyond_half_the_rate_filters_nothing(cutoff):
    assert butterworth(cutoff, PERIOD) == (1.0, 0.0, 0.0, 0.0, 0.0)
