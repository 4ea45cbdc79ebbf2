"""Lines of equal value on a grid, by marching squares."""

from collections.abc import Iterator

import numpy as np

Segment = tuple[float, float, float, float]
"""x and y of both ends, in columns and rows of the grid."""
USUAL = 0.8
"""Share of a grid that is told apart where the rest is far away."""


def contour_segments(values: np.ndarray, level: float) -> list[Segment]:
    """Return pieces of the line where a grid has a value; none beside a NaN.

    Args:
        values: (rows, columns).
        level: of the line.
    """
    found: list[Segment] = []
    corners = np.stack([values[:-1, :-1], values[:-1, 1:], values[1:, 1:], values[1:, :-1]])
    above = corners >= level
    crossed = np.isfinite(corners).all(axis=0) & above.any(axis=0) & ~above.all(axis=0)
    for row, column in zip(*np.nonzero(crossed), strict=True):
        points = list(_crossings(corners[:, row, column].tolist(), level))
        for one, other in zip(points[::2], points[1::2], strict=True):
            found.append((column + one[0], row + one[1], column + other[0], row + other[1]))
    return found


def _crossings(corners: list[float], level: float) -> Iterator[tuple[float, float]]:
    """Yield where the line crosses the four sides of a cell, in turns around it."""
    places = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    for index in range(4):
        one, other = corners[index], corners[(index + 1) % 4]
        if (one >= level) != (other >= level):
            share = (level - one) / (other - one)
            (x0, y0), (x1, y1) = places[index], places[(index + 1) % 4]
            yield x0 + share * (x1 - x0), y0 + share * (y1 - y0)


def value_range(values: np.ndarray) -> tuple[float, float]:
    """Return the values between which a grid is worth telling apart.

    A few flights that are nearly lost have numbers so large that all others would look alike: the
    upper end is where four fifths of the grid have passed.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 0.0
    low, usual, high = np.quantile(finite, (0.0, USUAL, 1.0)).tolist()
    return float(low), float(usual if high - low > 3.0 * (usual - low) > 0.0 else high)


def contour_levels(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return about so many round values between two."""
    if high <= low:
        return ()
    rough = (high - low) / count
    power = 10.0 ** np.floor(np.log10(rough))
    step = float(next(f * power for f in (1.0, 2.0, 5.0, 10.0) if f * power >= 0.999 * rough))
    first = np.floor(low / step) + 1.0
    return tuple(float(each) for each in np.arange(first * step, high, step))
