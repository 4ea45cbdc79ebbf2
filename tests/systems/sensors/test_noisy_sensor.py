"""Oracle: Allan deviations of what was asked, in closed form.

White noise of density N has the Allan deviation N / sqrt(t) at the averaging time t, a random walk
driven by the density K has K sqrt(t / 3), and a Gauss-Markov process the one in `markov` (IEEE
Std 952-1997, annex C).
"""

import math

import numpy as np
import pytest

from workbench.plant.sensors import NO_NOISE, Noise
from workbench.systems.sensors.noisy_sensor import (
    DRAWS_PER_CHANNEL,
    first_memory,
    next_memory,
    noise_model,
    noisy,
)

RATE = 204.8
"""Of an IMU [1/s]."""
SLOW = 8.0
"""Of something slower, of which each channel's hour is quickly made [1/s]."""
CHANNELS = 60
WALK = {"dynamic_bias_stddev": 2e-3, "dynamic_bias_correlation_time": 1e9}


def generate(noise, rate, seconds, channels=CHANNELS):
    """Return samples (k, channels) of zero with noise."""
    rng = np.random.default_rng(0)
    model = noise_model([noise] * channels, [1.0] * channels, 1.0 / rate)
    memory, zero = first_memory(channels), np.zeros(channels)
    samples = np.empty((round(rate * seconds), channels))
    for row in samples:
        draws = rng.normal(size=DRAWS_PER_CHANNEL * channels)
        row[:] = noisy(model, zero, memory, draws, 1.0)
        memory = next_memory(model, memory, draws)
    return samples


def allan_deviation(samples, m):
    """Return the overlapping Allan deviation of samples (k, n) at m periods, over all channels."""
    phase = np.vstack([np.zeros(samples.shape[1]), np.cumsum(samples, axis=0)])
    second = phase[2 * m :] - 2.0 * phase[m:-m] + phase[: -2 * m]
    return math.sqrt(np.mean(second**2) / 2.0) / m


def markov(t, density, time):
    """Return the Allan deviation of a Gauss-Markov process at t."""
    share = time / (2.0 * t) * (3.0 - 4.0 * math.exp(-t / time) + math.exp(-2.0 * t / time))
    return math.sqrt((density * time) ** 2 / t * (1.0 - share))


def test_white_noise_of_an_imu_falls_with_the_root_of_the_averaging_time():
    """Sixty channels of a minute each are an hour of samples."""
    samples = generate(Noise(stddev=0.03), RATE, 60.0)
    for m in (1, 2, 5, 20, 100, 500, 2000):
        wanted = 0.03 / math.sqrt(m)
        assert allan_deviation(samples, m) == pytest.approx(wanted, rel=0.05)
    assert np.std(samples) == pytest.approx(0.03, rel=0.005)


def test_a_walk_grows_with_the_root_of_the_averaging_time():
    samples = generate(Noise(**WALK), RATE, 60.0)
    for m in (20, 100, 500, 2000):
        wanted = 2e-3 * math.sqrt(m / RATE / 3.0)
        assert allan_deviation(samples, m) == pytest.approx(wanted, rel=0.05)


def test_white_noise_and_walk_are_told_apart_in_an_hour():
    samples = generate(Noise(stddev=0.03, **WALK), SLOW, 3600.0)
    found = {}
    for m in (1, 2, 5, 20, 50, 200, 500, 1000, 2000):
        t = m / SLOW
        white, wandering = 0.03 / math.sqrt(m), 2e-3 * math.sqrt(t / 3.0)
        found[m] = allan_deviation(samples, m)
        assert found[m] == pytest.approx(math.hypot(white, wandering), rel=0.05)
    assert math.log2(found[2] / found[1]) == pytest.approx(-0.5, abs=0.02)
    assert math.log2(found[2000] / found[1000]) == pytest.approx(0.5, abs=0.05)


def test_a_drift_with_a_correlation_time_is_a_gauss_markov_process():
    noise = Noise(dynamic_bias_stddev=2e-3, dynamic_bias_correlation_time=4.0)
    settled = generate(noise, SLOW, 1800.0)[500:]
    for m in (5, 20, 50, 100, 250):
        wanted = markov(m / SLOW, 2e-3, 4.0)
        assert allan_deviation(settled, m) == pytest.approx(wanted, rel=0.05)
    assert np.std(settled) == pytest.approx(2e-3 * math.sqrt(4.0 / 2.0), rel=0.05)
    later = round(4.0 * SLOW)
    kept = np.mean(settled[:-later] * settled[later:]) / np.mean(settled**2)
    assert kept == pytest.approx(math.exp(-1.0), abs=0.05)


def test_the_drift_does_not_depend_on_the_rate():
    noise = Noise(dynamic_bias_stddev=0.5, dynamic_bias_correlation_time=4.0)
    for rate in (4.0, 64.0):
        last = 2.0 - 1.0 / rate
        wanted = 0.5 * math.sqrt(2.0 * (1.0 - math.exp(-2.0 * last / 4.0)))
        spread = np.std(generate(noise, rate, 2.0, channels=4000)[-1])
        assert spread == pytest.approx(wanted, rel=0.05)


def test_a_drift_without_a_correlation_time_is_none():
    assert not generate(Noise(dynamic_bias_stddev=2.0), RATE, 1.0).any()


def test_biases_are_drawn_once():
    samples = generate(Noise(bias_mean=0.3, bias_stddev=0.02), RATE, 0.5)
    assert len(samples) > 100
    assert (samples == samples[0]).all()
    draws = np.random.default_rng(0).normal(size=DRAWS_PER_CHANNEL * CHANNELS)
    assert samples[0] == pytest.approx(0.3 + 0.02 * draws[2 * CHANNELS :], abs=1e-15)


def test_biases_have_the_mean_and_the_deviation_asked_for():
    (samples,) = generate(Noise(bias_mean=0.3, bias_stddev=0.02), 1.0, 1.0, channels=20_000)
    assert np.mean(samples) == pytest.approx(0.3, abs=0.001)
    assert np.std(samples) == pytest.approx(0.02, rel=0.02)


def test_a_mean_is_an_offset():
    model = noise_model([Noise(mean=0.7), NO_NOISE], [1.0, 1.0], 1.0)
    values = noisy(model, np.array([1.0, 2.0]), first_memory(2), np.ones(6), 1.0)
    assert values.tolist() == [1.7, 2.0]


@pytest.mark.parametrize(("exact", "shown"), [(1.12, 1.0), (1.13, 1.25), (-0.4, -0.5)])
def test_samples_are_rounded_to_the_precision(exact, shown):
    model = noise_model([Noise(precision=0.25), NO_NOISE], [1.0, 1.0], 1.0)
    values = noisy(model, np.array([exact, exact]), first_memory(2), np.zeros(6), 1.0)
    assert values.tolist() == [shown, exact]


def test_a_fault_multiplies_the_deviation_or_the_usual_one_where_there_is_none():
    model = noise_model([Noise(stddev=0.5), NO_NOISE], [3.0, 3.0], 1.0)
    draws = np.array([1.0, -1.0, 0.0, 0.0, 0.0, 0.0])
    assert noisy(model, np.zeros(2), first_memory(2), draws, 1.0).tolist() == [0.5, 0.0]
    assert noisy(model, np.zeros(2), first_memory(2), draws, 10.0).tolist() == [5.0, -30.0]
