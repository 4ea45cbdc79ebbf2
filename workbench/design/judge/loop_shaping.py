"""Find gains of a loop for a bandwidth and a phase or disk margin, defined as in `LoopMargins`.

The response of a loop cut where its gains act is affine in these gains. So for each frequency w,
two linear equations yield two gains for which L(jw) = exp(j (phase margin - pi)). Along such a
curve of gains the phase margin is constant, and the search is for the bandwidth; the result is
refined with the exact model. A disk margin is searched among the gains of a bandwidth, over the
phase margin.
"""

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

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
"""Phase margins for the reach of a loop [rad]."""
SPARSE = 4
"""One of this many frequencies is used where only the reach is needed."""
SINGLE = 160
"""Number of values in the search for a single gain."""
LEAST = 1e-4
"""The smallest of these values, as a share of the largest; 0 has no ratio."""
SAME = math.radians(0.05)
"""Phase margins that differ by less count as equal on a grid of frequencies [rad]."""
EXACT = 1e-3
"""Relative tolerance of the bandwidth of a result."""
EXACTLY = {Robustness.PHASE: math.radians(0.05), Robustness.DISK: 1e-3}
"""Tolerance of its phase margin [rad] or disk margin."""
AFFINE = 0.02
"""Largest relative difference for a response to count as affine in its gains."""
NEARLY = 1.1
"""A disk margin beyond its reach by less is still tried, as the reach is interpolated between phase
margins; bandwidths that differ by less count as equal there."""
BISECTIONS = 14
USUAL = math.radians(45.0)
"""Phase margin that most loops can have [rad]."""
NOTHING = 0.1
"""Share of the tolerances below which the refinement ends."""
OTHER = 0.7
"""Factor on a gain, to find how the response depends on it."""


class End(Enum):
    """The limits of the reach of a loop."""

    NONE = ""
    LARGEST = "its largest value"
    SMALLEST = "its smallest value"
    PHASE = "phase"


