"""Find gains of a loop that move a closed-loop pole to a target, or as near as possible.

Newton's method moves the pole to the target. Derivatives of the pole by the gains are differences
of eigenvalues of the sampled closed loop. Each step is the smallest relative change of the gains
within their limits.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

from workbench.common.errors import WorkbenchError
from workbench.design.judge.loop_response import closed_poles
from workbench.design.judge.modes import natural_poles
from workbench.design.linear.model import LinearModel
from workbench.parameters.parameter_table import ParameterTable

Gains = Mapping[str, float]
ModelOf = Callable[[Gains], LinearModel]
"""Function that returns the sampled closed loop for all gains."""
GAIN_DIFFERENCE = 1e-4
"""Relative change of gains for a derivative."""
SAME_POLE_TOLERANCE = 1e-2
"""Relative difference of poles up to which they count as equal: loops about x and y are often
alike."""
REAL_POLE_TOLERANCE = 1e-6
"""Relative imaginary part up to which a pole counts as real."""
MAX_POLE_MOVE = 0.15
"""Largest relative move of a pole in a step, so that it can be tracked."""
MAX_GAIN_CHANGE = 0.5
"""Largest relative change of a gain in a step."""
MAX_POLE_DEVIATION = 0.5
"""Relative deviation from the prediction of its derivatives up to which a pole is the same."""
UNMOVED_POLE_SHARE = 1e-2
"""A pole that moves by less, as a share of the expected move of the tracked one, is another."""
MAX_PLACING_HALVINGS = 4
MIN_PLACING_PROGRESS = 1e-3
"""Relative progress of a step below which the search ends."""
MAX_PLACING_STEPS = 60
POLE_TARGET_TOLERANCE = 1e-3
"""Relative tolerance of the target."""
GAIN_CHANGE_WEIGHT = 1e-3
"""Weight of the size of the change, to select the smallest one that reaches the target."""
MIN_POLE_MOVE = 0.02
"""Relative move of a pole, for doubling a gain, below which gains have no effect on it."""
PLACER_ZERO_GAIN_SHARE = 1e-3
"""Value used for a gain of 0, as a share of its largest value."""


@dataclass(frozen=True)
class PlacedPole:
    """Gains of a loop, and the pole with them.

    Attributes:
        gains: of the loop, and linked ones, by name.
        pole: its value [1/s].
        reached: whether it is at the target, to `POLE_TARGET_TOLERANCE`.
        limit: a gain that is at its limit, "" for none.
        unmoved: whether no gain of the loop moves it noticeably.
    """

    gains: dict[str, float]
    pole: complex
    reached: bool
    limit: str = ""
    unmoved: bool = False


class PolePlacer:
    """Moves one pole to targets by the gains of a loop, with all other gains constant.

    A search begins at the previous target, so that dragging is fast, or at the given gains if
    their pole is nearer to the target.

    Args:
        model_of: returns the model with these poles.
        names: of the gains of the loop.
        gains: all values.
        table: limits of the gains.
        pole: its approximate present value, in continuous time [1/s].
        linked: gains with the same value as one of the loop, by the name of that one.

    Raises:
        WorkbenchError: if the loop has no gains.
    """

    def __init__(
        self,
        model_of: ModelOf,
        names: tuple[str, ...],
        gains: Gains,
        table: ParameterTable,
        pole: complex,
        linked: Mapping[str, str] | None = None,
    ) -> None:
        if not names:
            raise WorkbenchError("this loop names no gains, so its poles cannot be moved")
        self._model_of, self._gains, self._linked = model_of, dict(gains), dict(linked or {})
        rows = [table.find(name) for name in names]
        self._names = names
        self._low = np.array([row.minimum for row in rows])
        self._high = np.array([row.maximum for row in rows])
        self._k = np.array([float(gains[name]) for name in names])
        self._sizes = np.maximum(np.abs(self._k), PLACER_ZERO_GAIN_SHARE * self._high)
        self._pole = self._nearest(self._poles(self._k), pole)
        self._given = self._k, self._pole
        self._is_real = abs(self._pole.imag) < REAL_POLE_TOLERANCE * abs(self._pole)

    def values(self, k: np.ndarray) -> dict[str, float]:
        """Return the gains of unknowns (n), with linked ones."""
        found = dict(zip(self._names, map(float, k), strict=True))
        for name, other in self._linked.items():
            if name in found:
                found[other] = found[name]
        return found

    def place(self, target: complex) -> PlacedPole:
        """Return gains for which the pole is at a target [1/s], or nearest to it.

        A single real pole stays real; for a pair, the target is for the upper one.
        """
        target = complex(target.real, 0.0 if self._is_real else abs(target.imag))
        k, pole = min(((self._k, self._pole), self._given), key=lambda at: abs(target - at[1]))
        limit = ""
        for _ in range(MAX_PLACING_STEPS):
            missing = target - pole
            if abs(missing) <= POLE_TARGET_TOLERANCE * abs(target):
                break
            slopes = self._slopes(k, pole)
            wanted = missing * min(
                1.0, MAX_POLE_MOVE * max(abs(pole), MAX_POLE_MOVE * abs(target)) / abs(missing)
            )
            movable = self._is_movable(slopes, pole)
            found = self._stepped(k, pole, slopes, wanted) if movable else None
            if found is None:
                break
            if abs(target - found[1]) > abs(missing) * (1.0 - MIN_PLACING_PROGRESS):
                limit = found[2] or limit
                break
            k, pole, limit = found
        self._k, self._pole = k, pole
        reached = abs(target - pole) <= POLE_TARGET_TOLERANCE * abs(target)
        if reached:
            return PlacedPole(self.values(k), pole, reached)
        return PlacedPole(self.values(k), pole, reached, limit, self._unmoved)

    @cached_property
    def _unmoved(self) -> bool:
        k, pole = self._given
        return not self._is_movable(self._slopes(k, pole), pole)

    def _is_movable(self, slopes: np.ndarray, pole: complex) -> bool:
        moves = float(np.abs(slopes * self._sizes).max()) / max(abs(pole), 1e-9)
        return moves > MIN_POLE_MOVE

    def _stepped(
        self, k: np.ndarray, pole: complex, slopes: np.ndarray, wanted: complex
    ) -> tuple[np.ndarray, complex, str] | None:
        """Return the gains after a step, the pole with them, and a gain that is at its limit.

        Return None if the pole is not found near the prediction of its derivatives.
        """
        poles = self._poles(k)
        for _ in range(MAX_PLACING_HALVINGS):
            step, limit = self._step(k, slopes, wanted)
            step *= min(1.0, MAX_GAIN_CHANGE / max(float(np.abs(step / self._sizes).max()), 1e-12))
            way = complex(slopes @ step)
            other = np.clip(k + step, self._low, self._high)
            found = self._nearest(_moved_poles(poles, self._poles(other), way), pole + way)
            if abs(found - pole - way) <= MAX_POLE_DEVIATION * abs(way):
                return other, found, limit
            wanted *= 0.5
        return None

    def _step(self, k: np.ndarray, slopes: np.ndarray, wanted: complex) -> tuple[np.ndarray, str]:
        """Return a change of the gains (n), and a gain that is at its limit."""
        scaled = slopes * self._sizes / max(abs(wanted), 1e-12)
        rows = np.vstack([scaled.real, scaled.imag, GAIN_CHANGE_WEIGHT * np.eye(len(k))])
        aim = np.array([wanted.real, wanted.imag]) / max(abs(wanted), 1e-12)
        low, high = (self._low - k) / self._sizes, (self._high - k) / self._sizes
        found = lsq_linear(rows, np.append(aim, np.zeros(len(k))), (low - 1e-12, high + 1e-12))
        stopped = np.flatnonzero(found.active_mask)
        return found.x * self._sizes, self._names[stopped[0]] if len(stopped) else ""

    def _slopes(self, k: np.ndarray, pole: complex) -> np.ndarray:
        """Return the derivatives of the pole by the gains (n).

        If several poles coincide, such as those about x and y of a symmetric vehicle, any
        combination of their eigenvectors is valid: the one on which the gains have most effect is
        used.

        Some laws have states only with a gain that is not 0, so a gain is never 0 here.
        """
        k = np.where(k == 0.0, GAIN_DIFFERENCE * self._sizes, k)
        model = self._model(k)
        z, right = np.linalg.eig(model.A)
        ways, lasting = np.full(len(z), np.inf), z != 0.0
        ways[lasting] = np.abs(np.log(z[lasting].astype(complex)) / model.period - pole)
        alike = ways <= ways.min() + SAME_POLE_TOLERANCE * abs(pole)
        left = np.linalg.pinv(right)[alike]
        slopes = np.zeros(len(k), dtype=complex)
        for place, size in enumerate(self._sizes):
            step = GAIN_DIFFERENCE * size
            if k[place] + step > self._high[place]:
                step = -step
            other = k.copy()
            other[place] += step
            turned = left @ (self._model(other).A - model.A) @ right[:, alike] / step
            moved = np.linalg.eigvals(turned)
            at = z[np.argmin(ways)]
            slopes[place] = moved[np.argmax(np.abs(moved))] / (at * model.period)
        return slopes.real.astype(complex) if self._is_real else slopes

    def _model(self, k: np.ndarray) -> LinearModel:
        return self._model_of({**self._gains, **self.values(k)})

    def _poles(self, k: np.ndarray) -> np.ndarray:
        model = self._model(k)
        found = natural_poles(closed_poles(model), model.period)
        return found[found.imag >= -1e-9]

    @staticmethod
    def _nearest(poles: np.ndarray, place: complex) -> complex:
        return complex(poles[np.argmin(np.abs(poles - place))])


def _moved_poles(before: np.ndarray, after: np.ndarray, way: complex) -> np.ndarray:
    """Return the poles that a step of the gains moved, or all poles if it moved none.

    The pole that is nearest to a prediction may be another loop's, if the way leads past its place.
    That one stays where it was.

    Args:
        before: all poles before the step (n) [1/s].
        after: all poles after it (m) [1/s].
        way: expected move of the tracked pole [1/s].
    """
    ways = np.abs(after[:, np.newaxis] - before).min(axis=1)
    moved = ways > UNMOVED_POLE_SHARE * abs(way)
    return after[moved] if moved.any() else after


def state_shares(model: LinearModel, pole: complex) -> np.ndarray:
    """Return the participation of each state in a pole (m), with a sum of 1.

    These are participation factors: products of the entries of its right and left eigenvector
    (Pérez-Arriaga, Verghese and Schweppe, 1982).

    Args:
        model: sampled.
        pole: in continuous time [1/s].
    """
    z, right = np.linalg.eig(model.A)
    place = int(np.argmin(np.abs(z - np.exp(pole * model.period))))
    left = np.linalg.pinv(right)[place]
    size: np.ndarray = np.abs(left * right[:, place])
    return size / size.sum()
