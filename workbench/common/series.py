"""A series: one number over time, with its unit and its gaps."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any, Self, cast

import numpy as np

Span = tuple[float, float]
"""Begin and end [s]."""
TimedValues = tuple[np.ndarray, np.ndarray]
"""Times [s], increasing, and values, (n) each."""
SIGNAL_GAP_PERIODS = 2.5
"""Number of periods between two samples from which on there is a gap."""
MIN_RATE_SAMPLES = 2
"""Smallest number of samples of a series with a rate."""
TIME_SLACK_S = 1e-9
"""Times that differ by less are equal [s]."""


class TimedArrays:
    """Base of a dataclass of arrays over time, of which one is `time` (n) [s]."""

    def only(self, kept: np.ndarray | slice) -> Self:
        """Return some rows, of a mask (n) or a slice, of all arrays with n rows."""
        data: Any = self
        count = len(data.time)
        arrays = {each.name: getattr(data, each.name) for each in fields(data)}
        parts = {
            name: each[kept]
            for name, each in arrays.items()
            if isinstance(each, np.ndarray) and len(each) == count
        }
        return cast(Self, replace(data, **parts))

    def between(self, start: float, end: float) -> Self:
        """Return the samples with start <= time <= end [s]."""
        data: Any = self
        return self.only((data.time >= start - TIME_SLACK_S) & (data.time <= end + TIME_SLACK_S))


def spans(said: Iterable[Any]) -> tuple[Span, ...]:
    """Return spans read from JSON.

    Raises:
        TypeError, ValueError: if they are no pairs of numbers.
    """
    return tuple((float(begin), float(end)) for begin, end in said)


@dataclass(frozen=True, eq=False)
class Series(TimedArrays):
    """One number over time, or a text of each message of a topic.

    Attributes:
        name: of a signal TOPIC.FIELD.
        unit: SI; 1 for none, "" if unknown.
        time: of the samples, increasing (n) [s].
        values: (n); NaN or "" where a message has no such field.
        rate: measured samples per second [Hz]; 0 if unknown.
        delay: of the values [s]; None if unknown.
        gaps: times without measurements, each from a sample to the next one, or from the last one
            to the end of the record; ordered.
        source: what it is called in the log of another program; "" if that is its name.
    """

    name: str
    unit: str
    time: np.ndarray
    values: np.ndarray
    rate: float = 0.0
    delay: float | None = None
    gaps: tuple[Span, ...] = ()
    source: str = ""

    def at(self, time: np.ndarray, bridge: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Return values (m) at increasing times (m) [s], and whether each is known (m).

        Between neighbouring samples they are interpolated linearly. In gaps longer than `bridge`
        [s], and before the first and after the last sample, they are NaN and not known.
        """
        if len(self.time) == 0:
            return np.full(len(time), np.nan), np.zeros(len(time), bool)
        known = (time >= self.time[0] - TIME_SLACK_S) & (time <= self.time[-1] + TIME_SLACK_S)
        for begin, end in self.gaps:
            if end - begin > bridge + TIME_SLACK_S:
                known &= (time <= begin + TIME_SLACK_S) | (time >= end - TIME_SLACK_S)
        values = np.interp(time, self.time, self.values)
        return np.where(known, values, np.nan), known & np.isfinite(values)

    def between(self, start: float, end: float) -> "Series":
        """Return the samples with start <= time <= end [s], and the gaps that reach into it."""
        gaps = tuple((a, b) for a, b in self.gaps if a < end and b > start)
        return replace(super().between(start, end), gaps=gaps)

    def with_gaps(self) -> "Series":
        """Return the series with a NaN in each gap, so that no curve is drawn across it."""
        if not self.gaps:
            return self
        middles = [0.5 * (begin + end) for begin, end in self.gaps]
        places = np.searchsorted(self.time, middles)
        return replace(
            self,
            time=np.insert(self.time, places, middles),
            values=np.insert(self.values.astype(float), places, np.nan),
        )

    def since(self, zero: float) -> "Series":
        """Return the series with times relative to one of them [s]."""
        gaps = tuple((begin - zero, end - zero) for begin, end in self.gaps)
        return replace(self, time=self.time - zero, gaps=gaps)

    def copy(self) -> "Series":
        """Return the series with arrays of its own, where these are views that change."""
        return replace(self, time=self.time.copy(), values=self.values.copy())

    def known_share(self, begin: float, end: float) -> float:
        """Return the share of a time span [s] outside of gaps."""
        if not len(self.time) or not end > begin:
            return 0.0
        outside = ((begin, float(self.time[0])), (float(self.time[-1]), end))
        lost = [min(b, end) - max(a, begin) for a, b in {*self.gaps, *outside}]
        return max(0.0, 1.0 - sum(each for each in lost if each > 0.0) / (end - begin))


def make_series(
    name: str,
    unit: str,
    time: np.ndarray,
    values: np.ndarray,
    *,
    end: float | None = None,
    rate: float | None = None,
    delay: float | None = None,
    breaks: Iterable[Span] = (),
) -> Series:
    """Return a series, with the rate and gaps of its times.

    Samples that are not numbers, or without a time, are left out. A gap is where two samples are
    `SIGNAL_GAP_PERIODS` periods or more apart, the period being the median, or where the clock
    started again.

    Args:
        name: TOPIC.FIELD.
        unit: SI.
        time: (n) [s]; where it does not increase, samples are left out.
        values: (n).
        end: of the record [s]; a series that ends earlier has a gap up to it.
        rate: of the series, if it is not that of the times [Hz].
        delay: of the values [s].
        breaks: times around restarts of the clock [s].
    """
    time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    good = np.isfinite(values) & np.isfinite(time)
    time, values = time[good], values[good]
    rising = np.ones(len(time), dtype=bool)
    rising[1:] = time[1:] > np.maximum.accumulate(time)[:-1]
    time, values = time[rising], values[rising]
    if len(time) < MIN_RATE_SAMPLES:
        gap = ((float(time[-1]), end),) if len(time) and end is not None and end > time[-1] else ()
        return Series(name, unit, time, values, rate or 0.0, delay, gap)
    steps = np.diff(time)
    period = float(np.median(steps))
    wide = steps >= SIGNAL_GAP_PERIODS * period
    for before, after in breaks:
        last = int(np.searchsorted(time, 0.5 * (before + after))) - 1
        if 0 <= last < len(wide):
            wide[last] = True
    gaps = [(float(time[i]), float(time[i + 1])) for i in np.nonzero(wide)[0]]
    if end is not None and end - time[-1] >= SIGNAL_GAP_PERIODS * period:
        gaps.append((float(time[-1]), end))
    return Series(name, unit, time, values, rate or 1.0 / period, delay, tuple(gaps))


def interpolated_on_grid(time: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return samples (n, ...) interpolated linearly at other times (m) [s]; the ends are held."""
    flat = values.reshape(len(values), -1)
    columns = [np.interp(grid, time, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(len(grid), *values.shape[1:])


def held_on_grid(time: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return the last sample (n, ...) at each of other times (m) [s]."""
    place = np.searchsorted(time, grid + TIME_SLACK_S, side="right") - 1
    return values[np.clip(place, 0, len(values) - 1)]
