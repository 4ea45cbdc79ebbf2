"""Noise that follows from seed and time: normal numbers, independent, equal for equal seeds."""

import numpy as np
import pytest
from scipy import stats

from workbench.systems.noise import CountedNoise


def drawn(seed, size=9, samples=4000, period=0.01):
    source = CountedNoise(size, period)
    context = source.CreateDefaultContext()
    context.get_mutable_numeric_parameter(0).SetAtIndex(0, seed)
    found = []
    for number in range(samples):
        context.SetTime(number * period)
        found.append(source.get_output_port().Eval(context).copy())
    return np.array(found)


def test_they_are_standard_normal_and_independent():
    found = drawn(5.0)
    assert stats.kstest(found.ravel(), "norm").pvalue > 0.01
    apart = np.corrcoef(np.hstack([found[1:], found[:-1]]).T) - np.eye(18)
    assert np.abs(apart).max() < 5.0 / np.sqrt(len(found))


def test_they_follow_from_seed_and_time_alone():
    assert drawn(5.0, samples=20).tolist() == drawn(5.0, samples=20).tolist()
    assert drawn(5.0, samples=20)[:, 0] != pytest.approx(drawn(6.0, samples=20)[:, 0])
