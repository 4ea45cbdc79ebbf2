"""Lag and noise of signals in closed form: at a log's begin, and over its gaps."""

import math

import numpy as np
import pytest

from workbench.design.response_metrics import noise_rms, response_lag

LAGS = np.arange(0.0, 0.751, 0.01)


def test_a_lag_needs_samples_behind_the_longest_that_is_tried():
    """What was asked for before a log begins is not known: 0.75 s are not judged."""
    for seconds, known in ((0.7, False), (2.0, True)):
        time = np.arange(0.0, seconds, 0.01)
        found = response_lag(time, np.sin(3.0 * time), np.sin(3.0 * (time - 0.2)), LAGS)
        assert math.isfinite(found) is known
    assert found == pytest.approx(0.2)


def test_noise_does_not_ring_at_a_gap():
    """Another value after a second without samples is no noise; what is fast on each side is."""
    time = np.arange(0.0, 4.0, 0.002)
    time = time[(time < 1.5) | (time > 2.5)]
    values = np.where(time < 2.0, 0.0, 50.0)
    assert noise_rms(time, values) == pytest.approx(0.0, abs=1e-6)
    buzz = 0.3 * np.sin(2.0 * np.pi * 60.0 * time)
    assert noise_rms(time, values + buzz) == pytest.approx(0.3 / math.sqrt(2.0), rel=0.01)
