"""The response of a loop as a function of its gains, in which it is affine, for many sets at once.

The gains are one or two unknowns: the last gain of the loop is one, and the others, which keep
their ratio, are the second: (kp, kd), (kp, ki) and (kp, ki, kd). L(jw) is that without gains, and a
part in proportion to each unknown.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.loop import Loop
from workbench.design.judge.loop_response import growing_poles, loop_responses
from workbench.design.judge.margins import (
    HALF_POWER,
    LoopMargins,
    RobustnessMeasure,
    complementary,
    disk_margins,
    frequency_grid,
    plateaus,
    response_margins,
)
from workbench.design.linear.model import LinearModel
from workbench.parameters.parameter_table import Parameter, ParameterTable

Gains = Mapping[str, float]
ModelOf = Callable[[Gains], LinearModel]
"""Function that returns the sampled closed-loop model for all gains."""
MIN_SHAPED_GAIN_SHARE = 1e-4
"""The smallest value of an unknown, as a share of the largest; 0 has no ratio."""
AFFINE_TOLERANCE = 0.02
"""Largest relative difference for a response to count as affine in its gains."""
USUAL_PHASE_MARGIN_RAD = math.radians(45.0)
"""Phase margin that most loops can have [rad]."""
STABLE_SEARCH_VALUES = 40
"""Number of values of a single gain among which a stable one is searched."""
LINE_FREQUENCY_STRIDE = 4
"""One of this many frequencies of the grid is used for lines."""
PROBE_GAIN_FACTOR = 0.7
"""Factor on a gain, to find how the response depends on it."""


class AffineLoop:
    """One loop, cut where its gains act, with all other gains constant.

    Unknowns (n) are factors on gains that keep their ratio; `own` is that of the present ones.

    Args:
        model_of: returns the closed-loop model.
        loop: the one to shape, cut at its actuator.
        gains: all values.
        table: limits of the gains.
        linked: gains with the same value as one of the loop, by the name of that one.

    Attributes:
        low, high: limits of the unknowns (n).
        own: the present unknowns (n).
        names: for each unknown (n), its first gain.
        basis: L without gains, and what each unknown adds, (1 + n, F).
        is_affine: whether the response is affine in the unknowns.

    Raises:
        WorkbenchError: if the loop has no gains.
    """

    def __init__(
        self,
        model_of: ModelOf,
        loop: Loop,
        gains: Gains,
        table: ParameterTable,
        linked: Mapping[str, str] | None = None,
    ) -> None:
        if not loop.gains:
            raise WorkbenchError(f"loop {loop.name} names no gains, so it cannot be shaped")
        self._model_of, self._point, self._gains = model_of, loop.point("actuator"), dict(gains)
        self._linked = dict(linked or {})
        names = [loop.gains] if len(loop.gains) == 1 else [loop.gains[:-1], loop.gains[-1:]]
        found = [_gain_group([table.find(each) for each in group], gains) for group in names]
        # for each unknown k the gains that keep their ratio, with their values at k = 1
        self._groups = [sizes for sizes, _, _ in found]
        self.low, self.high = np.array([[low, high] for _, low, high in found]).T
        self.own = np.array(
            [1.0 if any(gains[n] for n in sizes) else 0.0 for sizes in self._groups]
        )
        self.names = [next(iter(sizes)) for sizes in self._groups]
        self._look()

    def values(self, k: np.ndarray) -> dict[str, float]:
        """Return the gains of unknowns (n), with linked ones."""
        found = {}
        for group, each in zip(self._groups, k, strict=True):
            for name, size in group.items():
                found[name] = float(each * size)
                if name in self._linked:
                    found[self._linked[name]] = found[name]
        return found

    def margins(self, gains: Gains) -> LoopMargins:
        """Return the exact margins of the loop with some other gains."""
        model = self._model_of({**self._gains, **gains})
        return response_margins(loop_responses(model, [self._point]))[0]

    @property
    def is_single(self) -> bool:
        """Whether it has one unknown."""
        return len(self._groups) == 1

    def rising(self, index: int, count: int) -> np.ndarray:
        """Return values of one unknown, from the smallest to the largest."""
        low = max(self.low[index], MIN_SHAPED_GAIN_SHARE * self.high[index])
        return np.geomspace(low, self.high[index], count)

    def nearest_first(self, k: np.ndarray) -> np.ndarray:
        """Return unknowns (S, n), the nearest to the present gains first."""
        sizes = np.maximum(np.abs(self.own), MIN_SHAPED_GAIN_SHARE * self.high)
        return k[np.argsort(np.linalg.norm((k - self.own) / sizes, axis=1), kind="stable")]

    def response(self, k: np.ndarray) -> np.ndarray:
        """Return L (S, F) for unknowns (S, n)."""
        found: np.ndarray = self.basis[0] + k @ self.basis[1:]
        return found

    def solved(self, phase_margin: float, basis: np.ndarray) -> np.ndarray:
        """Return unknowns (S, 2) with which L is exp(j (phase margin - pi)) at frequencies (S)."""
        wanted = -np.exp(1j * phase_margin) - basis[0]
        first, second = basis[1], basis[2]
        area = (first.conj() * second).imag
        with np.errstate(divide="ignore", invalid="ignore"):
            k = [(wanted.conj() * second).imag / area, (first.conj() * wanted).imag / area]
        found: np.ndarray = np.nan_to_num(
            np.stack(k, axis=1), nan=-1.0, posinf=1e300, neginf=-1e300
        )
        return found

    def bandwidths(self, k: np.ndarray) -> np.ndarray:
        """Return the bandwidth of unknowns (S, n), NaN if unstable or beyond their limits."""
        found = np.full(len(k), math.nan)
        low, high = self.low * (1.0 - 1e-9) - 1e-12, self.high * (1.0 + 1e-9)
        fit = np.flatnonzero(((k >= low) & (k <= high)).all(axis=1))
        response = self.response(k[fit])
        stable = self._growing == np.rint((_encirclement_angle(response) - self._turn) / math.pi)
        if stable.any():
            found[fit[stable]] = _bandwidths(self._grid, response[stable])
        return found

    def phase_or_disk_margins(self, k: np.ndarray, robustness: RobustnessMeasure) -> np.ndarray:
        """Return the phase margins [rad] or disk margins of unknowns (S, n)."""
        of = disk_margins if robustness is RobustnessMeasure.DISK else _phase_margins
        return of(self.response(k))

    def _look(self) -> None:
        """Find the dependence of the response on the gains, on a grid of frequencies."""
        sets = [self.own]
        for index in range(len(self.own)):
            other = self.own.copy()
            other[index] = PROBE_GAIN_FACTOR * other[index] if other[index] else 1.0
            sets.append(other)
        sets.append(np.array([each[i] for i, each in enumerate(sets[1:])]))
        models = [self._model_of({**self._gains, **self.values(each)}) for each in sets]
        loops = [loop_responses(model, [self._point]) for model in models]
        self._grid = frequency_grid(loops[0])
        own, *others, there = (each.at(self._grid)[0] for each in loops)
        steps = [each[i] - self.own[i] for i, each in enumerate(sets[1:-1])]
        parts = [(other - own) / step for other, step in zip(others, steps, strict=True)]
        self.basis = np.stack([own - self.own @ np.array(parts), *parts])
        expected = self.response(sets[-1][None])[0]
        self.is_affine = bool(
            np.all(np.abs(there - expected) <= AFFINE_TOLERANCE * (1.0 + np.abs(there)))
        )
        closed = loops[0].closed
        self._growing = int(np.count_nonzero(growing_poles(closed, loops[0].period)))
        known = self.own
        if self._growing and self.is_affine:
            known = self._stable_unknowns()
        self._turn = _encirclement_angle(self.response(known[None]))[0]

    def _stable_unknowns(self) -> np.ndarray:
        """Return unknowns with a stable closed loop, if a coarse search finds some.

        How often 1 + L turns about 0 tells how many poles grow beside a known number of them; what
        moves along with the loop's gains may grow in the cut loop, too, so it is best known as 0.
        """
        if self.is_single:
            looked = self.rising(0, STABLE_SEARCH_VALUES)[:, None]
        else:
            looked = self.solved(USUAL_PHASE_MARGIN_RAD, self.basis[:, ::LINE_FREQUENCY_STRIDE])
        for k in looked[((looked >= self.low) & (looked <= self.high)).all(axis=1)]:
            if self.margins(self.values(k)).stable:
                self._growing = 0
                return np.asarray(k)
        return self.own


def _encirclement_angle(response: np.ndarray) -> np.ndarray:
    """Return the angle of 1 + L (S, F) about 0 from the lowest frequency to the highest."""
    around = 1.0 + response
    turn: np.ndarray = np.angle(around[:, 1:] * around[:, :-1].conj()).sum(axis=1)
    return turn


def _phase_margins(response: np.ndarray) -> np.ndarray:
    """Return the phase margins (S) of L (S, F), between the frequencies of a grid [rad]."""
    size = np.log(np.maximum(np.abs(response), 1e-300))
    loop, place = np.nonzero((size[:, 1:] > 0.0) != (size[:, :-1] > 0.0))
    first, last = size[loop, place], size[loop, place + 1]
    low, high = response[loop, place], response[loop, place + 1]
    crossing = low + (high - low) * first / (first - last)
    turn = math.pi - np.abs(np.angle(crossing))
    found = np.full(len(response), math.inf)
    np.minimum.at(found, loop, turn)
    return found


def _bandwidths(grid: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Return the bandwidths (S) of L (S, F), between the frequencies of a grid [rad/s]."""
    closed = np.abs(complementary(response))
    plateau = plateaus(grid, response)
    rows = np.arange(len(response))
    over = np.log(np.maximum(closed, 1e-300) / (HALF_POWER * closed[rows, plateau])[:, None])
    falls = (over[:, :-1] > 0.0) & (over[:, 1:] <= 0.0)
    falls &= np.arange(len(grid) - 1) >= plateau[:, None]
    place = np.argmax(falls, axis=1)
    first, last = over[rows, place], over[rows, place + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = first / (first - last)
        found: np.ndarray = grid[place] * (grid[place + 1] / grid[place]) ** share
    return np.where(falls.any(axis=1), found, math.nan)


def _gain_group(rows: list[Parameter], gains: Gains) -> tuple[dict[str, float], float, float]:
    """Return the sizes of gains that keep their ratio, and the ends of their common factor."""
    sizes = {row.name: gains[row.name] for row in rows}
    if not any(sizes.values()):
        sizes[rows[0].name] = rows[0].default or MIN_SHAPED_GAIN_SHARE * rows[0].maximum
    ends = [(row.minimum / size, row.maximum / size) for row in rows if (size := sizes[row.name])]
    return sizes, max(low for low, _ in ends), min(high for _, high in ends)
