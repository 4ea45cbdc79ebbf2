"""The visible part of a chart's curves: its time window, and the ends of its axes."""

import math
from collections.abc import Sequence

from workbench.gui.charts.ticks import Scale, round_step

MIN_WINDOW_S = 0.02
"""Shortest time window [s]; of a logarithmic axis, in decades."""
MAX_FOLLOWED_WINDOW_S = 180.0
"""Longest time window that follows a flight [s]: the signals keep no more."""
MAX_PAUSED_WINDOW_S = 7200.0
"""Longest paused time window [s], for a long log."""
AXIS_SHRINK_DELAY_S = 2.0
"""Time for which data must be small before the axis shrinks [s]."""
AXIS_SHRINK_SHARE = 0.5
"""Share of the range that data must leave free before the axis shrinks."""
ROUND_RANGE_PARTS = 5
"""Number of parts of a range for round ends."""
MIN_LOG_AXIS_DECADES = 0.1
"""Least number of decades of a logarithmic value axis."""
FLAT_ZERO_RANGE, FLAT_RANGE_SHARE = 1.0, 0.1
"""Shown range of values that are all zero, and of equal ones as a share of their size."""
FLAT_TOLERANCE = 1e-9
"""Values are equal within this share of their size, or of 1 if they are smaller."""
AxisEnds = tuple[float, float]


