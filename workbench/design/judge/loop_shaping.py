"""Find gains of a loop for a bandwidth and a phase or disk margin, defined as in `LoopMargins`.

The response of a loop cut where its gains act is affine in these gains, so many sets of gains are
judged without a model. For each frequency w and phase margin, two linear equations yield two gains
for which L(jw) = exp(j (phase margin - pi)). These gains, and those along their limits, are lines
in the plane of the gains. Where two neighbours on a line have bandwidths on either side of the
requested one, gains between them have it. These gains, by their ratio, are a section of the plane,
and the requested margin is found between two neighbours of the section. The result is refined with
the exact model.
"""

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import root

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Loop
from workbench.design.judge.loop_response import INTEGRATOR, growth_rates, loop_responses
from workbench.design.judge.margins import (
    HALF_POWER,
    LoopMargins,
    Robustness,
    complementary,
    disk_margins,
    frequency_grid,
    plateaus,
    response_margins,
)
from workbench.design.linear.model import LinearModel
from workbench.scenario.parameters import Parameter, ParameterTable

Gains = Mapping[str, float]
ModelOf = Callable[[Gains], LinearModel]
"""Function that returns the sampled closed-loop model for all gains."""
PHASE_MARGINS = np.radians(np.arange(3.0, 120.0, 3.0))
"""Phase margins of lines of gains [rad]."""
SPARSE = 4
"""One of this many frequencies of the grid is used for lines."""
LINE = 160
"""Number of gains on a line along a limit."""
ONE = 640
"""Number of values of a single gain."""
LEAST = 1e-4
"""The smallest of these values, as a share of the largest; 0 has no ratio."""
EXACT = 1e-3
"""Relative tolerance of the bandwidth of a result."""
EXACTLY = {Robustness.PHASE: math.radians(0.05), Robustness.DISK: 1e-3}
"""Tolerance of its phase margin [rad] or disk margin."""
AFFINE = 0.02
"""Largest relative difference for a response to count as affine in its gains."""
NEARLY = 1.1
"""A margin beyond its reach by less is still tried, as the reach is interpolated between lines;
bandwidths that differ by less count as equal there."""
LITTLE = 1e-3
"""Share of its largest value of a gain that hardly acts; 0 is a special case for a loop."""
AT_ITS_LIMIT = 0.99
"""Share of its largest value from which on a gain limits the bandwidth."""
BISECTIONS = 7
TRIED = 3
"""Largest number of gains to refine for a request."""
USUAL = math.radians(45.0)
"""Phase margin that most loops can have [rad]."""
NOTHING = 0.1
"""Share of the tolerances below which the refinement ends."""
OTHER = 0.7
"""Factor on a gain, to find how the response depends on it."""


@dataclass(frozen=True)
class Reach:
    """The attainable range of one number of a loop, with the other constant.

    Attributes:
        low, high: ends; NaN if nothing is attainable.
        gain: the one whose largest value is the limit at `high`, "" for none.
    """

    low: float
    high: float
    gain: str = ""


@dataclass(frozen=True)
class Shaped:
    """Gains of a loop, with the results.

    Attributes:
        gains: of the loop, and linked ones, by name.
        margins: exact, of the loop with these gains.
        reached: whether bandwidth and phase or disk margin are as requested, to `EXACT`.
        bandwidth: its reach at this phase or disk margin [rad/s].
        robustness: reach of that margin at this bandwidth; both ends are equal for a loop with one
            gain.
    """

    gains: dict[str, float]
    margins: LoopMargins
    reached: bool
    bandwidth: Reach
    robustness: Reach


@dataclass(frozen=True)
class _Asked:
    """The requested bandwidth [rad/s], and unless it follows from that, the margin."""

    bandwidth: float
    robustness: Robustness = Robustness.PHASE
    margin: float | None = None

    def missed(self, margins: LoopMargins) -> tuple[float, float]:
        """Return the difference of margins from the request, in tolerances."""
        if not margins.stable or math.isnan(margins.bandwidth):
            return math.inf, math.inf
        wide = math.log(margins.bandwidth / self.bandwidth) / EXACT
        if self.margin is None:
            return wide, 0.0
        return wide, (self.robustness.of(margins) - self.margin) / EXACTLY[self.robustness]

    def is_reached(self, margins: LoopMargins) -> bool:
        """Return whether margins are as requested."""
        return max(map(abs, self.missed(margins))) < 1.0


