"""A multisine: a sum of sines that repeats exactly, with a low crest, for measuring a response."""

import math
from dataclasses import dataclass

import numpy as np

LINES_PER_DECADE = 14
"""Sines in a decade of frequencies, evenly spaced in their logarithm."""
TRIES = 64
"""Sets of random phases of which the one with the lowest crest is taken."""
SLOPE = 1.0
"""Sizes fall with this power of the frequency: turbulence and drift are strongest when slow."""


@dataclass(frozen=True)
class Multisine:
    """One period of a multisine, a whole number of samples.

    Attributes:
        values: (N), of unit rms.
        lines: (F) numbers of its sines: waves in a period, rising.
        spacing: time between samples [s].
    """

    values: np.ndarray
    lines: np.ndarray
    spacing: float

    @property
    def period(self) -> float:
        """[s]."""
        return len(self.values) * self.spacing

    @property
    def frequency(self) -> np.ndarray:
        """Of each line (F) [rad/s]."""
        found: np.ndarray = 2.0 * math.pi * self.lines / self.period
        return found


def multisine(lowest: float, highest: float, spacing: float) -> Multisine:
    """Return a multisine; equal arguments give equal numbers.

    It has odd waves only, so that what is nonlinear by the square or another even power, as thrust
    and lift are, makes even ones, and disturbs none that is looked at (Pintelon and Schoukens,
    System Identification, 2nd edition, 2012, section 4.3). Its phases are random, those of the
    lowest crest of `TRIES`; Schroeder's are no better for lines that are even in the logarithm.

    Args:
        lowest: frequency, which decides the period [rad/s].
        highest: frequency, below half the sampling rate [rad/s].
        spacing: time between samples [s].
    """
    count = math.ceil(2.0 * math.pi / lowest / spacing)
    most = max(1, min(math.floor(highest / lowest), (count - 1) // 2))
    wanted = np.geomspace(1.0, most, 1 + math.ceil(LINES_PER_DECADE * math.log10(most)))
    lines = np.unique(2 * (wanted / 2.0).astype(int) + 1)
    lines = lines[lines <= most]
    sizes = lines**-SLOPE
    sizes /= math.sqrt(0.5 * float(sizes @ sizes))
    draw = np.random.Generator(np.random.PCG64(0))
    turns = 2.0 * math.pi * np.outer(lines, np.arange(count)) / count
    tried = []
    for _ in range(TRIES):
        phases = draw.uniform(0.0, 2.0 * math.pi, len(lines))
        tried.append(sizes @ np.cos(turns + phases[:, None]))
    best = min(tried, key=lambda values: float(np.abs(values).max()))
    return Multisine(best, lines, spacing)
