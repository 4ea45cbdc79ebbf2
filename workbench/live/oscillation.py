"""Detect oscillations of a vehicle in flight."""

from collections import deque

import numpy as np

ALARM_CHECK_PERIOD_S = 1 / 16
"""Period between checks of everything else [s]."""
SWING_WINDOW_S = 2.0
SWING_PARTS = 3
"""A swing is detected over this time [s], and must be present in each of this number of parts."""
MIN_SWING_TURNS = 4
MAX_SWING_UNEVENNESS = 0.3
"""A swing crosses its mean at least this often, at times with at most this relative spread."""


class OscillationDetector:
    """Detects a steady swing in a signal.

    Args:
        least: least amplitude to each side.
        seen: observed time [s].
        turns: least number of crossings of the mean.
        uneven: largest spread of the times between crossings, as a share of their mean.
        steady: least ratio of each half wave to the one before.
    """

    def __init__(
        self,
        least: float,
        seen: float = SWING_WINDOW_S,
        turns: int = MIN_SWING_TURNS,
        uneven: float = MAX_SWING_UNEVENNESS,
        steady: float = 0.0,
    ) -> None:
        self._least, self._span = least, seen
        self._turns, self._uneven, self._steady = turns, uneven, steady
        self._seen: deque[tuple[float, float]] = deque()

    def look(self, time: float, value: float) -> None:
        """Add the signal's value at a time [s]."""
        self._seen.append((time, value))
        while self._seen[0][0] < time - self._span - 1e-9:
            self._seen.popleft()

    def clear(self) -> None:
        """Forget all values."""
        self._seen.clear()

    @property
    def turns(self) -> int:
        """Number of crossings of the mean, even or not."""
        return len(self._passes()[2]) if self._seen else 0

    @property
    def frequency(self) -> float:
        """Frequency of the present swing [Hz], 0 for none."""
        if (
            not self._seen
            or self._seen[-1][0] - self._seen[0][0] < self._span - 2.0 * ALARM_CHECK_PERIOD_S
        ):
            return 0.0
        time, value, places = self._passes()
        if len(places) < self._turns:
            return 0.0
        parts = np.array_split(self._about_middle()[1], SWING_PARTS)
        if any(min(part.max(), -part.min()) < self._least for part in parts):
            return 0.0
        gaps = np.diff(time[places])
        if gaps.std() > self._uneven * gaps.mean():
            return 0.0
        # the first and the last half wave are incomplete
        sizes = np.maximum.reduceat(np.abs(value), places)[:-1]
        if (sizes[1:] < self._steady * sizes[:-1]).any():
            return 0.0
        return float(0.5 / gaps.mean())

    def _about_middle(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the times [s] and the signal minus its mean."""
        time, value = np.array(self._seen).T
        return time, value - value.mean()

    def _passes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times and signal outside a dead band, and the indices at which the sign changes.

        The dead band suppresses crossings caused by noise.
        """
        time, value = self._about_middle()
        kept = np.abs(value) > 0.3 * self._least
        time, value = time[kept], value[kept]
        return time, value, 1 + np.flatnonzero(np.diff(np.sign(value)))
