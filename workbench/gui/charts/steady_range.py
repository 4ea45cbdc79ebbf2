"""The range of an axis that follows its data without a jitter."""

import math

from workbench.gui.charts.ticks import round_step

PATIENCE = 2.0
"""Data have to be this small for so long before the axis shrinks [s]."""
SHRINK = 0.5
"""Share of the range that data have to leave free before the axis shrinks."""
PARTS = 5
"""Into which a range is divided to find round ends."""


class SteadyRange:
    """Round ends around data: they widen at once and shrink only after a while.

    Args:
        smallest: range that is shown where data hardly move.
    """

    def __init__(self, smallest: float = 0.1) -> None:
        self._smallest = smallest
        self._ends: tuple[float, float] | None = None
        self._small_since = math.inf

    def follow(self, low: float, high: float, now: float) -> tuple[float, float]:
        """Return the ends for data between two values at a time [s]."""
        if not (math.isfinite(low) and math.isfinite(high)):
            return self._ends or (-1.0, 1.0)
        wanted = round_ends(low, high, self._smallest)
        if self._ends is None or low < self._ends[0] or high > self._ends[1]:
            kept = self._ends or wanted
            if self._ends is not None and wanted[1] - wanted[0] > SHRINK * (kept[1] - kept[0]):
                wanted = min(wanted[0], kept[0]), max(wanted[1], kept[1])
                wanted = round_ends(*wanted, self._smallest, room=0.0)
            self._ends, self._small_since = wanted, math.inf
        elif wanted[1] - wanted[0] <= SHRINK * (self._ends[1] - self._ends[0]):
            self._small_since = min(self._small_since, now)
            if now - self._small_since >= PATIENCE:
                self._ends, self._small_since = wanted, math.inf
        else:
            self._small_since = math.inf
        return self._ends

    def forget(self) -> None:
        """Begin anew with the next data."""
        self._ends, self._small_since = None, math.inf


def round_ends(
    low: float, high: float, smallest: float = 0.0, room: float = 0.04
) -> tuple[float, float]:
    """Return round numbers around two, with a share of room besides."""
    span = max(high - low, smallest, 1e-9 * max(abs(low), abs(high)), 1e-12)
    middle, half = 0.5 * (low + high), 0.5 * span
    low, high = min(low, middle - half) - room * span, max(high, middle + half) + room * span
    step = 0.5 * round_step(high - low, PARTS)
    return step * math.floor(low / step + 1e-6), step * math.ceil(high / step - 1e-6)