class SteadyRange:
    """Round ends around data: they widen at once, and shrink only after some time.

    Args:
        smallest: shown range if the data hardly vary.
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
            if self._ends is not None and wanted[1] - wanted[0] > AXIS_SHRINK_SHARE * (
                kept[1] - kept[0]
            ):
                wanted = min(wanted[0], kept[0]), max(wanted[1], kept[1])
                wanted = round_ends(*wanted, self._smallest, room=0.0)
            self._ends, self._small_since = wanted, math.inf
        elif wanted[1] - wanted[0] <= AXIS_SHRINK_SHARE * (self._ends[1] - self._ends[0]):
            self._small_since = min(self._small_since, now)
            if now - self._small_since >= AXIS_SHRINK_DELAY_S:
                self._ends, self._small_since = wanted, math.inf
        else:
            self._small_since = math.inf
        return self._ends


def round_ends(
    low: float, high: float, smallest: float = 0.0, room: float = 0.04
) -> tuple[float, float]:
    """Return round numbers around two values, with a margin of a share of the range."""
    size = max(abs(low), abs(high))
    if smallest and high - low <= FLAT_TOLERANCE * max(size, 1.0):  # numerical noise has no ticks
        flat = FLAT_RANGE_SHARE * size if size > FLAT_TOLERANCE else FLAT_ZERO_RANGE
        smallest = max(smallest, flat)
    span = max(high - low, smallest, 1e-9 * size, 1e-12)
    middle, half = 0.5 * (low + high), 0.5 * span
    low, high = min(low, middle - half) - room * span, max(high, middle + half) + room * span
    step = 0.5 * round_step(high - low, ROUND_RANGE_PARTS)
    return step * math.floor(low / step + 1e-6), step * math.ceil(high / step - 1e-6)


class ChartWindow:
    """The visible part of the curves.

    Args:
        span: length of the time window that follows the flight [s].
        smallest: shown range of values if the data hardly vary.

    Attributes:
        span: length of the time window that follows the flight [s].
        with_zero: whether zero is always visible.
        x_scale: scale of the horizontal axis, for moving and zooming.
        y_scale: scale of the value axes.
    """

    def __init__(self, span: float, smallest: float) -> None:
        self.span = span
        self._smallest = smallest
        self.with_zero = False
        self.x_scale = self.y_scale = Scale.LINEAR
        self._still: AxisEnds | None = None
        self._fixed: dict[int, AxisEnds] = {}
        self._ranges: dict[int, SteadyRange] = {}

    @property
    def follows(self) -> bool:
        """Whether the window follows the newest samples."""
        return self._still is None

    def ends(self, now: float) -> AxisEnds:
        """Return the first and last visible time [s]."""
        return self._still or (now - self.span, now)

    def stand(self, now: float) -> None:
        """Stop following."""
        self._still = self.ends(now)

    def follow(self) -> None:
        """Follow the newest samples; the axes follow the data."""
        self._still = None
        self.release_values()

    def show(self, left: float, right: float) -> None:
        """Stop at a time window [s]."""
        first, last = self.x_scale.place(left), self.x_scale.place(right)
        middle, half = 0.5 * (first + last), 0.5 * abs(last - first)
        half = min(max(half, 0.5 * MIN_WINDOW_S), 0.5 * MAX_PAUSED_WINDOW_S)
        self._stay(middle - half, middle + half)

    def move(self, share: float, now: float) -> None:
        """Move by a share of the window."""
        first, last = self._places(now)
        way = share * (last - first)
        self._stay(first + way, last + way)

    def zoom_time(self, about: float, factor: float, now: float) -> None:
        """Scale the window by a factor; while it follows, the newest sample stays at the edge."""
        if self.follows:
            self.span = min(max(self.span * factor, 0.5), MAX_FOLLOWED_WINDOW_S)
            return
        first, last = self._places(now)
        factor = min(max((last - first) * factor, MIN_WINDOW_S), MAX_PAUSED_WINDOW_S) / (
            last - first
        )
        at = self.x_scale.place(about)
        self._stay(at - (at - first) * factor, at + (last - at) * factor)

    def time_at(self, share: float, now: float) -> float:
        """Return the time at a share of the width [s]."""
        first, last = self._places(now)
        return self.x_scale.value_of(first + share * (last - first))

    def time_from(self, time: float, share: float, now: float) -> float:
        """Return the time that is a share of the width after another, within the window [s]."""
        first, last = self._places(now)
        place = self.x_scale.place(time) + share * (last - first)
        return self.x_scale.value_of(min(max(place, first), last))

    def _places(self, now: float) -> AxisEnds:
        left, right = self.ends(now)
        return self.x_scale.place(left), self.x_scale.place(right)

    def _stay(self, first: float, last: float) -> None:
        """Stop between two positions."""
        self._still = self.x_scale.value_of(first), self.x_scale.value_of(last)

    def zoom_values(self, axes: Sequence[AxisEnds], share: float, factor: float) -> None:
        """Scale the values of all axes by a factor, around a share of the height."""
        for index, ends in enumerate(axes):
            low, high = map(self.y_scale.place, ends)
            at = low + share * (high - low)
            self._fix(index, at - (at - low) * factor, at + (high - at) * factor)

    def cut_values(self, axes: Sequence[AxisEnds], low: float, high: float) -> None:
        """Show the values between two shares of the height, on all axes."""
        if high - low > 0.98:
            return
        for index, ends in enumerate(axes):
            least, largest = map(self.y_scale.place, ends)
            span = largest - least
            self._fix(index, least + low * span, least + high * span)

    def _fix(self, axis: int, low: float, high: float) -> None:
        """Fix an axis between two positions."""
        self._fixed[axis] = self.y_scale.value_of(low), self.y_scale.value_of(high)

    def values(self, axis: int, low: float, high: float, now: float) -> AxisEnds:
        """Return the shown ends of an axis with data between two values."""
        if axis in self._fixed:
            return self._fixed[axis]
        if self.y_scale is Scale.LOGARITHMIC:
            kept = self._ranges.setdefault(axis, SteadyRange(MIN_LOG_AXIS_DECADES))
            first, last = kept.follow(self.y_scale.place(low), self.y_scale.place(high), now)
            return self.y_scale.value_of(first), self.y_scale.value_of(last)
        if self.with_zero and math.isfinite(low):
            low, high = min(low, 0.0), max(high, 0.0)
        return self._ranges.setdefault(axis, SteadyRange(self._smallest)).follow(low, high, now)

    def release_values(self) -> None:
        """Let the axes follow the data again."""
        self._fixed.clear()
        self.forget_ranges()

    def forget_ranges(self) -> None:
        """Recompute the ends of the axes that follow the data."""
        self._ranges.clear()
