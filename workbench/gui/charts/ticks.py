"""Scales of an axis, round numbers along it, and formatted numbers."""

import math
from enum import Enum

import numpy as np

from workbench.common.quantity import number_text, significant_text

MIN_DECADE_TICKS_SPAN = 0.8
"""A logarithmic axis with fewer decades has round steps, as a linear one."""
SUPERSCRIPT_DIGITS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def round_step(span: float, count: int) -> float:
    """Return 1, 2 or 5 times a power of ten that divides a span into about this many parts."""
    if not math.isfinite(span) or span <= 0.0:
        return 1.0
    rough = span / max(1, count)
    power = 10.0 ** math.floor(math.log10(rough))
    return next(
        factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= 0.999 * rough
    )


def decade_ticks(low: float, high: float, most: int) -> tuple[list[float], list[float]]:
    """Return the ticks of a logarithmic axis with and without a number.

    Decades have numbers; 2 and 5 times a decade also have, if there is room. All nine multiples of
    a decade have ticks if they can be distinguished. An axis of less than a decade has round steps.

    Args:
        low: base-10 logarithm of its lower end.
        high: base-10 logarithm of its upper end.
        most: largest number of numbers.
    """
    decades = high - low
    if decades <= 0.0:
        return [], []
    if decades < MIN_DECADE_TICKS_SPAN:
        first, last = 10.0**low, 10.0**high
        step = round_step(last - first, min(most, 6))
        steps = range(math.ceil(first / step - 1e-9), math.floor(last / step + 1e-9) + 1)
        return [math.log10(step * each) for each in steps if each > 0], []
    whole = range(math.floor(low), math.ceil(high) + 1)
    parts = (1, 2, 5) if 3.0 * decades < most else (1,)
    every = max(1, math.ceil(decades / max(1, most)))
    numbered = [each + math.log10(part) for each in whole if each % every == 0 for part in parts]
    bare = [each + math.log10(part) for each in whole for part in range(1, 10) if every == 1]
    told = {round(each, 9) for each in numbered}
    bare = [each for each in bare if round(each, 9) not in told]
    return (
        [each for each in numbered if low - 1e-9 <= each <= high + 1e-9],
        [each for each in bare if low <= each <= high],
    )


def decade_text(value: float) -> str:
    """Return the number at a tick of a logarithmic axis: 0.01, 20, 5·10⁻⁶."""
    power = math.floor(math.log10(value) + 1e-9)
    if -4 < power < 5:
        return (
            f"{value:.{max(0, 3 - power)}f}".rstrip("0").rstrip(".")
            if power < 3
            else (f"{value:.0f}")
        )
    times = f"{value / 10.0**power:.3g}"
    raised = f"10{str(power).translate(SUPERSCRIPT_DIGITS)}"
    return raised if times == "1" else f"{times}·{raised}"


def decimals_for_step(step: float) -> int:
    """Return the number of decimals that distinguish multiples of a step."""
    return max(0, -math.floor(math.log10(step) + 1e-6)) if step > 0.0 else 0


def decimals_for(span: float) -> int:
    """Return the number of decimals that show about a hundredth of a span."""
    if not math.isfinite(span) or span <= 0.0:
        return 2
    return min(6, max(0, 2 - math.floor(math.log10(span))))


class Scale(Enum):
    """Scale of an axis: converts values to positions, and back."""

    LINEAR = "linear"
    """The position is the value."""
    LOGARITHMIC = "logarithmic"
    """The position is the base-10 logarithm; values that are not positive have none."""

    def place(self, value: float) -> float:
        """Return the position of a value: NaN without one."""
        if self is Scale.LINEAR:
            return value
        return math.log10(value) if value > 0.0 else math.nan

    def places(self, values: np.ndarray) -> np.ndarray:
        """Return the positions of values: NaN without one."""
        return values if self is Scale.LINEAR else np.log10(self.known(values))

    def value_of(self, place: float) -> float:
        """Return the value at a position."""
        return place if self is Scale.LINEAR else 10.0**place

    def values_of(self, places: np.ndarray) -> np.ndarray:
        """Return the values at positions."""
        return places if self is Scale.LINEAR else 10.0**places

    def multiplied(self, factor: float) -> tuple[float, float]:
        """Return slope and offset that a factor on values causes in their positions."""
        return (factor, 0.0) if self is Scale.LINEAR else (1.0, math.log10(factor))

    def known(self, values: np.ndarray) -> np.ndarray:
        """Return values with NaN for those that have no position."""
        return values if self is Scale.LINEAR else np.where(values > 0.0, values, np.nan)

    def text(self, value: float, decimals: int) -> str:
        """Return a number as text: with these decimals, or with four digits if logarithmic."""
        if self is Scale.LINEAR:
            return number_text(value, decimals)
        return significant_text(value, 4)
