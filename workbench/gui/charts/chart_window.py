"""Which part of time and of the values a chart shows: following, or standing still."""

import math
from collections.abc import Sequence

from workbench.gui.charts.ticks import round_step

SHORTEST = 0.02
"""Time that can be zoomed to [s]."""
LONGEST = 180.0
"""Time that is followed, as the signals keep no more [s]."""
WHOLE = 7200.0
"""Time that can be looked at standing, of a long log [s]."""
PATIENCE = 2.0
"""Data have to be this small for so long before the axis shrinks [s]."""
SHRINK = 0.5
"""Share of the range that data have to leave free before the axis shrinks."""
PARTS = 5
"""Into which a range is divided to find round ends."""
Ends = tuple[float, float]


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


class ChartWindow:
    """What is seen of the curves.

    Args:
        span: time that is seen while it follows [s].
        smallest: range of values that is shown where the data hardly move.

    Attributes:
        span: time that is seen while it follows [s].
        with_zero: whether zero is always seen.
    """

    def __init__(self, span: float, smallest: float) -> None:
        self.span = span
        self._smallest = smallest
        self.with_zero = False
        self._still: Ends | None = None
        self._fixed: dict[int, Ends] = {}
        self._ranges: dict[int, SteadyRange] = {}

    @property
    def follows(self) -> bool:
        """Whether the newest samples are seen as they come."""
        return self._still is None

    def ends(self, now: float) -> Ends:
        """Return the first and last time that are seen [s]."""
        return self._still or (now - self.span, now)

    def stand(self, now: float) -> None:
        """Follow no longer."""
        self._still = self.ends(now)

    def follow(self) -> None:
        """Follow the newest samples, with axes that follow the data."""
        self._still = None
        self.release_values()

    def show(self, left: float, right: float) -> None:
        """Stand still at a part of time [s]."""
        middle, half = 0.5 * (left + right), 0.5 * abs(right - left)
        half = min(max(half, 0.5 * SHORTEST), 0.5 * WHOLE)
        self._still = middle - half, middle + half

    def move(self, share: float, now: float) -> None:
        """Move on by a share of what is seen."""
        left, right = self.ends(now)
        way = share * (right - left)
        self._still = left + way, right + way

    def zoom_time(self, about: float, factor: float, now: float) -> None:
        """Show a factor of the time; while it follows, the newest sample stays at the edge."""
        if self.follows:
            self.span = min(max(self.span * factor, 0.5), LONGEST)
            return
        left, right = self.ends(now)
        span = min(max((right - left) * factor, SHORTEST), WHOLE)
        factor = span / (right - left)
        self._still = about - (about - left) * factor, about + (right - about) * factor

    def zoom_values(self, axes: Sequence[Ends], share: float, factor: float) -> None:
        """Show a factor of the values of all axes, about a share of the height."""
        for index, (low, high) in enumerate(axes):
            about = low + share * (high - low)
            self._fixed[index] = (about - (about - low) * factor, about + (high - about) * factor)

    def cut_values(self, axes: Sequence[Ends], low: float, high: float) -> None:
        """Show the values between two shares of the height, of all axes."""
        if high - low > 0.98:
            return
        for index, (least, largest) in enumerate(axes):
            span = largest - least
            self._fixed[index] = (least + low * span, least + high * span)

    def values(self, axis: int, low: float, high: float, now: float) -> Ends:
        """Return the ends of an axis whose data lie between two values, as shown."""
        if axis in self._fixed:
            return self._fixed[axis]
        if self.with_zero and math.isfinite(low):
            low, high = min(low, 0.0), max(high, 0.0)
        return self._ranges.setdefault(axis, SteadyRange(self._smallest)).follow(low, high, now)

    def release_values(self) -> None:
        """Let the axes follow the data again."""
        self._fixed.clear()
        self.forget_ranges()

    def forget_ranges(self) -> None:
        """Let the axes that follow the data find their ends anew."""
        self._ranges.clear()
