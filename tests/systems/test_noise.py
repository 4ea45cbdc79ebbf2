"""Noise that follows from seed and time: normal numbers, independent, equal for equal seeds."""

import numpy as np
import pytest
from scipy import stats

from workbench.dynamics.air.normals import counted_draws
from workbench.plant.sensors import Noise
from workbench.systems.noise import CountedNoise, drawn_sensor_bias, sample_draws


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


@pytest.mark.parametrize("size", [1, 6, 7, 18])
def test_they_are_those_of_compiled_flights(size):
    seed, samples = 4294967295.0, 50
    expected = np.empty((samples, size))
    with np.errstate(over="ignore"):  # the integers wrap around
        for number in range(samples):
            counted_draws(seed, number, expected[number])
    assert drawn(seed, size, samples) == pytest.approx(expected, rel=0.0, abs=1e-15)


def test_the_bias_of_a_sensor_is_no_number_of_its_samples():
    """Otherwise it would vanish from the first sample, or double there."""
    noise = Noise(bias_mean=2.0, bias_stddev=3.0)
    seeds = range(400)
    biases = np.array([drawn_sensor_bias(noise, seed) for seed in seeds])
    assert stats.kstest((biases - 2.0) / 3.0, "norm").pvalue > 0.01
    for number in (0, 1, 2):
        samples = np.array([sample_draws(seed, number).standard_normal(4) for seed in seeds])
        apart = np.corrcoef(biases, samples.T)[0, 1:]
        assert np.abs(apart).max() < 5.0 / np.sqrt(len(seeds))
