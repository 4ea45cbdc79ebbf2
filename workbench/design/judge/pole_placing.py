"""Find gains of a loop that move a closed-loop pole to a target, or as near as possible.

Newton's method moves the pole to the target. Derivatives of the pole by the gains are differences
of eigenvalues of the sampled closed loop. Each step is the smallest relative change of the gains
within their limits.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from workbench.common.errors import WorkbenchError
from workbench.design.judge.loop_response import closed_poles
from workbench.design.judge.modes import natural_poles
from workbench.design.linear.model import LinearModel
from workbench.scenario.parameters import ParameterTable

Gains = Mapping[str, float]
ModelOf = Callable[[Gains], LinearModel]
"""Function that returns the sampled closed loop for all gains."""
DIFFERENCE = 1e-4
"""Relative change of gains for a derivative."""
SAME = 1e-2
"""Relative difference of poles up to which they count as equal: loops about x and y are often
alike."""
REAL = 1e-6
"""Relative imaginary part up to which a pole counts as real."""
STEP = 0.15
"""Largest relative move of a pole in a step, so that it can be tracked."""
MOST = 0.5
"""Largest relative change of a gain in a step."""
KNOWN = 0.5
"""Relative deviation from the prediction of its derivatives up to which a pole is the same."""
HALVINGS = 4
NEARER = 1e-3
"""Relative progress of a step below which the search ends."""
STEPS = 60
EXACT = 1e-3
"""Relative tolerance of the target."""
RIDGE = 1e-3
"""Weight of the size of the change, to select the smallest one that reaches the target."""
UNMOVED = 0.02
"""Relative move of a pole, for doubling a gain, below which gains have no effect on it."""
LEAST = 1e-3
"""Value used for a gain of 0, as a share of its largest value."""


@dataclass(frozen=True)
class Placed:
    """Gains of a loop, and the pole with them.

    Attributes:
        gains: of the loop, and linked ones, by name.
        pole: its value [1/s].
        reached: whether it is at the target, to `EXACT`.
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

    Each search begins at the previous target, so that dragging is fast.

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
        self._sizes = np.maximum(np.abs(self._k), LEAST * self._high)
        self._pole = self._nearest(self._poles(self._k), pole)
        self._moved = False
        self._is_real = abs(self._pole.imag) < REAL * abs(self._pole)

    def values(self, k: np.ndarray) -> dict[str, float]:
        """Return the gains of unknowns (n), with linked ones."""
        found = dict(zip(self._names, map(float, k), strict=True))
        for name, other in self._linked.items():
            if name in found:
                found[other] = found[name]
        return found

    def place(self, target: complex) -> Placed:
        """Return gains for which the pole is at a target [1/s], or nearest to it.

        A single real pole stays real; for a pair, the target is for the upper one.
        """
        target = complex(target.real, 0.0 if self._is_real else abs(target.imag))
        k, pole = self._k, self._pole
        limit = ""
        for _ in range(STEPS):
            missing = target - pole
            if abs(missing) < EXACT * abs(target):
                break
            slopes = self._slopes(k, pole)
            moves = float(np.abs(slopes * self._sizes).max()) / max(abs(pole), 1e-9)
            wanted = missing * min(1.0, STEP * max(abs(pole), STEP * abs(target)) / abs(missing))
            found = self._stepped(k, pole, slopes, wanted) if moves > UNMOVED else None
            if found is None:
                break
            if abs(target - found[1]) > abs(missing) * (1.0 - NEARER):
                limit = found[2] or limit
                break
            k, pole, limit = found
            self._moved = True
        self._k, self._pole = k, pole
        reached = abs(target - pole) < EXACT * abs(target)
        return Placed(
            self.values(k), pole, reached, "" if reached else limit, not self._moved and not limit
        )

    def _stepped(
        self, k: np.ndarray, pole: complex, slopes: np.ndarray, wanted: complex
    ) -> tuple[np.ndarray, complex, str] | None:
        """Return the gains after a step, the pole with them, and a gain that is at its limit.

        Return None if the pole is not found near the prediction of its derivatives.
        """
        for _ in range(HALVINGS):
            step, limit = self._step(k, slopes, wanted)
            step *= min(1.0, MOST / max(float(np.abs(step / self._sizes).max()), 1e-12))
            way = complex(slopes @ step)
            other = np.clip(k + step, self._low, self._high)
            found = self._nearest(self._poles(other), pole + way)
            if abs(found - pole - way) <= KNOWN * abs(way):
                return other, found, limit
            wanted *= 0.5
        return None

    def _step(self, k: np.ndarray, slopes: np.ndarray, wanted: complex) -> tuple[np.ndarray, str]:
        """Return a change of the gains (n), and a gain that is at its limit."""
        scaled = slopes * self._sizes / max(abs(wanted), 1e-12)
        rows = np.vstack([scaled.real, scaled.imag, RIDGE * np.eye(len(k))])
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
        """
        model = self._model(k)
        z, right = np.linalg.eig(model.A)
        ways, lasting = np.full(len(z), np.inf), z != 0.0
        ways[lasting] = np.abs(np.log(z[lasting].astype(complex)) / model.period - pole)
        alike = ways <= ways.min() + SAME * abs(pole)
        left = np.linalg.pinv(right)[alike]
        slopes = np.zeros(len(k), dtype=complex)
        for place, size in enumerate(self._sizes):
            step = DIFFERENCE * size
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
