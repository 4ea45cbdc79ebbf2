"""The frequency response of open loops, from the eigenvalues of the closed and of the cut system.

1 + L(z) = det(zI - A) / det(zI - A_cut), a ratio of products over eigenvalues. After two eigenvalue
problems each frequency costs a microsecond, and no transfer function is needed.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.design.linear.model import LinearModel

MIN_STATE_EFFECT = 1e-12
"""Effect of a state on other states up to which it counts as none."""
MAX_INTEGRATOR_RATE = 1e-4
"""Distance of a pole from s = 0 up to which it counts as an integrator [1/s], such as of heading
and position."""

MAX_DRIFT_RATE = 1e-2
"""Distance of a pole from s = 0 up to which it drifts if it grows [1/s]: the heading, and the place
with it, over minutes, where a static error turns with the heading and the reference does not."""


def decibels(response: np.ndarray) -> np.ndarray:
    """Return the magnitude of a response [dB]."""
    size: np.ndarray = 20.0 * np.log10(np.maximum(np.abs(response), 1e-12))
    return size


@dataclass(frozen=True)
class LoopResponses:
    """Open loops L of one closed loop, each cut at a different point.

    Attributes:
        period: between samples [s], 0 for continuous time.
        closed: (m) eigenvalues of the closed loop, without those that no cut changes.
        opened: (P, m) of the loop cut at each point.
    """

    period: float
    closed: np.ndarray
    opened: np.ndarray

    @property
    def stable(self) -> bool:
        """Whether the closed loop is stable, apart from drift and integrators outside of loops."""
        return not growing_poles(self.closed, self.period).any()

    @property
    def highest(self) -> float:
        """Highest useful frequency [rad/s], half the sampling rate."""
        if self.period:
            return float(np.pi / self.period)
        return 100.0 * float(np.abs(np.append(self.opened, self.closed)).max())

    def at(self, frequency: np.ndarray, loop: np.ndarray | None = None) -> np.ndarray:
        """Return L of every loop, (P, F), at frequencies (F) [rad/s].

        With `loop` (K), frequencies are (K, N), with a row for each of these loops.
        """
        point = 1j * frequency
        if self.period:
            point = np.exp(point * self.period)
        opened = self.opened.T[:, :, None] if loop is None else self.opened.T[:, loop, None]
        # poles along the first axis: products over whole arrays are several times as fast
        over = np.prod(point - self.closed.reshape(-1, *[1] * point.ndim), axis=0)
        under = np.prod(point - opened, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            response: np.ndarray = over / under - 1.0
        return response


def loop_responses(model: LinearModel, points: Sequence[str]) -> LoopResponses:
    """Return the open loops of a model, cut at each of the named points.

    Positions and heading that have no effect would only blur the eigenvalues near 1, and are
    removed first.
    """
    A = np.asarray(model.A, dtype=float)
    cuts = np.array([model.cut(point)[0] for point in points], dtype=float).reshape(-1, *A.shape)
    changed = np.abs(A - cuts).max(axis=0, initial=0.0)
    influence = np.abs(A) + np.abs(cuts).max(axis=0, initial=0.0)
    kept = _effective_states(influence, np.diagonal(changed))
    grid = np.ix_(kept, kept)
    eigenvalues = np.linalg.eigvals(np.concatenate([A[None], cuts])[:, grid[0], grid[1]])
    if model.period:
        _cancel_integrators(eigenvalues, model.period)
    return LoopResponses(period=model.period, closed=eigenvalues[0], opened=eigenvalues[1:])


def _cancel_integrators(eigenvalues: np.ndarray, period: float) -> None:
    """Cancel poles at z = 1 that are in the closed loop and in all cut loops, in place.

    An estimator adds some that no loop affects: positions by dead reckoning, unobservable biases.
    At zero frequency they would leave the ratio of two rounding errors.

    Args:
        eigenvalues: a row for the closed loop, and one for each cut loop.
        period: between samples [s].
    """
    near = np.abs(eigenvalues - 1.0) < 0.1 * MAX_INTEGRATOR_RATE * period
    common = int(near.sum(axis=1).min())
    if not common:
        return
    order = np.argsort(np.abs(eigenvalues - 1.0), axis=1)[:, :common]
    np.put_along_axis(eigenvalues, order, 0.0, axis=1)


def closed_poles(model: LinearModel) -> np.ndarray:
    """Return the poles of the closed loop (k), without those of states that have no effect."""
    kept = places_of_effect(model)
    poles: np.ndarray = np.linalg.eigvals(model.A[np.ix_(kept, kept)])
    return poles


def effective_system(model: LinearModel) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the closed loop without states that have no effect, A (k, k) and names (k)."""
    kept = places_of_effect(model)
    return model.A[np.ix_(kept, kept)], tuple(model.state_names[place] for place in kept)


def places_of_effect(model: LinearModel) -> np.ndarray:
    """Return which states of the closed loop have an effect (k)."""
    return _effective_states(np.abs(model.A), np.zeros(len(model.A)))


def spectral_radius(poles: np.ndarray) -> float:
    """Return the largest |z| of sampled poles."""
    return float(np.abs(poles).max(initial=0.0))


def growth_rates(poles: np.ndarray, period: float) -> np.ndarray:
    """Return the growth rate of each pole [1/s], negative if it decays."""
    with np.errstate(divide="ignore"):
        rates: np.ndarray = np.log(np.abs(poles)) / period if period else poles.real
    return rates


def growing_poles(poles: np.ndarray, period: float) -> np.ndarray:
    """Return which poles grow faster than what drifts (k)."""
    growth = growth_rates(poles, period)
    turn = np.angle(poles) / period if period else poles.imag
    found: np.ndarray = (growth >= MAX_INTEGRATOR_RATE) & (np.hypot(growth, turn) > MAX_DRIFT_RATE)
    return found


def growth_rate(poles: np.ndarray, period: float) -> float:
    """Return the largest growth rate of the poles [1/s], but of a drift if others grow."""
    growth, growing = growth_rates(poles, period), growing_poles(poles, period)
    return float((growth[growing] if growing.any() else growth).max(initial=-np.inf))


def _effective_states(influence: np.ndarray, changed: np.ndarray) -> np.ndarray:
    """Return which states have an effect on other states, directly or indirectly.

    Args:
        influence: of each state (columns) on each other (m, m).
        changed: effect of cuts on each state (m); a state that a cut changes stays.
    """
    effect: Any = influence.copy()
    np.fill_diagonal(effect, changed)
    kept = np.arange(len(effect))
    while True:
        read = effect.max(axis=0, initial=0.0) > MIN_STATE_EFFECT
        if read.all():
            return kept
        kept = kept[read]
        effect = effect[np.ix_(read, read)]
