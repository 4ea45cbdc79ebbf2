"""The crest factor of a multisine beside that of Schroeder's phases."""

import numpy as np

from workbench.scenario.multisine import multisine


def test_its_peaks_are_as_low_as_those_of_schroeders_phases(case):
    """Schroeder, IEEE Transactions on Information Theory 16, 1970, for any amplitudes."""
    for lowest, highest, spacing in (
        (0.5, 50.0, 1 / 128),
        (1.0, 40.0, 1 / 100),
        (2.0, 9.0, 1 / 64),
    ):
        wave = multisine(lowest, highest, spacing)
        parts = np.fft.rfft(wave.values)[wave.lines]
        sizes = 2.0 * np.abs(parts) / len(wave.values)
        shares = sizes**2 / np.sum(sizes**2)
        phases = [-2.0 * np.pi * np.sum((k - np.arange(k)) * shares[:k]) for k in range(len(sizes))]
        turns = 2.0 * np.pi * np.outer(wave.lines, np.arange(len(wave.values))) / len(wave.values)
        his = sizes @ np.cos(turns + np.array(phases)[:, None])
        with case(lowest, highest):
            assert np.std(his) > 0.99  # the same power
            assert np.abs(wave.values).max() <= 1.02 * np.abs(his).max()
