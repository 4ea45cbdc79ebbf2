"""The disk margin of several loops at once.

Margins with one loop opened at a time assume that the others do not change. In coupled loops, small
changes of all may cause what a large change of one does not: P. Seiler, A. Packard, P. Gahinet, An
introduction to disk margins, IEEE Control Systems Magazine 40 (5), 2020, of which this is section 5
with skew 0. Gain and phase of each loop change by f = (2 + δ) / (2 - δ) with its own complex |δ| <
α. The system stays stable up to

    α = 1 / max μ(S - I/2) = 2 / max μ(S - T)

over frequency. μ is the structured singular value for a complex diagonal. It is replaced by min σ(D
M D⁻¹) over positive diagonal D, which equals μ for up to three loops and is an upper bound for
more, so α is never overestimated.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import UNSTABLE_LOOP_MARGINS, frequency_grid, response_margins
from workbench.design.linear.model import LinearModel, frequency_response

_BALANCINGS = 30
"""Number of iterations that balance rows and columns."""
_PEAK_ZOOM_STEPS = 4
_PEAK_ZOOM_POINTS = np.linspace(0.0, 1.0, 9)
_MAX_SCALE_EVALUATIONS = 200
"""Largest number of matrices whose size the search for scales computes, for each of them."""
_BOUND_TOLERANCE = 1e-5
"""Relative error of the bound at the worst frequency."""


@dataclass(frozen=True)
class MultiloopMargin:
    """The margin of several loops when all of them change at once.

    For an unstable closed loop margins are 0, and the frequency is NaN.

    Attributes:
        disk_margin: α, see above: the gain of each loop may change by any factor between (2 - α) /
            (2 + α) and its inverse, while its phase changes as well.
        frequency: of the smallest margin [rad/s].
        alone: disk margin of each loop with the others unchanged, by name.
    """

    disk_margin: float
    frequency: float
    alone: dict[str, float]


def multiloop_margin(model: LinearModel, points: Sequence[str] = ()) -> MultiloopMargin:
    """Return the margin of a closed loop at several points at once.

    Args:
        model: sampled or continuous, with an output and an input of the same name at each point.
        points: their names; empty for all inputs.
    """
    names = list(points) or [signal.name for signal in model.inputs]
    loops = loop_responses(model, names)
    found = response_margins(loops)
    alone = {name: each.disk_margin for name, each in zip(names, found, strict=True)}
    if not loops.stable:
        return MultiloopMargin(UNSTABLE_LOOP_MARGINS.disk_margin, float("nan"), alone)

    def difference(frequency: np.ndarray) -> np.ndarray:
        """Return S - T (F, k, k): the closed loop from the injection is -T."""
        return np.eye(len(names)) + 2.0 * frequency_response(model, frequency, names, names)

    size, frequency = largest_bound(difference, frequency_grid(loops))
    return MultiloopMargin(2.0 / size, frequency, alone)


def largest_bound(
    response: Callable[[np.ndarray], np.ndarray], grid: np.ndarray
) -> tuple[float, float]:
    """Return the largest bound on μ of a response over frequency, and where it is [rad/s].

    Args:
        response: matrices (F, k, k) at frequencies (F).
        grid: frequencies (F) close to every peak; the search continues between them.
    """
    size, at = _largest_of(response(grid))
    low, high = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
    frequency = float(grid[at])
    for _ in range(_PEAK_ZOOM_STEPS):
        finer = low + (high - low) * _PEAK_ZOOM_POINTS
        value, at = _largest_of(response(finer))
        if value >= size:
            size, frequency = value, float(finer[at])
        low, high = finer[max(at - 1, 0)], finer[min(at + 1, len(finer) - 1)]
    return size, frequency


def _largest_of(matrices: np.ndarray) -> tuple[float, int]:
    """Return the largest bound on μ of matrices (F, k, k), and its index.

    Balancing bounds all at once; only candidates for the largest are refined.
    """
    scales = _balanced(matrices)
    scaled = matrices * np.exp(scales[:, :, None] - scales[:, None, :])
    bounds = np.linalg.norm(scaled, 2, axis=(1, 2))
    best, place = 0.0, int(np.argmax(bounds))
    for index in np.argsort(-bounds):
        if bounds[index] <= best * (1.0 + _BOUND_TOLERANCE):
            break
        value = structured_singular_value(matrices[index], scales[index])
        if value > best:
            best, place = value, int(index)
    return best, place


def _balanced(matrices: np.ndarray) -> np.ndarray:
    """Return the log of scales (F, k) that balance rows and columns (Osborne, 1960)."""
    sizes = np.abs(matrices) ** 2
    count = matrices.shape[-1]
    sizes[:, range(count), range(count)] = 0.0
    logs = np.zeros(matrices.shape[:2])
    for _ in range(_BALANCINGS):
        for k in range(count):
            weights = np.exp(2.0 * (logs - logs[:, k : k + 1]))
            into = (sizes[:, k, :] / np.maximum(weights, 1e-300)).sum(axis=1)
            out = (sizes[:, :, k] * weights).sum(axis=1)
            both = (into > 0.0) & (out > 0.0)
            ratio = np.where(both, out, 1.0) / np.where(both, into, 1.0)
            logs[:, k] += 0.25 * np.log(ratio)
    return logs


def structured_singular_value(matrix: np.ndarray, scale: np.ndarray | None = None) -> float:
    """Return the smallest σ(D M D⁻¹) over positive diagonal D, an upper bound on μ.

    It is convex in log D (Sezginer and Overton, 1990), so the minimum is global.

    Args:
        matrix: M (k, k).
        scale: initial log of D (k).
    """
    start = np.zeros(len(matrix)) if scale is None else scale - scale[-1]

    def size(free: np.ndarray) -> float:
        logs = np.append(free, 0.0)
        scaled = matrix * np.exp((logs[:, None] - logs[None, :]).clip(-300.0, 300.0))
        return float(np.linalg.svd(scaled, compute_uv=False)[0])

    if len(matrix) == 1:
        return size(start[:-1])
    corners = np.vstack([start[:-1], start[:-1] + 0.3 * np.eye(len(matrix) - 1)])
    return minimise_simplex(size, corners, 1e-5, _BOUND_TOLERANCE * size(start[:-1]))


class _EnoughError(Exception):
    """A search has computed as many values as it may."""


def minimise_simplex(
    function: Callable[[np.ndarray], float], corners: np.ndarray, near: float, flat: float
) -> float:
    """Return the lowest value of a function, by the method of Nelder and Mead (1965).

    It makes the steps of scipy's `minimize`, which takes longer to load than to run.

    Args:
        function: of n numbers.
        corners: the first simplex (n + 1, n).
        near: it ends where all corners are within this of the best one,
        flat: .. and so are their values within this.
    """
    values = np.full(len(corners), np.inf)
    left = _MAX_SCALE_EVALUATIONS * corners.shape[1]

    def called(at: np.ndarray) -> float:
        nonlocal left
        if not left:
            raise _EnoughError
        left -= 1
        return function(at)

    with suppress(_EnoughError):
        for index, corner in enumerate(corners):
            values[index] = called(corner)
        while left:
            order = np.argsort(values)
            corners, values = corners[order], values[order]
            close = np.abs(corners[1:] - corners[0]).max() <= near
            if close and np.abs(values[0] - values[1:]).max() <= flat:
                break
            _replace_worst(called, corners, values)
    return float(values.min())


def _replace_worst(
    function: Callable[[np.ndarray], float], corners: np.ndarray, values: np.ndarray
) -> None:
    """Replace the last corner by a better one, or shrink the simplex, in place."""
    middle, worst = np.add.reduce(corners[:-1], 0) / corners.shape[1], corners[-1]
    corner = 2.0 * middle - worst
    value = function(corner)
    if value < values[0]:
        farther = 3.0 * middle - 2.0 * worst
        there = function(farther)
        if there < value:
            corner, value = farther, there
    elif value >= values[-2]:
        outside, reflected = value < values[-1], value
        corner = 1.5 * middle - 0.5 * worst if outside else 0.5 * middle + 0.5 * worst
        value = function(corner)
        if value > reflected if outside else value >= values[-1]:
            for index in range(1, len(corners)):
                corners[index] = corners[0] + 0.5 * (corners[index] - corners[0])
                values[index] = function(corners[index])
            return
    corners[-1], values[-1] = corner, value