@dataclass(frozen=True)
class Reach:
    """The attainable range of one number of a loop, with the other constant.

    Attributes:
        low, high: ends; NaN if nothing is attainable.
        end: the limit at `high`.
        gain: the one at its largest or smallest value, "" for none.
    """

    low: float
    high: float
    end: End = End.NONE
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
            raise WorkbenchError(f"loop {loop.name} names no gains: nothing can shape it")
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
        self._last: tuple[float, _Curve] | None = None
        self._last_reach: tuple[float, Reach] | None = None
        self._look()

    @property
    def is_affine(self) -> bool:
        """Whether the response of the loop is affine in its gains, so that one search finds all."""
        return self._is_affine

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

    def shape(self, bandwidth: float, phase_margin: float) -> Shaped:
        """Return gains for a bandwidth and a phase margin, or for the nearest attainable ones.

        The phase margin may be larger than requested if the bandwidth requires it; else the
        bandwidth is adjusted to it.

        Args:
            bandwidth: requested [rad/s].
            phase_margin: requested [rad]; for a loop with one gain it follows.

        Raises:
            WorkbenchError: if no gains of the loop make it stable.
        """
        if not self._is_affine:
            return self._found_nearby(_Asked(bandwidth, Robustness.PHASE, phase_margin))
        if len(self._groups) == 1:
            return self._shape_single(bandwidth, Robustness.PHASE)
        own = self._nearest_curve(phase_margin)
        robust = [each for each in self._sparse() if each.phase_margin > own.phase_margin]
        curve = self._wide_enough(own, robust, bandwidth)
        k, asked = self._at(curve, bandwidth)
        k = self._polished(k, _Asked(asked, Robustness.PHASE, curve.phase_margin))
        reach = self._bandwidth_reach([own, *robust])
        wanted = _Asked(bandwidth, Robustness.PHASE, phase_margin)
        return self._shaped(k, wanted, reach, self._phase_reach(asked))

    def shape_disk(self, bandwidth: float, disk_margin: float) -> Shaped:
        """Return gains for a bandwidth and a disk margin, or for the nearest attainable ones.

        The disk margin may be larger than requested if the bandwidth requires it; else the
        bandwidth is adjusted to it.

        Args:
            bandwidth: requested [rad/s].
            disk_margin: requested; for a loop with one gain it follows.

        Raises:
            WorkbenchError: if no gains of the loop make it stable.
        """
        asked = _Asked(bandwidth, Robustness.DISK, disk_margin)
        if not self._is_affine:
            return self._found_nearby(asked)
        if len(self._groups) == 1:
            return self._shape_single(bandwidth, Robustness.DISK)
        if self._last_reach is None or self._last_reach[0] != disk_margin:
            self._last_reach = disk_margin, self._disk_bandwidths(disk_margin)
        reach = self._last_reach[1]
        slices = self._slices(bandwidth)
        margins = self._disk_reach(slices)
        if margins.low / NEARLY < disk_margin < margins.high * NEARLY:
            k = self._polished(self._with_disk(slices, disk_margin), asked)
            found = self._shaped(k, asked, reach, margins)
            if found.reached:
                return found
        own = self._shaped(self._own, asked, reach, margins)
        if own.reached:
            return own
        at = bandwidth
        if not slices or margins.high < disk_margin:
            at = min(max(bandwidth, reach.low), reach.high)
            slices = self._slices(at)
        k = self._with_disk(slices, disk_margin)
        margins = self._disk_reach(slices)
        nearest = min(max(disk_margin, margins.low), margins.high)
        k = self._polished(k, replace(asked, bandwidth=at, margin=nearest))
        return self._shaped(k, asked, reach, margins)

    @staticmethod
    def _disk_reach(slices: "list[_Slice]") -> Reach:
        disks = [disk for _, disk in slices]
        return Reach(min(disks), max(disks), End.PHASE) if disks else Reach(math.nan, math.nan)

    def _shape_single(self, bandwidth: float, robustness: Robustness) -> Shaped:
        """Return the value of a single gain for a bandwidth."""
        k, asked = self._at(self._single, bandwidth)
        k = self._polished(k, _Asked(asked))
        follows = robustness.of(self.margins(self.values(k)))
        reach = self._bandwidth_reach([self._single])
        return self._shaped(k, _Asked(bandwidth), reach, Reach(follows, follows))

    def _slices(self, bandwidth: float) -> "list[_Slice]":
        """Return gains of a bandwidth, by rising phase margin.

        Raises:
            WorkbenchError: if no gains of the loop make it stable.
        """
        found = []
        for curve, _ in self._disks():
            value = curve.bandwidth
            with np.errstate(invalid="ignore"):
                between = (value[:-1] - bandwidth) * (value[1:] - bandwidth) <= 0.0
            for place in np.flatnonzero(between):
                first, last = value[place], value[place + 1]
                share = (bandwidth - first) / (last - first) if first != last else 0.0
                found.append(curve.k[place] + share * (curve.k[place + 1] - curve.k[place]))
        if not found:
            return []
        k = np.array(found)
        with np.errstate(invalid="ignore"):  # a bandwidth may jump over the requested one
            good = np.abs(np.log(self._judged(k, math.nan)[0] / bandwidth)) < math.log(NEARLY)
        k, response = k[good], self._response(k[good])
        rising = np.argsort(_phase_margins(response))
        disks = disk_margins(response[rising])
        return list(zip(k[rising], disks.tolist(), strict=True))

    def _disks(self) -> "list[tuple[_Curve, np.ndarray]]":
        """Return curves at `PHASE_MARGINS` and along the gains' limits; made once.

        With each go the disk margins along it.
        """
        if not self._curve_disks:
            for curve in [*self._sparse(), *self._along_limits()]:
                disks = np.full(len(curve.at), math.nan)
                if curve.fits.any():
                    disks[curve.fits] = disk_margins(self._response(curve.k[curve.fits]))
                self._curve_disks.append((curve, disks))
        return self._curve_disks

    def _along_limits(self) -> "list[_Curve]":
        """Return curves along which one unknown is its smallest or largest, and the other goes."""
        found = []
        for held, limit in itertools.product((0, 1), (self._low, self._high)):
            moved = 1 - held
            low = max(self._low[moved], LEAST * self._high[moved])
            k = np.full((SINGLE, 2), limit[held])
            k[:, moved] = np.geomspace(low, self._high[moved], SINGLE)
            found.append(_Curve(math.nan, k[:, moved], k, *self._judged(k, math.nan)))
        return found

    def _with_disk(self, slices: "list[_Slice]", disk_margin: float) -> np.ndarray:
        """Return unknowns with a disk margin out of those of a bandwidth, or with the nearest."""
        found = []
        for (first, low), (last, high) in itertools.pairwise(slices):
            if (low - disk_margin) * (high - disk_margin) <= 0.0 and low != high:
                share = (disk_margin - low) / (high - low)
                found.append(first + share * (last - first))
        if found:
            k = np.array(found)
            nearest: np.ndarray = k[np.argmin(self._ways(k))]
            return nearest
        return min(slices, key=lambda each: abs(each[1] - disk_margin))[0]

    def _disk_bandwidths(self, disk_margin: float) -> Reach:
        """Return the least and the largest bandwidth with no less than a disk margin.

        Where no gains have it, those with the largest one.
        """
        looked = [(curve, disks) for curve, disks in self._disks() if curve.fits.any()]
        if not looked:
            raise WorkbenchError("no gains of this loop make it stable: tune another loop first")
        most = max(float(np.nanmax(disks)) for _, disks in looked)
        wanted = min(disk_margin, most * (1.0 - 1e-9))
        with np.errstate(invalid="ignore"):
            good = [np.flatnonzero(disks >= wanted) for _, disks in looked]
        spans = [
            (float(curve.bandwidth[place]), curve, int(place))
            for (curve, _), places in zip(looked, good, strict=True)
            for place in places
        ]
        low, high = (end(spans, key=lambda each: each[0]) for end in (min, max))
        _, curve, place = high
        beyond = [each for each in (place - 1, place + 1) if 0 <= each < len(curve.ends)]
        limits = [each for each in beyond if curve.ends[each] is End.LARGEST]
        end = End.LARGEST if limits else End.PHASE
        culprit = self._culprit(end, curve.k[limits[0]]) if limits else ""
        ends = [self._disk_edge(each[0], step, wanted) for each, step in ((low, 0.8), (high, 1.25))]
        return Reach(ends[0], ends[1], end, culprit)

    def _disk_edge(self, inside: float, step: float, disk_margin: float) -> float:
        """Return how far a bandwidth goes with no less than a disk margin, from one that has it."""
        outside = inside * step
        for _ in range(BISECTIONS // 2):
            middle = math.sqrt(inside * outside)
            disks = [disk for _, disk in self._slices(middle)]
            if disks and max(disks) >= disk_margin:
                inside = middle
            else:
                outside = middle
        return inside

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
        self._responses = loops[:-1]
        self._steps = np.array([each[i] - self._own[i] for i, each in enumerate(sets[1:-1])])
        self._basis = self._basis_at(self._grid)
        expected, there = self._response(sets[-1][None])[0], loops[-1].at(self._grid)[0]
        self._is_affine = bool(np.all(np.abs(there - expected) <= AFFINE * (1.0 + np.abs(there))))
        closed = loops[0].closed
        growing = growth_rates(closed, loops[0].period) >= INTEGRATOR
        self._growing = int(np.count_nonzero(growing))
        known = self._own
        if self._growing and self._is_affine:
            known = self._stable_unknowns()
        self._turn = _turn(self._response(known[None]))[0]
        if len(self._groups) == 1 and self._is_affine:
            self._single = self._curve_of_one()
        self._curves: dict[float, _Curve] = {}
        self._curve_disks: list[tuple[_Curve, np.ndarray]] = []

    def _stable_unknowns(self) -> np.ndarray:
        """Return unknowns with a stable closed loop, if a coarse search finds some.

        How often 1 + L turns about 0 tells how many poles grow beside a known number of them; what
        moves along with the loop's gains may grow in the cut loop, too, so it is best known as 0.
        """
        if len(self._groups) == 1:
            looked = np.geomspace(LEAST * self._high[0], self._high[0], SINGLE // SPARSE)[:, None]
        else:
            looked = self._solved(USUAL, self._basis[:, ::SPARSE])
        for k in looked[((looked >= self._low) & (looked <= self._high)).all(axis=1)]:
            if self.margins(self.values(k)).stable:
                self._growing = 0
                return np.asarray(k)
        return self._own

    def _basis_at(self, frequency: np.ndarray) -> np.ndarray:
        """Return L without gains, and what each adds, (1 + n, F)."""
        own = self._responses[0].at(frequency)[0]
        parts = [
            (loops.at(frequency)[0] - own) / step
            for loops, step in zip(self._responses[1:], self._steps, strict=True)
        ]
        return np.stack([own - self._own @ np.array(parts), *parts])

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

    def _judged(self, k: np.ndarray, phase_margin: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the bandwidth of unknowns (S, n), NaN where they do not do, and how they end."""
        found = np.full(len(k), math.nan)
        ends = np.full(len(k), End.PHASE)
        ends[(k < self._low * (1.0 - 1e-9) - 1e-12).any(axis=1)] = End.SMALLEST
        ends[(k > self._high * (1.0 + 1e-9)).any(axis=1)] = End.LARGEST
        fit = np.nonzero(ends == End.PHASE)[0]
        if not len(fit):
            return found, ends
        response = self._response(k[fit])
        if not math.isnan(phase_margin):
            good = _phase_margins(response) > phase_margin - SAME
            fit, response = fit[good], response[good]
        growing = self._growing - np.rint((_turn(response) - self._turn) / math.pi)
        fit, response = fit[growing == 0], response[growing == 0]
        if len(fit):
            found[fit] = _bandwidths(self._grid, response)
        ends[np.isfinite(found)] = End.NONE
        return found, ends

    def _curve(self, phase_margin: float, every: int = 1) -> "_Curve":
        """Return the gains of a phase margin, over where L crosses."""
        places = np.arange(0, len(self._grid), every)
        k = self._solved(phase_margin, self._basis[:, places])
        found, ends = self._judged(k, phase_margin)
        return _Curve(phase_margin, self._grid[places], k, found, ends)

    def _curve_of_one(self) -> "_Curve":
        """Return the values of a single gain, from the smallest to the largest."""
        low = max(self._low[0], LEAST * self._high[0])
        k = np.geomspace(low, self._high[0], SINGLE)[:, None]
        found, ends = self._judged(k, math.nan)
        return _Curve(math.nan, k[:, 0], k, found, ends)

    def _sparse(self) -> "list[_Curve]":
        """Return curves at `PHASE_MARGINS`; they are made once."""
        for each in PHASE_MARGINS:
            if each not in self._curves:
                self._curves[each] = self._curve(float(each), SPARSE)
        return list(self._curves.values())

    def _nearest_curve(self, phase_margin: float) -> "_Curve":
        """Return the curve of a phase margin, or of the nearest one that any gains have.

        It is kept while that margin is asked for: a slider of the bandwidth moves along it.

        Raises:
            WorkbenchError: if none do.
        """
        if self._last is None or self._last[0] != phase_margin:
            self._last = phase_margin, self._found_nearest(phase_margin)
        return self._last[1]

    def _found_nearest(self, phase_margin: float) -> "_Curve":
        curve = self._curve(phase_margin)
        if curve.fits.any():
            return curve
        others = [each for each in self._sparse() if each.fits.any()]
        if not others:
            raise WorkbenchError("no gains of this loop make it stable: tune another loop first")
        best = min(others, key=lambda each: abs(each.phase_margin - phase_margin))
        good, bad = best.phase_margin, phase_margin
        for _ in range(BISECTIONS // 2):
            middle = self._curve(0.5 * (good + bad))
            if middle.fits.any():
                good, best = middle.phase_margin, middle
            else:
                bad = middle.phase_margin
        return best

    def _place(self, curve: "_Curve", at: float) -> tuple[np.ndarray, float, End]:
        """Return unknowns, bandwidth and end at a place of a curve."""
        if curve.is_single:
            k = np.array([[at]])
        else:
            k = self._solved(curve.phase_margin, self._basis_at(np.array([at])))
        found, ends = self._judged(k, curve.phase_margin)
        return k[0], float(found[0]), ends[0]

    def _edge(self, curve: "_Curve", good: int, bad: int) -> tuple[np.ndarray, float]:
        """Return unknowns and bandwidth at the end of a stretch of a curve that does."""
        inside, outside = curve.at[good], curve.at[bad]
        k, found = curve.k[good], curve.bandwidth[good]
        for _ in range(BISECTIONS):
            middle = math.sqrt(inside * outside)
            other, value, _ = self._place(curve, middle)
            if math.isnan(value):
                outside = middle
            else:
                inside, k, found = middle, other, value
        return k, found

    def _at(self, curve: "_Curve", bandwidth: float) -> tuple[np.ndarray, float]:
        """Return unknowns on a curve with a bandwidth, or the nearest, and what that is."""
        value = curve.bandwidth
        with np.errstate(invalid="ignore"):
            between = (value[:-1] - bandwidth) * (value[1:] - bandwidth) <= 0.0
        if between.any():
            places = np.nonzero(between)[0]
            share = (bandwidth - value[places]) / (value[places + 1] - value[places])
            share = np.nan_to_num(share)[:, None]
            k = curve.k[places] + share * (curve.k[places + 1] - curve.k[places])
            return k[np.argmin(self._ways(k))], bandwidth
        found = []
        for good, bad in curve.edges():
            found.append((curve.k[good], float(value[good])))
            if bad is not None:
                found.append(self._edge(curve, good, bad))
            (first, low), (second, high) = found[-2:] if bad is not None else found[-1:] * 2
            if (low - bandwidth) * (high - bandwidth) <= 0.0 and low != high:
                share = (bandwidth - low) / (high - low)
                return first + share * (second - first), bandwidth
        if not found:
            raise WorkbenchError("no gains of this loop make it stable: tune another loop first")
        return min(found, key=lambda each: abs(math.log(each[1] / bandwidth)))

    def _ways(self, k: np.ndarray) -> np.ndarray:
        """Return how far unknowns (S, n) are from the gains that are."""
        sizes = np.maximum(np.abs(self._own), LEAST * self._high)
        ways: np.ndarray = np.linalg.norm((k - self._own) / sizes, axis=1)
        return ways

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

    def _wide_enough(self, own: "_Curve", robust: "list[_Curve]", bandwidth: float) -> "_Curve":
        """Return the curve of the least phase margin from one's own on that has a bandwidth.

        Where none has, it is one's own.
        """
        if own.has(bandwidth):
            return own
        best = next((each for each in robust if each.has(bandwidth)), None)
        if best is None:
            return own
        low, high = own.phase_margin, best.phase_margin
        for _ in range(BISECTIONS // 2):
            middle = self._curve(0.5 * (low + high))
            if middle.has(bandwidth):
                best, high = middle, middle.phase_margin
            else:
                low = middle.phase_margin
        return best

    def _bandwidth_reach(self, curves: "list[_Curve]") -> Reach:
        """Return the least and the largest bandwidth of curves, and what ends it."""
        fitting = [each for each in curves if each.fits.any()]
        slowest = min(fitting, key=lambda each: np.nanmin(each.bandwidth))
        fastest = max(fitting, key=lambda each: np.nanmax(each.bandwidth))
        low = min(value for value, _, _ in self._ends(slowest))
        high, end, outside = max(self._ends(fastest), key=lambda each: each[0])
        return Reach(low, high, end, self._culprit(end, outside))

    def _ends(self, curve: "_Curve") -> "list[_Limit]":
        """Return bandwidths where a curve ends or turns back, why, and the unknowns beyond."""
        if not curve.turns:
            curve.turns.extend(self._found_ends(curve))
        return curve.turns

    def _found_ends(self, curve: "_Curve") -> "list[_Limit]":
        found: list[_Limit] = [
            (float(each), End.PHASE, None) for each in curve.bandwidth[curve.fits]
        ]
        for good, bad in curve.edges():
            if bad is not None:
                _, value = self._edge(curve, good, bad)
                found.append((value, End(curve.ends[bad]), curve.k[bad]))
            elif curve.is_single:
                end = End.LARGEST if good else End.SMALLEST
                found.append((float(curve.bandwidth[good]), end, curve.k[good]))
        return sorted(found, key=lambda each: each[1] is End.PHASE)

    def _phase_reach(self, bandwidth: float) -> Reach:
        """Return the least and the largest phase margin at a bandwidth, and what ends it."""
        spans = []
        for curve in self._sparse():
            values = curve.bandwidth[curve.fits]
            if len(values):
                spans.append((curve.phase_margin, float(values.min()), float(values.max())))
        inside = [index for index, (_, low, high) in enumerate(spans) if low <= bandwidth <= high]
        if not inside:
            return Reach(math.nan, math.nan)
        low, high = spans[inside[0]][0], spans[inside[-1]][0]
        if inside[-1] + 1 < len(spans):
            high = _between(spans[inside[-1]], spans[inside[-1] + 1], bandwidth)
        if inside[0]:
            low = _between(spans[inside[0]], spans[inside[0] - 1], bandwidth)
        return Reach(low, high, End.PHASE)

    def _culprit(self, end: End, k: np.ndarray | None) -> str:
        """Return the gain whose limit ends the reach."""
        if k is None or end not in (End.LARGEST, End.SMALLEST):
            return ""
        over = k / self._high if end is End.LARGEST else self._low - k
        return next(iter(self._groups[int(np.argmax(over))]))

    def _found_nearby(self, asked: _Asked) -> Shaped:
        """Return gains near the present ones, of a loop whose response is no sum over its gains."""
        if len(self._groups) == 1:
            asked = replace(asked, margin=None)
        nothing = Reach(math.nan, math.nan)
        return self._shaped(self._polished(self._own, asked), asked, nothing, nothing)


_Slice = tuple[np.ndarray, float]
"""Unknowns (2) of some bandwidth, and the disk margin that they have."""
_Limit = tuple[float, End, np.ndarray | None]
"""A bandwidth, what ends it there, and the unknowns beyond."""


@dataclass(frozen=True)
class _Curve:
    """Gains of a loop along a line, (S) places: of one phase margin, or of a single gain.

    Attributes:
        phase_margin: [rad]; NaN along a single gain.
        at: where L crosses [rad/s], or the single unknown.
        k: unknowns (S, n).
        bandwidth: [rad/s], NaN where they do not do.
        ends: why not.
        turns: bandwidths where it ends or turns back, see `LoopShaper._ends`; found once.
    """

    phase_margin: float
    at: np.ndarray
    k: np.ndarray
    bandwidth: np.ndarray
    ends: np.ndarray
    turns: "list[_Limit]" = field(default_factory=list)

    @property
    def fits(self) -> np.ndarray:
        """Where (S) the gains do."""
        return np.isfinite(self.bandwidth)

    @property
    def is_single(self) -> bool:
        """Whether it goes along a single gain."""
        return math.isnan(self.phase_margin)

    def has(self, bandwidth: float) -> bool:
        """Return whether a bandwidth lies within those of the curve."""
        value = self.bandwidth[self.fits]
        return bool(len(value) and value.min() <= bandwidth <= value.max())

    def edges(self) -> list[tuple[int, int | None]]:
        """Return the ends of all stretches that do, each with the place beyond, if there is one."""
        fits = self.fits
        found: list[tuple[int, int | None]] = []
        for low, high in itertools.pairwise(range(len(fits))):
            if fits[low] != fits[high]:
                found.append((low, high) if fits[low] else (high, low))
        found += [(place, None) for place in (0, len(fits) - 1) if fits[place]]
        return found


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


def _between(inside: tuple[float, ...], outside: tuple[float, ...], bandwidth: float) -> float:
    """Return between which phase margins, of spans of bandwidths, one begins to be out of reach."""
    for index in (1, 2):
        at, beyond = inside[index], outside[index]
        if (at - bandwidth) * (beyond - bandwidth) < 0.0:
            share = math.log(bandwidth / at) / math.log(beyond / at)
            return inside[0] + share * (outside[0] - inside[0])
    return inside[0]


def _group(rows: list[Parameter], gains: Gains) -> tuple[dict[str, float], float, float]:
    """Return the sizes of gains that keep their ratio, and the ends of their common factor."""
    sizes = {row.name: gains[row.name] for row in rows}
    if not any(sizes.values()):
        sizes[rows[0].name] = rows[0].default or LEAST * rows[0].maximum
    ends = [(row.minimum / size, row.maximum / size) for row in rows if (size := sizes[row.name])]
    return sizes, max(low for low, _ in ends), min(high for _, high in ends)
