"""What a curve amounts to within the window that is seen."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class WindowStatistics:
    """A curve in a few numbers, in its own unit; NaN where there are no samples.

    Attributes:
        last: newest value.
        least: smallest one.
        largest: largest one.
        mean: of the samples.
        rms: root of the mean square.
        deviation: standard deviation, of the samples themselves.
    """

    last: float = math.nan
    least: float = math.nan
    largest: float = math.nan
    mean: float = math.nan
    rms: float = math.nan
    deviation: float = math.nan


def window_statistics(
    time: np.ndarray, values: np.ndarray, left: float, right: float
) -> WindowStatistics:
    """Return the statistics of the samples from a time to another [s], what is not finite left out.

    Args:
        time: of the samples (n), rising [s].
        values: (n).
        left: first time that counts [s].
        right: last time that counts [s].
    """
    seen = values[np.searchsorted(time, left) : np.searchsorted(time, right, side="right")]
    seen = np.asarray(seen[np.isfinite(seen)], dtype=float)
    if len(seen) == 0:
        return WindowStatistics()
    return WindowStatistics(
        last=float(seen[-1]),
        least=float(seen.min()),
        largest=float(seen.max()),
        mean=float(seen.mean()),
        rms=math.sqrt(float(np.dot(seen, seen)) / len(seen)),
        deviation=float(seen.std()),
    )


def value_at(time: np.ndarray, values: np.ndarray, when: float) -> float:
    """Return the value of the sample nearest to a time [s]; NaN outside of the samples."""
    if len(time) == 0:
        return math.nan
    step = (time[-1] - time[0]) / max(1, len(time) - 1)
    if not time[0] - step <= when <= time[-1] + step:
        return math.nan
    after = min(int(np.searchsorted(time, when)), len(time) - 1)
    before = max(after - 1, 0)
    nearest = before if when - time[before] < time[after] - when else after
    return float(values[nearest])
