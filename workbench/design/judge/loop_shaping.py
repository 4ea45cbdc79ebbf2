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
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import root

from workbench.common.errors import WorkbenchError
from workbench.design.judge.affine_loop import (
    LINE_FREQUENCY_STRIDE,
    MIN_SHAPED_GAIN_SHARE,
    AffineLoop,
)
from workbench.design.judge.margins import LoopMargins, RobustnessMeasure

LINE_PHASE_MARGINS_RAD = np.radians(np.arange(3.0, 120.0, 3.0))
"""Phase margins of lines of gains [rad]."""
GAINS_PER_LINE = 160
"""Number of gains on a line along a limit."""
SINGLE_GAIN_VALUES = 640
"""Number of values of a single gain."""
BANDWIDTH_TOLERANCE = 1e-3
"""Relative tolerance of the bandwidth of a result."""
MARGIN_TOLERANCES = {RobustnessMeasure.PHASE: math.radians(0.05), RobustnessMeasure.DISK: 1e-3}
"""Tolerance of its phase margin [rad] or disk margin."""
REACH_TOLERANCE_FACTOR = 1.1
"""A margin beyond its reach by less is still tried, as the reach is interpolated between lines;
bandwidths that differ by less count as equal there."""
INACTIVE_GAIN_SHARE = 1e-3
"""Share of its largest value of a gain that hardly acts; 0 is a special case for a loop."""
LIMITING_GAIN_SHARE = 0.99
"""Share of its largest value from which on a gain limits the bandwidth."""
BISECTIONS = 7
MAX_REFINED_GAINS = 3
"""Largest number of gains to refine for a request."""
REFINEMENT_END_SHARE = 0.1
"""Share of the tolerances below which the refinement ends."""


@dataclass(frozen=True)
class AttainableRange:
    """The attainable range of one number of a loop, with the other constant.

    Attributes:
        low, high: ends; NaN if nothing is attainable.
        gain: the one whose largest value is the limit at `high`, "" for none.
    """

    low: float
    high: float
    gain: str = ""


@dataclass(frozen=True)
class ShapedLoop:
    """Gains of a loop, with the results.

    Attributes:
        gains: of the loop, and linked ones, by name.
        margins: exact, of the loop with these gains.
        reached: whether bandwidth and phase or disk margin are as requested, to
            `BANDWIDTH_TOLERANCE`.
        bandwidth: its reach at this phase or disk margin [rad/s].
        robustness: reach of that margin at this bandwidth; both ends are equal for a loop with one
            gain.
    """

    gains: dict[str, float]
    margins: LoopMargins
    reached: bool
    bandwidth: AttainableRange
    robustness: AttainableRange


@dataclass(frozen=True)
class _ShapeTarget:
    """The requested bandwidth [rad/s], and unless it follows from that, the margin."""

    bandwidth: float
    robustness: RobustnessMeasure = RobustnessMeasure.PHASE
    margin: float | None = None

    def missed(self, margins: LoopMargins) -> tuple[float, float]:
        """Return the difference of margins from the request, in tolerances."""
        if not margins.stable or math.isnan(margins.bandwidth):
            return math.inf, math.inf
        wide = math.log(margins.bandwidth / self.bandwidth) / BANDWIDTH_TOLERANCE
        if self.margin is None:
            return wide, 0.0
        return wide, (self.robustness.of(margins) - self.margin) / MARGIN_TOLERANCES[
            self.robustness
        ]

    def is_reached(self, margins: LoopMargins) -> bool:
        """Return whether margins are as requested."""
        return max(map(abs, self.missed(margins))) < 1.0


