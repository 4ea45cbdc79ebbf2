"""A smooth curve through samples of a value and its slope, with derivatives by gains.

Every number read off a curve (a crossing's time, a peak) comes with its derivatives, by the
implicit function theorem on the very same piece of polynomial.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Carried:
    """A number, and its derivatives by the gains (g)."""

    value: float
    by_gain: np.ndarray

    def __add__(self, other: "Carried") -> "Carried":
        return Carried(self.value + other.value, self.by_gain + other.by_gain)

    def __sub__(self, other: "Carried") -> "Carried":
        return Carried(self.value - other.value, self.by_gain - other.by_gain)

    def __truediv__(self, other: "Carried") -> "Carried":
        ratio = self.value / other.value
        return Carried(ratio, (self.by_gain - ratio * other.by_gain) / other.value)

    def scaled(self, factor: float) -> "Carried":
        """Return a multiple."""
        return Carried(factor * self.value, factor * self.by_gain)


@dataclass(frozen=True)
class Curve:
    """Cubic pieces between samples.

    Attributes:
        time: (N) [s], evenly spaced.
        value: (N).
        slope: (N) by time.
        value_by_gain: (N, g).
        slope_by_gain: (N, g).
    """

    time: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    value_by_gain: np.ndarray
    slope_by_gain: np.ndarray

    def scaled(self, factor: float) -> "Curve":
        """Return a multiple."""
        return Curve(
            self.time,
            factor * self.value,
            factor * self.slope,
            factor * self.value_by_gain,
            factor * self.slope_by_gain,
        )

    @property
    def end(self) -> Carried:
        """The last value."""
        return Carried(float(self.value[-1]), self.value_by_gain[-1])

    def first_crossing(self, level: Carried) -> Carried:
        """Return when the curve, begun below, first reaches a level; NaN if it never does."""
        return self._crossing(np.flatnonzero(self.value[1:] >= level.value)[:1], level)

    def last_crossing(self, level: Carried) -> Carried:
        """Return when the curve last passes a level; NaN if it never does."""
        above = self.value > level.value
        return self._crossing(np.flatnonzero(above[1:] != above[:-1])[-1:], level)

    def highest(self) -> tuple[Carried, Carried]:
        """Return the largest value and its time."""
        piece = int(np.argmax(self.value))
        found = self._peak(piece - 1) or self._peak(piece)
        if found:
            return found
        at = Carried(float(self.time[piece]), np.zeros(self.value_by_gain.shape[1]))
        return Carried(float(self.value[piece]), self.value_by_gain[piece]), at

    def _crossing(self, pieces: np.ndarray, level: Carried) -> Carried:
        """Return the time at which the curve passes a level in a piece, if there is one."""
        if not len(pieces):
            return Carried(float("nan"), np.full(len(level.by_gain), np.nan))
        index = int(pieces[0])
        step = self.time[index + 1] - self.time[index]
        data = self._data(index)
        share = _root(_POWERS @ data - [0.0, 0.0, 0.0, level.value])
        rise = float(_slope(share) @ data) / step
        moved = level.by_gain - _weights(share) @ self._data_by_gain(index)
        return Carried(float(self.time[index] + share * step), moved / rise)

    def _peak(self, index: int) -> tuple[Carried, Carried] | None:
        """Return largest value and time in a piece, if the curve turns there."""
        if (
            not 0 <= index < len(self.time) - 1
            or not self.slope[index] > 0.0 >= self.slope[index + 1]
        ):
            return None
        step = self.time[index + 1] - self.time[index]
        data, by_gain = self._data(index), self._data_by_gain(index)
        cubic = _POWERS @ data
        share = _root(np.polyder(cubic))
        bend = float(np.polyval(np.polyder(cubic, 2), share))
        value = Carried(float(np.polyval(cubic, share)), _weights(share) @ by_gain)
        moved = -(_slope(share) @ by_gain) / bend * step
        return value, Carried(float(self.time[index] + share * step), moved)

    def _data(self, index: int) -> np.ndarray:
        """Return values and slopes (4) at the ends of a piece, slopes by the share of the piece."""
        step = self.time[index + 1] - self.time[index]
        return np.append(self.value[index : index + 2], step * self.slope[index : index + 2])

    def _data_by_gain(self, index: int) -> np.ndarray:
        """Return the same by the gains (4, g)."""
        step = self.time[index + 1] - self.time[index]
        rows = slice(index, index + 2)
        return np.vstack([self.value_by_gain[rows], step * self.slope_by_gain[rows]])


_POWERS = np.array(
    [[2.0, -2.0, 1.0, 1.0], [-3.0, 3.0, -2.0, -1.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
)
"""From a piece's data (values at its ends, slopes at its ends) to its cubic."""


def _weights(share: float) -> np.ndarray:
    """Return how much of each datum (4) the curve has at a share of a piece."""
    weights: np.ndarray = np.array([share**3, share**2, share, 1.0]) @ _POWERS
    return weights


def _slope(share: float) -> np.ndarray:
    """Return the same of the slope by the share."""
    slope: np.ndarray = np.array([3.0 * share**2, 2.0 * share, 1.0, 0.0]) @ _POWERS
    return slope


def _root(polynomial: np.ndarray) -> float:
    """Return the root in 0 .. 1, or the one nearest to it."""
    roots = np.roots(polynomial)
    roots = roots[np.abs(roots.imag) < 1e-6].real
    return float(np.clip(roots[np.argmin(np.abs(roots - 0.5))], 0.0, 1.0))
