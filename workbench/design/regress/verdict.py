"""What came of judging a spec: checks of numbers, curves beside their baselines, results."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.design.regress.band import Band, Curve
from workbench.design.regress.spec import Limit


@dataclass(frozen=True)
class Check:
    """A number and what is demanded of it.

    Attributes:
        name: of the metric; of a margin, its loop's and its own.
        unit: of value and limit.
        value: the flown one.
        limit: what it must be within.
        doubt: why the value means little, as of a step that has not settled, or why a log does not
            have it, else "".
        skipped: whether nothing is demanded, as the log does not have it.
    """

    name: str
    unit: str
    value: float
    limit: Limit
    doubt: str = ""
    skipped: bool = False

    @property
    def met(self) -> bool:
        """Whether it is as demanded, or skipped; a NaN never is."""
        return self.skipped or self.limit.min <= self.value <= self.limit.max

    @property
    def excess(self) -> float:
        """By how much it is beyond its limit, 0 if it is not, NaN if it is no number."""
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
        """What is wrong with it."""
        doubt = f" ({self.doubt})" if self.doubt else ""
        if math.isnan(self.value):
            return f"{self.name} does not exist, and should be {self.demand}{doubt}"
        side = "below" if self.value < self.limit.min else "above"
        return (
            f"{self.name} is {with_unit(self.value, self.unit)}, and should be {self.demand}: "
            f"{with_unit(self.excess, self.unit)} {side}{doubt}"
        )


@dataclass(frozen=True)
class Comparison:
    """A flown curve beside its baseline.

    Attributes:
        signal: its name.
        unit: of its values.
        flown: what was flown.
        baseline: what was recorded once; None without one, or where none is demanded.
        band: at the flown times, within which the curve should lie; None without a baseline.
        missing: why there is no baseline although one is demanded, else "".
    """

    signal: str
    unit: str
    flown: Curve
    baseline: Curve | None = None
    band: Band | None = None
    missing: str = ""

    @property
    def excesses(self) -> np.ndarray:
        """By how much each sample lies beyond the band, (N); 0 inside."""
        if self.band is None:
            return np.zeros(len(self.flown.time))
        outside = np.maximum(self.band.low - self.flown.values, self.flown.values - self.band.high)
        return np.where(np.isnan(outside), np.inf, np.maximum(outside, 0.0))

    @property
    def met(self) -> bool:
        """Whether it is as demanded."""
        return not self.missing and not self.excesses.any()

    @property
    def use(self) -> float:
        """Largest share of the way from the baseline to the band's edge that is used; 1 is all."""
        if self.band is None or self.baseline is None:
            return 0.0
        middle = 0.5 * (self.band.low + self.band.high)
        half = 0.5 * (self.band.high - self.band.low)
        return float(np.max(np.abs(self.flown.values - middle) / half))

    @property
    def sentence(self) -> str:
        """What is wrong with it."""
        if self.missing:
            return self.missing
        assert self.band is not None
        worst = int(np.argmax(self.excesses))
        unit = f" {self.unit}" if self.unit != "1" else ""
        return (
            f"{self.signal} leaves its band: {self.flown.values[worst]:.6g}{unit} at "
            f"{self.flown.time[worst]:.3f} s, and should be {self.band.low[worst]:.6g} .. "
            f"{self.band.high[worst]:.6g}{unit}: {self.excesses[worst]:.3g}{unit} beyond"
        )


@dataclass(frozen=True)
class Difference:
    """A number that is not what it was when the baseline was recorded; NaN: there is none."""

    name: str
    baseline: float
    now: float

    @property
    def sentence(self) -> str:
        """Both values."""
        return f"{self.name} {self.baseline:g} -> {self.now:g}"


@dataclass(frozen=True)
class CaseResult:
    """What came of one case, or of a spec's margins.

    Attributes:
        spec: the spec's name.
        path: its file.
        case: the case's name.
        checks: of all limits.
        curves: all that were recorded, the judged ones with their bands.
        trouble: why the flight came to nothing, else "".
        differences: from the baseline's values.
        seconds: that it took.
        absent: why there is no log to judge, else ""; such a case is skipped.
    """

    spec: str
    path: Path
    case: str
    checks: tuple[Check, ...] = ()
    curves: tuple[Comparison, ...] = ()
    trouble: str = ""
    differences: tuple[Difference, ...] = ()
    seconds: float = 0.0
    absent: str = ""

    @property
    def skips(self) -> list[str]:
        """A sentence for everything that was not judged, as a log does not tell."""
        found = [self.absent] if self.absent else []
        return found + [f"{each.name}: {each.doubt}" for each in self.checks if each.skipped]

    @property
    def skipped(self) -> bool:
        """Whether nothing was judged."""
        judged = [each for each in self.checks if not each.skipped]
        return bool(self.skips) and not judged and not self.failures

    @property
    def failures(self) -> list[str]:
        """A sentence for everything that is not as demanded."""
        found = [self.trouble] if self.trouble else []
        found += [check.sentence for check in self.checks if not check.met]
        return found + [curve.sentence for curve in self.curves if not curve.met]

    @property
    def story(self) -> list[str]:
        """The failures, and what differs from the baseline's."""
        return self.failures + [f"since the baseline: {self.changed}"] * bool(self.changed)

    @property
    def passed(self) -> bool:
        """Whether everything is as demanded."""
        return not self.failures

    @property
    def changed(self) -> str:
        """Which values differ from the baseline's, "" if none does."""
        return ", ".join(each.sentence for each in self.differences)


def with_unit(value: float, unit: str) -> str:
    """Return a number with its unit, none for a bare number."""
    return f"{value:.4g}" if unit in ("", "1") else f"{value:.4g} {unit}"
