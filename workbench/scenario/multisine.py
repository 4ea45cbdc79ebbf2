"""A multisine: a periodic sum of sines with a low crest factor, to measure a response."""

import math
from dataclasses import dataclass

import numpy as np

LINES_PER_DECADE = 14
"""Number of sines per decade of frequencies, evenly spaced on a logarithmic scale."""
PHASE_TRIALS = 64
"""Number of sets of random phases; the one with the lowest crest factor is used."""
AMPLITUDE_SLOPE = 1.0
"""Amplitudes fall with this power of the frequency, as slow turbulence and drift are strongest."""


@dataclass(frozen=True)
class Multisine:
    """One period of a multisine, a whole number of samples.

    Attributes:
        values: (N), with a unit rms.
        lines: (F) waves in a period of each sine, rising.
        spacing: time between samples [s].
    """

    values: np.ndarray
    lines: np.ndarray
    spacing: float

    @property
    def period(self) -> float:
        """Period [s]."""
        return len(self.values) * self.spacing

    @property
    def frequency(self) -> np.ndarray:
        """Frequency of each line (F) [rad/s]."""
        found: np.ndarray = 2.0 * math.pi * self.lines / self.period
        return found


def multisine(lowest: float, highest: float, spacing: float) -> Multisine:
    """Return a multisine; equal arguments yield equal numbers.

    It has odd harmonics only. Even nonlinearities, such as the square in thrust and lift, then only
    produce even harmonics and do not disturb the measured ones (Pintelon and Schoukens, System
    Identification, 2nd edition, 2012, section 4.3). Its phases are random, with the lowest crest
    factor of `PHASE_TRIALS`; Schroeder's phases are no better for lines evenly spaced on a
    logarithmic scale.

    Args:
        lowest: frequency, which determines the period [rad/s].
        highest: frequency, below half the sampling rate [rad/s].
        spacing: time between samples [s].
    """
    count = math.ceil(2.0 * math.pi / lowest / spacing)
    most = max(1, min(math.floor(highest / lowest), (count - 1) // 2))
    wanted = np.geomspace(1.0, most, 1 + math.ceil(LINES_PER_DECADE * math.log10(most)))
    lines = np.unique(2 * (wanted / 2.0).astype(int) + 1)
    lines = lines[lines <= most]
    sizes = lines**-AMPLITUDE_SLOPE
    sizes /= math.sqrt(0.5 * float(sizes @ sizes))
    draw = np.random.Generator(np.random.PCG64(0))
    turns = 2.0 * math.pi * np.outer(lines, np.arange(count)) / count
    tried = []
    for _ in range(PHASE_TRIALS):
        phases = draw.uniform(0.0, 2.0 * math.pi, len(lines))
        tried.append(sizes @ np.cos(turns + phases[:, None]))
    best = min(tried, key=lambda values: float(np.abs(values).max()))
    return Multisine(best, lines, spacing)