class LoopShaper:
    """Finds gains of one loop, with all others constant.

    For a loop with one gain only the bandwidth can be chosen.

    Args:
        loop: the one to shape.
    """

    def __init__(self, loop: AffineLoop) -> None:
        self.loop = loop
        self._last_reach: tuple[object, tuple[AttainableRange, np.ndarray]] | None = None
        self._last_line: tuple[float, _Line] | None = None

    def shape(
        self,
        bandwidth: float,
        margin: float,
        robustness: RobustnessMeasure = RobustnessMeasure.PHASE,
    ) -> ShapedLoop:
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
        asked = _ShapeTarget(bandwidth, robustness, None if self.loop.is_single else margin)
        if not self.loop.is_affine:
            nothing = AttainableRange(math.nan, math.nan)
            return self._shaped(self._polished(self.loop.own, asked), asked, nothing, nothing)
        reach, known = self._bandwidth_reach(asked)
        nearest = float(known[np.argmin(np.abs(np.log(known / bandwidth)))])
        section = self._section(asked)
        if asked.margin is None:
            at = asked
            if not len(section.k):
                at = replace(asked, bandwidth=nearest)
                section = self._section(at)
            k = self._polished(self.loop.nearest_first(section.k)[0], at)
            follows = robustness.of(self.loop.margins(self.loop.values(k)))
            return self._shaped(k, asked, reach, AttainableRange(follows, follows))
        if (
            section.reach.low / REACH_TOLERANCE_FACTOR
            < margin
            < section.reach.high * REACH_TOLERANCE_FACTOR
        ):
            for near in self._with_margin(section, margin)[:MAX_REFINED_GAINS]:
                k = self._polished(near, asked)
                found = self._shaped(k, asked, reach, section.reach)
                if found.reached:
                    return found
        own = self._shaped(self.loop.own, asked, reach, section.reach)
        if own.reached:
            return own
        at = asked
        if not len(section.k) or section.reach.high < margin:
            at = replace(asked, bandwidth=nearest)
            section = self._section(at)
        at = replace(at, margin=min(max(margin, section.reach.low), section.reach.high))
        k = self._polished(self._with_margin(section, margin)[0], at)
        return self._shaped(k, asked, reach, section.reach)

    @cached_property
    def _lines(self) -> "list[_Line]":
        """Lines of gains: of one phase margin, and along the limits; or all of a single gain."""
        if self.loop.is_single:
            sets = [self.loop.rising(0, SINGLE_GAIN_VALUES)[:, None]]
        else:
            sets = [
                self.loop.solved(each, self.loop.basis[:, ::LINE_FREQUENCY_STRIDE])
                for each in LINE_PHASE_MARGINS_RAD
            ]
            for held, limit in itertools.product(
                (0, 1), (self.loop.low, INACTIVE_GAIN_SHARE * self.loop.high, self.loop.high)
            ):
                k = np.full((GAINS_PER_LINE, 2), limit[held])
                k[:, 1 - held] = self.loop.rising(1 - held, GAINS_PER_LINE)
                sets.append(k)
        return [self._line(k) for k in sets]

    def _lines_for(self, asked: _ShapeTarget) -> "list[_Line]":
        """Return all lines, and that of a requested phase margin at all frequencies."""
        margin = asked.margin
        if margin is None or asked.robustness is RobustnessMeasure.DISK:
            return self._lines
        if self._last_line is None or self._last_line[0] != margin:
            self._last_line = margin, self._line(self.loop.solved(margin, self.loop.basis))
        return [*self._lines, self._last_line[1]]

    def _line(self, k: np.ndarray) -> "_Line":
        bandwidth = self.loop.bandwidths(k)
        fits = np.isfinite(bandwidth)
        margins = {each: np.full(len(k), math.nan) for each in RobustnessMeasure}
        for each, values in margins.items():
            values[fits] = self.loop.phase_or_disk_margins(k[fits], each)
        return _Line(k, bandwidth, margins)

    def _section(self, asked: _ShapeTarget) -> "_Section":
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
        k = np.array(found).reshape(-1, len(self.loop.own))
        with np.errstate(invalid="ignore"):  # a bandwidth may jump over the requested one
            k = k[
                np.abs(np.log(self.loop.bandwidths(k) / bandwidth))
                < math.log(REACH_TOLERANCE_FACTOR)
            ]
        k = k[np.argsort(np.arctan2(k[:, -1], k[:, 0]))]
        margins = self._counted(self.loop.phase_or_disk_margins(k, asked.robustness), asked)
        known = np.isfinite(margins)
        return _Section(k[known], margins[known])

    def _with_margin(self, section: "_Section", margin: float) -> np.ndarray:
        """Return unknowns (C, n) of a section with a margin, or with the nearest if none have it.

        The nearest to the present gains are first.
        """
        k, margins = section.k, section.margins
        have_it = np.abs(margins - margin) <= BANDWIDTH_TOLERANCE * margin
        if have_it.any():
            return self.loop.nearest_first(k[have_it])
        low, high = margins[:-1], margins[1:]
        places = np.flatnonzero(((low - margin) * (high - margin) <= 0.0) & (low != high))
        if not len(places):
            return k[[np.argmin(np.abs(margins - margin))]]
        share = (margin - low[places]) / (high - low)[places]
        return self.loop.nearest_first(k[places] + share[:, None] * (k[places + 1] - k[places]))

    def _bandwidth_reach(self, asked: _ShapeTarget) -> tuple[AttainableRange, np.ndarray]:
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

    def _found_reach(self, asked: _ShapeTarget) -> tuple[AttainableRange, np.ndarray]:
        lines = self._lines_for(asked)
        bandwidth = np.concatenate([each.bandwidth for each in lines])
        margins = self._counted(
            np.concatenate([each.margins[asked.robustness] for each in lines]), asked
        )
        most = np.nanmax(margins, initial=-math.inf)
        if math.isinf(most):
            raise WorkbenchError("no gains of this loop make it stable: tune another loop first")
        wanted = (
            -math.inf
            if asked.margin is None
            else min(asked.margin, most) * (1.0 - BANDWIDTH_TOLERANCE)
        )
        good = bandwidth[margins >= wanted]
        low = self._edge(replace(asked, bandwidth=float(good.min())), 0.8, wanted)
        high = self._edge(replace(asked, bandwidth=float(good.max())), 1.25, wanted)
        section = self._section(replace(asked, bandwidth=high))
        limited = (
            section.k[section.margins >= wanted] >= LIMITING_GAIN_SHARE * self.loop.high
        ).any(axis=0)
        gains = [name for name, at in zip(self.loop.names, limited, strict=True) if at]
        return AttainableRange(low, high, gains[0] if gains else ""), np.append(good, [low, high])

    def _edge(self, inside: _ShapeTarget, step: float, wanted: float) -> float:
        """Return how far a bandwidth goes with no less than a margin, from one that has it."""
        outside = inside.bandwidth * step
        for _ in range(BISECTIONS):
            middle = replace(inside, bandwidth=math.sqrt(inside.bandwidth * outside))
            if (self._section(middle).margins >= wanted).any():
                inside = middle
            else:
                outside = middle.bandwidth
        return inside.bandwidth

    @staticmethod
    def _counted(margins: np.ndarray, asked: _ShapeTarget) -> np.ndarray:
        """Return margins, NaN for those that do not count: phase margins beyond all lines.

        L hardly exceeds 1 there. The margin of a single gain follows from it, and counts as 0.
        """
        if asked.margin is None:
            return np.where(np.isnan(margins), math.nan, 0.0)
        if asked.robustness is RobustnessMeasure.DISK:
            return margins
        most = max(asked.margin, LINE_PHASE_MARGINS_RAD[-1]) * (1.0 + BANDWIDTH_TOLERANCE)
        return np.where(margins <= most, margins, math.nan)

    def _polished(self, k: np.ndarray, asked: _ShapeTarget) -> np.ndarray:
        """Return unknowns with which both numbers are exact, if they can be; else as they were."""
        sizes = np.maximum(np.abs(k), MIN_SHAPED_GAIN_SHARE * self.loop.high)

        def within(scaled: np.ndarray) -> np.ndarray:
            return np.clip(scaled * sizes, self.loop.low, self.loop.high)

        def missed(scaled: np.ndarray) -> np.ndarray:
            wide, turned = asked.missed(self.loop.margins(self.loop.values(within(scaled))))
            if math.isinf(wide):
                return np.full(len(k), 10.0)
            scale = MARGIN_TOLERANCES[asked.robustness]
            if max(abs(wide), abs(turned)) < REFINEMENT_END_SHARE:  # at 0 the search ends
                return np.zeros(len(k))
            return np.array([wide * BANDWIDTH_TOLERANCE, turned * scale][: len(k)])

        first = missed(k / sizes)
        if not first.any():
            return k
        found = root(
            missed, k / sizes, method="hybr", options={"eps": 1e-6, "xtol": 1e-4, "maxfev": 24}
        )
        if not np.linalg.norm(missed(found.x)) < np.linalg.norm(first):
            return k
        return within(found.x)

    def _shaped(
        self,
        k: np.ndarray,
        asked: _ShapeTarget,
        bandwidth: AttainableRange,
        robustness: AttainableRange,
    ) -> ShapedLoop:
        gains = self.loop.values(np.clip(k, self.loop.low, self.loop.high))
        margins = self.loop.margins(gains)
        return ShapedLoop(gains, margins, asked.is_reached(margins), bandwidth, robustness)


class _Line(NamedTuple):
    """Unknowns (S, n) along a line, the bandwidth (S) of each, and margins (S).

    They are NaN if the unknowns are beyond their limits or the loop is unstable.
    """

    k: np.ndarray
    bandwidth: np.ndarray
    margins: dict[RobustnessMeasure, np.ndarray]


@dataclass(frozen=True)
class _Section:
    """Unknowns (S, n) of one bandwidth, and the margin (S) of each."""

    k: np.ndarray
    margins: np.ndarray

    @property
    def reach(self) -> AttainableRange:
        """Smallest and largest margin."""
        if not len(self.margins):
            return AttainableRange(math.nan, math.nan)
        return AttainableRange(float(self.margins.min()), float(self.margins.max()))
