"""Reduces thousands of samples to two visible points per column of pixels."""

import math

import numpy as np

from workbench.gui.ring import RowRingBuffer

DecimatedPoints = tuple[np.ndarray, np.ndarray]
"""Times [s] and values."""


def reduce_columns(
    time: np.ndarray, values: np.ndarray, first: int, last: int, width: float
) -> DecimatedPoints:
    """Return the least and largest value of each column of time, in order of time.

    Columns are at whole multiples of their width, so that a scrolling picture does not flicker: a
    sample keeps the same neighbours.

    Args:
        time: times of the samples (n), increasing [s].
        values: (n); values that are not finite count only in a column without others.
        first: index of the first column.
        last: index after the last column.
        width: width of a column [s].
    """
    cuts = np.searchsorted(time, width * np.arange(first, last + 1))
    filled = cuts[:-1] < cuts[1:]
    starts, lasts = cuts[:-1][filled], cuts[1:][filled] - 1
    if len(starts) == 0:
        return time[:0], values[:0]
    places = np.repeat(np.arange(first, last)[filled], 2) + 0.25
    places[1::2] += 0.5  # keeps the direction of a slope
    seen = values[: lasts[-1] + 1]
    if np.isfinite(seen).all():
        least, largest = np.minimum.reduceat(seen, starts), np.maximum.reduceat(seen, starts)
    else:
        seen = np.where(np.isfinite(seen), seen, np.nan)
        least, largest = np.fmin.reduceat(seen, starts), np.fmax.reduceat(seen, starts)
    rises = seen[starts] <= seen[lasts]
    drawn = np.empty(2 * len(starts))
    drawn[0::2] = np.where(rises, least, largest)
    drawn[1::2] = np.where(rises, largest, least)
    return places * width, drawn


class ColumnReducer:
    """The columns of one curve; reduced columns are kept while time passes."""

    def __init__(self) -> None:
        self._width = 0.0
        self._first = self._next = 0
        self._ring = RowRingBuffer(0, 2)

    def reduce(
        self, time: np.ndarray, values: np.ndarray, left: float, right: float, columns: int
    ) -> DecimatedPoints:
        """Return the points to draw for samples: the samples themselves if they are few.

        Args:
            time: times of the samples within the window (n), increasing [s].
            values: (n).
            left: first visible time [s].
            right: last visible time [s].
            columns: number of columns.
        """
        if len(time) <= 2 * columns:
            return time, values
        width = (right - left) / columns
        first, newest = math.floor(left / width), math.floor(float(time[-1]) / width)
        if width != self._width or newest < self._next or first < self._first:
            self._width, self._first, self._next = width, first, first
            self._ring = RowRingBuffer(2 * columns + 6, 2)
        if newest > self._next:
            begin = int(time.searchsorted(self._next * width))
            reduced = reduce_columns(time[begin:], values[begin:], self._next, newest, width)
            self._ring.append(np.column_stack(reduced))
            self._next = newest
        begin = int(time.searchsorted(newest * width))  # the column that is not full yet
        rows = self._ring.rows(left - width)
        return (
            np.concatenate((rows[:, 0], time[begin:])),
            np.concatenate((rows[:, 1], values[begin:])),
        )
