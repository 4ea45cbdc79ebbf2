"""Spectra against scipy.signal.welch and a closed form, and signals that have none."""

import numpy as np
import pytest
import scipy.signal

from workbench.common.errors import WorkbenchError
from workbench.logs.spectrum import WELCH_DETRENDS, WELCH_WINDOWS, WelchSettings, power_spectrum

RATE = 250.0
TIME = 3.0 + np.arange(5000) / RATE
NOISE = np.random.default_rng(3).normal(size=5000) + 2.0 + 0.01 * TIME


def test_a_spectrum_is_that_of_scipy():
    for window in WELCH_WINDOWS:
        for detrend in WELCH_DETRENDS:
            for averages in (1, 7, 32):
                found = power_spectrum(TIME, NOISE, WelchSettings(window, averages, detrend))
                frequency, density = scipy.signal.welch(
                    NOISE,
                    RATE,
                    window,
                    found.segment,
                    detrend=False if detrend == "none" else detrend,
                )
                assert (5000 - found.segment) // (found.segment - found.segment // 2) + 1 in (
                    averages,
                    averages + 1,
                )
                np.testing.assert_allclose(found.frequency, frequency, rtol=1e-9)
                np.testing.assert_allclose(found.density, density, rtol=1e-9, atol=1e-20)
                assert not found.resampled


def test_a_sine_has_its_power_at_its_frequency():
    """Half the square of its amplitude, by the area below the peak."""
    for window in WELCH_WINDOWS:
        found = power_spectrum(
            TIME, 3.0 * np.sin(2 * np.pi * 20.0 * TIME), WelchSettings(window, 3)
        )
        assert found.frequency[found.density.argmax()] == pytest.approx(20.0, abs=0.1)
        near = np.abs(found.frequency - 20.0) < 5.0
        assert np.trapezoid(found.density[near], found.frequency[near]) == pytest.approx(
            4.5, rel=5e-3
        )


def test_single_samples_that_are_missing_or_no_number_are_interpolated():
    wave = np.sin(2 * np.pi * 5.0 * TIME)
    kept = np.ones(5000, dtype=bool)
    kept[[700, 1500, 1501, 3000]] = False
    values = wave.copy()
    values[2500] = np.nan
    found = power_spectrum(TIME[kept], values[kept], WelchSettings())
    whole = power_spectrum(TIME, wave, WelchSettings())
    assert found.resampled
    assert found.rate == pytest.approx(RATE)
    peak = whole.density.argmax()
    assert found.frequency[peak] == pytest.approx(whole.frequency[peak])
    assert found.density[peak] == pytest.approx(whole.density[peak], rel=0.01)


def test_what_has_no_spectrum_is_refused_with_a_sentence():
    random = np.sort(np.random.default_rng(1).uniform(0.0, 10.0, 500))
    table = (
        (TIME[:9], "needs 16 samples, but there are only 9"),
        (np.cumsum(np.tile([0.01, 0.02], 500)), "these come every 0.01 to 0.02 s"),
        (np.zeros(50), "needs rising times"),
    )
    for time, said in table:
        with pytest.raises(WorkbenchError, match=f"imu.x: .*{said}"):
            power_spectrum(time, np.zeros(len(time)), WelchSettings(), "imu.x")
    with pytest.raises(WorkbenchError):
        power_spectrum(random, random, WelchSettings())


def test_the_longest_part_without_a_gap_has_the_spectrum():
    """As the spectrum of that part alone; a short gap is bridged within it."""
    wave = np.sin(2.0 * np.pi * 7.0 * TIME)
    kept = ((TIME < 5.0) | (TIME > 6.0)) & (np.abs(TIME - 9.0) > 0.004)
    found = power_spectrum(TIME[kept], wave[kept], WelchSettings())
    part = kept & (TIME > 6.0)
    alone = power_spectrum(TIME[part], wave[part], WelchSettings())
    assert found.part == (TIME[part][0], TIME[part][-1])
    assert alone.part is None
    assert np.array_equal(found.density, alone.density)
    assert found.frequency[np.argmax(found.density)] == pytest.approx(7.0, abs=0.5)
