"""Results of a spec: checks of numbers, and comparisons of curves with their baselines."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.common.series import Series
from workbench.design.regress.spec import SpecLimit, Tolerance

Band = tuple[np.ndarray, np.ndarray]
"""Smallest and largest allowed values (N) each."""


def band(baseline: Series, tolerance: Tolerance, time: np.ndarray) -> Band:
    """Return the band around a baseline, from its shifts in time and the tolerance.

    Args:
        baseline: the recorded curve, interpolated linearly.
        tolerance: of a curve around it.
        time: (N) times of the band [s].
    """
    amplitude = float(np.abs(baseline.values - baseline.values[0]).max())
    width = max(tolerance.absolute, tolerance.relative * amplitude)
    early, late = time - tolerance.time_shift, time + tolerance.time_shift
    ends = np.stack([np.interp(at, baseline.time, baseline.values) for at in (early, late)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    first = np.searchsorted(baseline.time, early)
    last = np.searchsorted(baseline.time, late, side="right")
    for index, (start, stop) in enumerate(zip(first, last, strict=True)):
        if stop > start:  # linear pieces have their extrema at samples
            inside = baseline.values[start:stop]
            low[index] = min(low[index], inside.min())
            high[index] = max(high[index], inside.max())
    return low - width, high + width


@dataclass(frozen=True)
class LimitCheck:
    """A number and the demand on it.

    Attributes:
        name: of the metric; for a margin, names of loop and margin.
        unit: of value and limit.
        value: the measured one.
        limit: the demand.
        doubt: why the value means little, such as for a step that has not settled, or why a log
            does not have it, else "".
        skipped: whether the demand is skipped, as the log does not have the value.
    """

    name: str
    unit: str
    value: float
    limit: SpecLimit
    doubt: str = ""
    skipped: bool = False

    @property
    def met(self) -> bool:
        """Whether the demand is met or skipped; a NaN never meets it."""
        return self.skipped or self.limit.min <= self.value <= self.limit.max

    @property
    def excess(self) -> float:
        """Distance beyond the limit, 0 within it, NaN if the value is NaN."""
        if math.isnan(self.value):
            return math.nan
        return max(self.limit.min - self.value, self.value - self.limit.max, 0.0)

    @property
    def demand(self) -> str:
        """The limit in words."""
        low, high = self.limit.min, self.limit.max
        if low == -math.inf:
            return f"at most {with_unit(high, self.unit)}"
        if high == math.inf:
            return f"at least {with_unit(low, self.unit)}"
        return f"{low:.4g} .. {with_unit(high, self.unit)}"

    @property
    def sentence(self) -> str:
        """A sentence on how the demand is missed."""
        doubt = f" ({self.doubt})" if self.doubt else ""
        if math.isnan(self.value):
            return f"{self.name} does not exist, and should be {self.demand}{doubt}"
        side = "below" if self.value < self.limit.min else "above"
        return (
            f"{self.name} is {with_unit(self.value, self.unit)}, and should be {self.demand}: "
            f"{with_unit(self.excess, self.unit)} {side}{doubt}"
        )


@dataclass(frozen=True)
class CurveComparison:
    """A flown curve with its baseline.

    Attributes:
        flown: the flown curve, from the edge on.
        baseline: the recorded curve; None without one, or if not required.
        band: limits of the curve at the flown times; None without a baseline.
        missing: why a required baseline is missing, else "".
    """

    flown: Series
    baseline: Series | None = None
    band: Band | None = None
    missing: str = ""

    @property
    def signal(self) -> str:
        """Name of the signal."""
        return self.flown.name

    @property
    def unit(self) -> str:
        """Unit of its values."""
        return self.flown.unit

    @property
    def excesses(self) -> np.ndarray:
        """Distance of each sample beyond the band, (N); 0 inside."""
        if self.band is None:
            return np.zeros(len(self.flown.time))
        low, high = self.band
        outside = np.maximum(low - self.flown.values, self.flown.values - high)
        return np.where(np.isnan(outside), np.inf, np.maximum(outside, 0.0))

    @property
    def met(self) -> bool:
        """Whether the demand is met."""
        return not self.missing and not self.excesses.any()

    @property
    def use(self) -> float:
        """Largest distance from the baseline, as a share of that to the edge of the band."""
        if self.band is None or self.baseline is None:
            return 0.0
        low, high = self.band
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        return float(np.max(np.abs(self.flown.values - middle) / half))

    @property
    def sentence(self) -> str:
        """A sentence on how the demand is missed."""
        if self.missing:
            return self.missing
        assert self.band is not None
        low, high = self.band
        worst = int(np.argmax(self.excesses))
        unit = f" {self.unit}" if self.unit != "1" else ""
        return (
            f"{self.signal} leaves its band: {self.flown.values[worst]:.6g}{unit} at "
            f"{self.flown.time[worst]:.3f} s, and should be {low[worst]:.6g} .. "
            f"{high[worst]:.6g}{unit}: {self.excesses[worst]:.3g}{unit} beyond"
        )


@dataclass(frozen=True)
class ConditionChange:
    """A value that differs from that of the baseline; NaN if it does not exist."""

    name: str
    baseline: float
    now: float

    @property
    def sentence(self) -> str:
        """Both values."""
        return f"{self.name} {self.baseline:g} -> {self.now:g}"


@dataclass(frozen=True)
class CaseResult:
    """The result of one case, or of the margins of a spec.

    Attributes:
        spec: name of the spec.
        path: its file.
        case: name of the case.
        checks: of all limits.
        curves: all recorded ones, the judged ones with their bands.
        trouble: why the flight was lost, else "".
        conditions: of the flight, without the settings of the case itself.
        differences: of the conditions from those of the baseline.
        seconds: computing time [s].
        absent: why there is no log to judge, else ""; the case is then skipped.
    """

    spec: str
    path: Path
    case: str
    checks: tuple[LimitCheck, ...] = ()
    curves: tuple[CurveComparison, ...] = ()
    trouble: str = ""
    conditions: Mapping[str, float] = field(default_factory=dict)
    differences: tuple[ConditionChange, ...] = ()
    seconds: float = 0.0
    absent: str = ""

    @property
    def skips(self) -> list[str]:
        """A sentence for each check skipped as the log lacks its signals."""
        found = [self.absent] if self.absent else []
        return found + [f"{each.name}: {each.doubt}" for each in self.checks if each.skipped]

    @property
    def skipped(self) -> bool:
        """Whether nothing was judged."""
        judged = [each for each in self.checks if not each.skipped]
        return bool(self.skips) and not judged and not self.failures

    @property
    def failures(self) -> list[str]:
        """A sentence for each demand that is not met."""
        found = [self.trouble] if self.trouble else []
        found += [check.sentence for check in self.checks if not check.met]
        return found + [curve.sentence for curve in self.curves if not curve.met]

    @property
    def story(self) -> list[str]:
        """The failures, and the differences from the baseline."""
        return self.failures + [f"since the baseline: {self.changed}"] * bool(self.changed)

    @property
    def passed(self) -> bool:
        """Whether all demands are met."""
        return not self.failures

    @property
    def changed(self) -> str:
        """Sentence on values that differ from those of the baseline, or ""."""
        return ", ".join(each.sentence for each in self.differences)


def with_unit(value: float, unit: str) -> str:
    """Return a number with its unit, if any."""
    return f"{value:.4g}" if unit in ("", "1") else f"{value:.4g} {unit}"


def results_summary(results: Sequence[CaseResult]) -> str:
    """Return the numbers of passed, failed and skipped results in words."""
    skipped = sum(result.skipped for result in results)
    beside = f", {skipped} skipped" if skipped else ""
    count, failed = len(results) - skipped, sum(not result.passed for result in results)
    if not count:
        return "the case was skipped" if skipped == 1 else f"all {skipped} cases were skipped"
    if 0 < failed < count:
        return f"{failed} of {count} cases failed{beside}"
    word = "failed" if failed else "passed"
    return (f"the case {word}" if count == 1 else f"all {count} cases {word}") + beside


def since_baseline(results: Sequence[CaseResult]) -> list[str]:
    """Return the differences from the baselines, one sentence for all specs with the same ones.

    A sentence names its specs, unless it is about all of several.
    """
    specs = {result.spec for result in results}
    saying: dict[str, dict[str, None]] = {}
    for result in results:
        if result.changed:
            saying.setdefault(result.changed, {})[result.spec] = None
    return [
        f"{'' if 1 < len(specs) == len(names) else ', '.join(names) + ': '}"
        f"since the baseline: {changed}"
        for changed, names in saying.items()
    ]
