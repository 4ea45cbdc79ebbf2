"""A swing is told apart from what decays, by signals in closed form."""

import numpy as np
import pytest

from workbench.live.oscillation import OscillationDetector

FREQUENCY = 2.0
TIME = np.arange(0.0, 4.0, 1 / 128)


def seen(value, end, **options):
    """Return the frequency that a detector tells of a signal until a time [Hz]."""
    detector = OscillationDetector(0.2, seen=3.0, **options)
    many = int(np.searchsorted(TIME, end))
    for time, now in zip(TIME[:many], value[:many], strict=True):
        detector.look(float(time), float(now))
    return detector.frequency


def test_a_steady_swing_is_told_wherever_its_last_half_wave_is_cut_off(case):
    """Each half wave is at least 0.8 of the one before, however little there is of the last one."""
    value = np.sin(2.0 * np.pi * FREQUENCY * TIME)
    for end in np.arange(3.2, 3.7, 0.03):
        with case(end):
            assert seen(value, end, steady=0.8) == pytest.approx(FREQUENCY, rel=0.02)


def test_a_swing_that_decays_by_more_than_the_least_ratio_is_none():
    decay = -np.log(0.9) * 2.0 * FREQUENCY  # to 0.9 in half a wave
    value = 2.0 * np.exp(-decay * TIME) * np.sin(2.0 * np.pi * FREQUENCY * TIME)
    assert seen(value, 3.4, steady=0.8) == pytest.approx(FREQUENCY, rel=0.02)
    assert seen(value, 3.4, steady=0.95) == 0.0


def test_what_moves_to_one_side_alone_is_no_swing():
    """Pulses of 1 in 15 % of the time: less than 0.2 below their mean, the least to either side."""
    pulses = (FREQUENCY * TIME % 1.0 < 0.15).astype(float)
    assert seen(pulses, 3.4, uneven=2.0) == 0.0
    assert seen(pulses * 2.0, 3.4, uneven=2.0) == pytest.approx(FREQUENCY, rel=0.1)
