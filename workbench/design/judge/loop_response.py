"""Open loops over frequency, from the eigenvalues of the closed and of the cut system.

1 + L(z) = det(zI - A) / det(zI - A_cut), a ratio of products over eigenvalues: after two
eigenvalue problems a frequency costs a microsecond, and no transfer function is expanded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.design.linear.model import LinearModel

UNREAD = 1e-12
"""A state whose effect on every other one is no larger than this has none."""
INTEGRATOR = 1e-4
"""A pole this near to s = 0 neither grows nor dies out [1/s]: heading and place lie there."""


@dataclass(frozen=True)
class LoopResponses:
    """Open loops L of one closed loop, each cut at another point.

    Attributes:
        period: between samples [s], 0 for continuous time.
        closed: (m) eigenvalues of the closed loop, without those that no cut can change.
        opened: (P, m) of the loop cut at each point.
    """

    period: float
    closed: np.ndarray
    opened: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether the closed loop is; integrators that no loop closes are left out."""
        return growth_rate(self.closed, self.period) < INTEGRATOR

    @property
    def highest(self) -> float:
        """Highest frequency that means something [rad/s]: half the sampling rate."""
        if self.period:
            return float(np.pi / self.period)
        return 100.0 * float(np.abs(np.append(self.opened, self.closed)).max())

    def at(self, frequency: np.ndarray, loop: np.ndarray | None = None) -> np.ndarray:
        """Return L of every loop, (P, F), at frequencies (F) [rad/s].

        With `loop` (K), frequencies are (K, N), and row k is of that loop's own.
        """
        point = 1j * frequency
        if self.period:
            point = np.exp(point * self.period)
        opened = self.opened.T[:, :, None] if loop is None else self.opened.T[:, loop, None]
        # poles along the first axis: products of whole arrays are several times as fast
        over = np.prod(point - self.closed.reshape(-1, *[1] * point.ndim), axis=0)
        under = np.prod(point - opened, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            response: np.ndarray = over / under - 1.0
        return response


def loop_responses(model: LinearModel, points: Sequence[str]) -> LoopResponses:
    """Return the open loops of a model, cut at each of the named points.

    Positions and heading that nothing reads would only blur the eigenvalues near 1; they go first.
    """
    A = np.asarray(model.A, dtype=float)
    cuts = np.array([model.cut(point)[0] for point in points], dtype=float).reshape(-1, *A.shape)
    changed = np.abs(A - cuts).max(axis=0, initial=0.0)
    influence = np.abs(A) + np.abs(cuts).max(axis=0, initial=0.0)
    kept = _read_states(influence, np.diagonal(changed))
    grid = np.ix_(kept, kept)
    eigenvalues = np.linalg.eigvals(np.concatenate([A[None], cuts])[:, grid[0], grid[1]])
    if model.period:
        _cancel_integrators(eigenvalues, model.period)
    return LoopResponses(period=model.period, closed=eigenvalues[0], opened=eigenvalues[1:])


def _cancel_integrators(eigenvalues: np.ndarray, period: float) -> None:
    """Put aside poles at z = 1 that the loop has closed and cut, at whichever point; in place.

    An estimate adds some that no loop moves: places by dead reckoning, biases that none sees. At
    rest they would leave the ratio of two roundings.

    Args:
        eigenvalues: a row of the closed loop, and of each cut one.
        period: between samples [s].
    """
    near = np.abs(eigenvalues - 1.0) < 0.1 * INTEGRATOR * period
    common = int(near.sum(axis=1).min())
    if not common:
        return
    order = np.argsort(np.abs(eigenvalues - 1.0), axis=1)[:, :common]
    np.put_along_axis(eigenvalues, order, 0.0, axis=1)


def closed_poles(model: LinearModel) -> np.ndarray:
    """Return the closed loop's poles (k), without those of states that nothing reads."""
    kept = _read_states(np.abs(model.A), np.zeros(len(model.A)))
    poles: np.ndarray = np.linalg.eigvals(model.A[np.ix_(kept, kept)])
    return poles


def spectral_radius(poles: np.ndarray) -> float:
    """Return the largest |z| of sampled poles."""
    return float(np.abs(poles).max(initial=0.0))


def growth_rates(poles: np.ndarray, period: float) -> np.ndarray:
    """Return how fast each pole grows [1/s]; negative for what dies out."""
    with np.errstate(divide="ignore"):
        rates: np.ndarray = np.log(np.abs(poles)) / period if period else poles.real
    return rates


def growth_rate(poles: np.ndarray, period: float) -> float:
    """Return how fast the fastest growing pole grows [1/s]."""
    return float(growth_rates(poles, period).max(initial=-np.inf))


def _read_states(influence: np.ndarray, changed: np.ndarray) -> np.ndarray:
    """Return which states act on another one, or on one that does; the rest is peeled off.

    Args:
        influence: of each state (columns) on each (m, m).
        changed: of each state on itself (m), by cuts; one that a cut changes stays.
    """
    effect: Any = influence.copy()
    np.fill_diagonal(effect, changed)
    kept = np.arange(len(effect))
    while True:
        read = effect.max(axis=0, initial=0.0) > UNREAD
        if read.all():
            return kept
        kept = kept[read]
        effect = effect[np.ix_(read, read)]
