"""The band around a baseline within which a curve may lie."""

from dataclasses import dataclass

import numpy as np

from workbench.design.regress.spec import Tolerance


@dataclass(frozen=True)
class Curve:
    """A signal over time: time (N) from the edge on [s] and its values (N)."""

    time: np.ndarray
    values: np.ndarray


@dataclass(frozen=True)
class Band:
    """Smallest and largest allowed values (N) each."""

    low: np.ndarray
    high: np.ndarray


def band(baseline: Curve, tolerance: Tolerance, time: np.ndarray) -> Band:
    """Return what the baseline sweeps when shifted to and fro, widened by the tolerance.

    Args:
        baseline: the recorded curve, straight between its samples.
        tolerance: how far a curve may be from it.
        time: (N) at which the band is wanted [s].
    """
    amplitude = float(np.abs(baseline.values - baseline.values[0]).max())
    width = max(tolerance.absolute, tolerance.relative * amplitude)
    early, late = time - tolerance.time_shift, time + tolerance.time_shift
    ends = np.stack([np.interp(at, baseline.time, baseline.values) for at in (early, late)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    first = np.searchsorted(baseline.time, early)
    last = np.searchsorted(baseline.time, late, side="right")
    for index, (start, stop) in enumerate(zip(first, last, strict=True)):
        if stop > start:  # a straight piece is extreme at its ends: look at the samples between
            inside = baseline.values[start:stop]
            low[index] = min(low[index], inside.min())
            high[index] = max(high[index], inside.max())
    return Band(low - width, high + width)
