"""Median and quartiles of figures that were measured in several turns."""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Spread:
    """Median and quartiles."""

    median: float
    lower: float
    upper: float


def spread(values: Sequence[float]) -> Spread:
    """Return median and quartiles; of less than four values, the least and the largest."""
    if len(values) < 4:
        return Spread(statistics.median(values), min(values), max(values))
    lower, median, upper = statistics.quantiles(values, n=4)
    return Spread(median, lower, upper)


def ratios(above: Sequence[float], below: Sequence[float]) -> Spread:
    """Return the spread of one over the other, turn by turn."""
    return spread([a / b for a, b in zip(above, below, strict=True)])


def text(values: Spread) -> str:
    """Return the median with its quartiles."""
    return f"{number(values.median)} ({number(values.lower)} .. {number(values.upper)})"


def number(value: float) -> str:
    """Return a number with three digits that count; whole numbers have all of theirs."""
    if not math.isfinite(value):
        return "none"
    if value == round(value):
        return f"{value:,.0f}"
    if abs(value) < 1e-4:
        return f"{value:.2g}"
    rounded = float(f"{value:.3g}")
    decimals = max(0, 2 - math.floor(math.log10(abs(rounded))))
    return f"{rounded:,.{decimals}f}"