class LoopShaper:
    """Finds gains of one loop, with all others constant.

    The last gain of the loop is one unknown; the others keep their ratio and are the second
    unknown, for (kp, kd), (kp, ki) and (kp, ki, kd). For a loop with one gain only the bandwidth
    can be chosen.

    Args:
        model_of: returns the closed-loop model.
        loop: the one to shape, cut at its actuator.
        gains: all values.
        table: limits of the gains.
        linked: gains with the same value as one of the loop, by the name of that one.

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
        found = [_group([table.find(each) for each in group], gains) for group in names]
        # for each unknown k the gains that keep their ratio, with their values at k = 1
        self._groups = [sizes for sizes, _, _ in found]
        self._low, self._high = np.array([[low, high] for _, low, high in found]).T
        self._own = np.array(
            [1.0 if any(gains[n] for n in sizes) else 0.0 for sizes in self._groups]
        )
        self._last_reach: tuple[object, tuple[Reach, np.ndarray]] | None = None
        self._last_line: tuple[float, _Line] | None = None
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

    def shape(
        self, bandwidth: float, margin: float, robustness: Robustness = Robustness.PHASE
    ) -> Shaped:
        """Return gains for a bandwidth and a margin, or for the nearest attainable ones.

        The margin may be larger than requested if the bandwidth requires it; else the bandwidth is
        adjusted to it.

        Args:
            bandwidth: requested [rad/s].
            margin: requested phase margin [rad] or disk margin; for a loop with one gain it
                follows.
            robustness: which of them.

        Raises:
            WorkbenchError: if no gains of the loop make it stable.
        """
        asked = _Asked(bandwidth, robustness, None if self._is_single else margin)
        if not self.is_affine:
            nothing = Reach(math.nan, math.nan)
            return self._shaped(self._polished(self._own, asked), asked, nothing, nothing)
        reach, known = self._bandwidth_reach(asked)
        nearest = float(known[np.argmin(np.abs(np.log(known / bandwidth)))])
        section = self._section(asked)
        if asked.margin is None:
            at = asked
            if not len(section.k):
                at = replace(asked, bandwidth=nearest)
                section = self._section(at)
            k = self._polished(self._nearest_first(section.k)[0], at)
            follows = robustness.of(self.margins(self.values(k)))
            return self._shaped(k, asked, reach, Reach(follows, follows))
        if section.reach.low / NEARLY < margin < section.reach.high * NEARLY:
            for near in self._with_margin(section, margin)[:TRIED]:
                k = self._polished(near, asked)
                found = self._shaped(k, asked, reach, section.reach)
                if found.reached:
                    return found
        own = self._shaped(self._own, asked, reach, section.reach)
        if own.reached:
            return own
        at = asked
        if not len(section.k) or section.reach.high < margin:
            at = replace(asked, bandwidth=nearest)
            section = self._section(at)
        at = replace(at, margin=min(max(margin, section.reach.low), section.reach.high))
        k = self._polished(self._with_margin(section, margin)[0], at)
        return self._shaped(k, asked, reach, section.reach)

    @property
    def _is_single(self) -> bool:
        return len(self._groups) == 1

    @cached_property
    def _lines(self) -> "list[_Line]":
        """Lines of gains: of one phase margin, and along the limits; or all of a single gain."""
        if self._is_single:
            sets = [self._rising(0, ONE)[:, None]]
        else:
            sets = [self._solved(each, self._basis[:, ::SPARSE]) for each in PHASE_MARGINS]
            for held, limit in itertools.product(
                (0, 1), (self._low, LITTLE * self._high, self._high)
            ):
                k = np.full((LINE, 2), limit[held])
                k[:, 1 - held] = self._rising(1 - held, LINE)
                sets.append(k)
        return [self._line(k) for k in sets]

    def _lines_for(self, asked: _Asked) -> "list[_Line]":
        """Return all lines, and that of a requested phase margin at all frequencies."""
        margin = asked.margin
        if margin is None or asked.robustness is Robustness.DISK:
            return self._lines
        if self._last_line is None or self._last_line[0] != margin:
            self._last_line = margin, self._line(self._solved(margin, self._basis))
        return [*self._lines, self._last_line[1]]

    def _line(self, k: np.ndarray) -> "_Line":
        bandwidth = self._bandwidths(k)
        fits = np.isfinite(bandwidth)
        margins = {each: np.full(len(k), math.nan) for each in Robustness}
        for each, values in margins.items():
            values[fits] = self._margins(k[fits], each)
        return _Line(k, bandwidth, margins)

    def _rising(self, index: int, count: int) -> np.ndarray:
        """Return values of one unknown, from the smallest to the largest."""
        low = max(self._low[index], LEAST * self._high[index])
        return np.geomspace(low, self._high[index], count)

    def _section(self, asked: _Asked) -> "_Section":
        """Return gains of the requested bandwidth by their ratio, with their margins."""
        found, bandwidth = [], asked.bandwidth
        for k, value, _ in self._lines_for(asked):
            with np.errstate(invalid="ignore"):
                between = (value[:-1] - bandwidth) * (value[1:] - bandwidth) <= 0.0
            for place in np.flatnonzero(between):
                first, last = value[place], value[place + 1]
                share = (bandwidth - first) / (last - first) if first != last else 0.0
                found.append(k[place] + share * (k[place + 1] - k[place]))
            found += list(k[value == bandwidth])
        k = np.array(found).reshape(-1, len(self._own))
        with np.errstate(invalid="ignore"):  # a bandwidth may jump over the requested one
            k = k[np.abs(np.log(self._bandwidths(k) / bandwidth)) < math.log(NEARLY)]
        k = k[np.argsort(np.arctan2(k[:, -1], k[:, 0]))]
        margins = self._counted(self._margins(k, asked.robustness), asked)
        known = np.isfinite(margins)
        return _Section(k[known], margins[known])

    def _with_margin(self, section: "_Section", margin: float) -> np.ndarray:
        """Return unknowns (C, n) of a section with a margin, or with the nearest if none have it.

        The nearest to the present gains are first.
        """
        k, margins = section.k, section.margins
        have_it = np.abs(margins - margin) <= EXACT * margin
        if have_it.any():
            return self._nearest_first(k[have_it])
        low, high = margins[:-1], margins[1:]
        places = np.flatnonzero(((low - margin) * (high - margin) <= 0.0) & (low != high))
        if not len(places):
            return k[[np.argmin(np.abs(margins - margin))]]
        share = (margin - low[places]) / (high - low)[places]
        return self._nearest_first(k[places] + share[:, None] * (k[places + 1] - k[places]))

    def _bandwidth_reach(self, asked: _Asked) -> tuple[Reach, np.ndarray]:
        """Return the reach of the bandwidth with no less than the requested margin.

        If no gains have that, with the largest one. Also return bandwidths (S) that are known to
        have it, with both ends.

        Raises:
            WorkbenchError: if no gains of the loop make it stable.
        """
        key = asked.robustness, asked.margin
        if self._last_reach is None or self._last_reach[0] != key:  # a slider moves one of both
            self._last_reach = key, self._found_reach(asked)
        return self._last_reach[1]

    def _found_reach(self, asked: _Asked) -> tuple[Reach, np.ndarray]:
        lines = self._lines_for(asked)
        bandwidth = np.concatenate([each.bandwidth for each in lines])
        margins = self._counted(
            np.concatenate([each.margins[asked.robustness] for each in lines]), asked
        )
        most = np.nanmax(margins, initial=-math.inf)
        if math.isinf(most):
            raise WorkbenchError("no gains of this loop make it stable: tune another loop first")
        wanted = -math.inf if asked.margin is None else min(asked.margin, most) * (1.0 - EXACT)
        good = bandwidth[margins >= wanted]
        low = self._edge(replace(asked, bandwidth=float(good.min())), 0.8, wanted)
        high = self._edge(replace(asked, bandwidth=float(good.max())), 1.25, wanted)
        section = self._section(replace(asked, bandwidth=high))
        limited = (section.k[section.margins >= wanted] >= AT_ITS_LIMIT * self._high).any(axis=0)
        gains = [next(iter(group)) for group, at in zip(self._groups, limited, strict=True) if at]
        return Reach(low, high, gains[0] if gains else ""), np.append(good, [low, high])

    def _edge(self, inside: _Asked, step: float, wanted: float) -> float:
        """Return how far a bandwidth goes with no less than a margin, from one that has it."""
        outside = inside.bandwidth * step
        for _ in range(BISECTIONS):
            middle = replace(inside, bandwidth=math.sqrt(inside.bandwidth * outside))
            if (self._section(middle).margins >= wanted).any():
                inside = middle
            else:
                outside = middle.bandwidth
        return inside.bandwidth

    def _look(self) -> None:
        """Find the dependence of the response on the gains, on a grid of frequencies."""
        sets = [self._own]
        for index in range(len(self._own)):
            other = self._own.copy()
            other[index] = OTHER * other[index] if other[index] else 1.0
            sets.append(other)
        sets.append(np.array([each[i] for i, each in enumerate(sets[1:])]))
        models = [self._model_of({**self._gains, **self.values(each)}) for each in sets]
        loops = [loop_responses(model, [self._point]) for model in models]
        self._grid = frequency_grid(loops[0])
        own, *others, there = (each.at(self._grid)[0] for each in loops)
        steps = [each[i] - self._own[i] for i, each in enumerate(sets[1:-1])]
        parts = [(other - own) / step for other, step in zip(others, steps, strict=True)]
        # L without gains, and what each adds, (1 + n, F)
        self._basis = np.stack([own - self._own @ np.array(parts), *parts])
        expected = self._response(sets[-1][None])[0]
        self.is_affine = bool(np.all(np.abs(there - expected) <= AFFINE * (1.0 + np.abs(there))))
        closed = loops[0].closed
        growing = growth_rates(closed, loops[0].period) >= INTEGRATOR
        self._growing = int(np.count_nonzero(growing))
        known = self._own
        if self._growing and self.is_affine:
            known = self._stable_unknowns()
        self._turn = _turn(self._response(known[None]))[0]

    def _stable_unknowns(self) -> np.ndarray:
        """Return unknowns with a stable closed loop, if a coarse search finds some.

        How often 1 + L turns about 0 tells how many poles grow beside a known number of them; what
        moves along with the loop's gains may grow in the cut loop, too, so it is best known as 0.
        """
        if self._is_single:
            looked = self._rising(0, LINE // SPARSE)[:, None]
        else:
            looked = self._solved(USUAL, self._basis[:, ::SPARSE])
        for k in looked[((looked >= self._low) & (looked <= self._high)).all(axis=1)]:
            if self.margins(self.values(k)).stable:
                self._growing = 0
                return np.asarray(k)
        return self._own

    def _response(self, k: np.ndarray) -> np.ndarray:
        """Return L (S, F) for unknowns (S, n)."""
        found: np.ndarray = self._basis[0] + k @ self._basis[1:]
        return found

    def _solved(self, phase_margin: float, basis: np.ndarray) -> np.ndarray:
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

    def _bandwidths(self, k: np.ndarray) -> np.ndarray:
        """Return the bandwidth of unknowns (S, n), NaN if unstable or beyond their limits."""
        found = np.full(len(k), math.nan)
        low, high = self._low * (1.0 - 1e-9) - 1e-12, self._high * (1.0 + 1e-9)
        fit = np.flatnonzero(((k >= low) & (k <= high)).all(axis=1))
        response = self._response(k[fit])
        stable = self._growing == np.rint((_turn(response) - self._turn) / math.pi)
        if stable.any():
            found[fit[stable]] = _bandwidths(self._grid, response[stable])
        return found

    def _margins(self, k: np.ndarray, robustness: Robustness) -> np.ndarray:
        """Return the phase margins [rad] or disk margins of unknowns (S, n)."""
        of = disk_margins if robustness is Robustness.DISK else _phase_margins
        return of(self._response(k))

    @staticmethod
    def _counted(margins: np.ndarray, asked: _Asked) -> np.ndarray:
        """Return margins, NaN for those that do not count: phase margins beyond all lines.

        L hardly exceeds 1 there. The margin of a single gain follows from it, and counts as 0.
        """
        if asked.margin is None:
            return np.where(np.isnan(margins), math.nan, 0.0)
        if asked.robustness is Robustness.DISK:
            return margins
        most = max(asked.margin, PHASE_MARGINS[-1]) * (1.0 + EXACT)
        return np.where(margins <= most, margins, math.nan)

    def _nearest_first(self, k: np.ndarray) -> np.ndarray:
        """Return unknowns (S, n), the nearest to the present gains first."""
        sizes = np.maximum(np.abs(self._own), LEAST * self._high)
        return k[np.argsort(np.linalg.norm((k - self._own) / sizes, axis=1), kind="stable")]

    def _polished(self, k: np.ndarray, asked: _Asked) -> np.ndarray:
        """Return unknowns with which both numbers are exact, if they can be; else as they were."""
        sizes = np.maximum(np.abs(k), LEAST * self._high)

        def missed(scaled: np.ndarray) -> np.ndarray:
            wide, turned = asked.missed(self.margins(self.values(scaled * sizes)))
            if math.isinf(wide):
                return np.full(len(k), 10.0)
            scale = EXACTLY[asked.robustness]
            if max(abs(wide), abs(turned)) < NOTHING:  # at 0 the search ends
                return np.zeros(len(k))
            return np.array([wide * EXACT, turned * scale][: len(k)])

        first = missed(k / sizes)
        if not first.any():
            return k
        found = root(
            missed, k / sizes, method="hybr", options={"eps": 1e-6, "xtol": 1e-4, "maxfev": 24}
        )
        if not np.linalg.norm(missed(found.x)) < np.linalg.norm(first):
            return k
        polished: np.ndarray = found.x * sizes
        return polished

    def _shaped(self, k: np.ndarray, asked: _Asked, bandwidth: Reach, robustness: Reach) -> Shaped:
        gains = self.values(np.clip(k, self._low, self._high))
        margins = self.margins(gains)
        return Shaped(gains, margins, asked.is_reached(margins), bandwidth, robustness)


class _Line(NamedTuple):
    """Unknowns (S, n) along a line, the bandwidth (S) of each, and margins (S).

    They are NaN if the unknowns are beyond their limits or the loop is unstable.
    """

    k: np.ndarray
    bandwidth: np.ndarray
    margins: dict[Robustness, np.ndarray]


@dataclass(frozen=True)
class _Section:
    """Unknowns (S, n) of one bandwidth, and the margin (S) of each."""

    k: np.ndarray
    margins: np.ndarray

    @property
    def reach(self) -> Reach:
        """Smallest and largest margin."""
        if not len(self.margins):
            return Reach(math.nan, math.nan)
        return Reach(float(self.margins.min()), float(self.margins.max()))


def _turn(response: np.ndarray) -> np.ndarray:
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


def _group(rows: list[Parameter], gains: Gains) -> tuple[dict[str, float], float, float]:
    """Return the sizes of gains that keep their ratio, and the ends of their common factor."""
    sizes = {row.name: gains[row.name] for row in rows}
    if not any(sizes.values()):
        sizes[rows[0].name] = rows[0].default or LEAST * rows[0].maximum
    ends = [(row.minimum / size, row.maximum / size) for row in rows if (size := sizes[row.name])]
    return sizes, max(low for low, _ in ends), min(high for _, high in ends)
