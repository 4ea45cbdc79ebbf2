"""Scales of an axis: linear and logarithmic."""

import math
from enum import Enum

import numpy as np

from workbench.gui.charts.ticks import number_text, significant_text


class Scale(Enum):
    """How the values of an axis are laid out along it: a value has a place there, and back."""

    LINEAR = "linear"
    """A value's place is the value."""
    LOGARITHMIC = "logarithmic"
    """It is the logarithm to base 10; what is not positive has none."""

    def place(self, value: float) -> float:
        """Return where a value lies: NaN for what has no place."""
        if self is Scale.LINEAR:
            return value
        return math.log10(value) if value > 0.0 else math.nan

    def places(self, values: np.ndarray) -> np.ndarray:
        """Return where values lie: NaN for what has no place."""
        return values if self is Scale.LINEAR else np.log10(self.known(values))

    def value_of(self, place: float) -> float:
        """Return the value at a place."""
        return place if self is Scale.LINEAR else 10.0**place

    def values_of(self, places: np.ndarray) -> np.ndarray:
        """Return the values at places."""
        return places if self is Scale.LINEAR else 10.0**places

    def multiplied(self, factor: float) -> tuple[float, float]:
        """Return slope and offset of the places of values that are multiplied by a factor."""
        return (factor, 0.0) if self is Scale.LINEAR else (1.0, math.log10(factor))

    def known(self, values: np.ndarray) -> np.ndarray:
        """Return values with NaN for those that have no place."""
        return values if self is Scale.LINEAR else np.where(values > 0.0, values, np.nan)

    def text(self, value: float, decimals: int) -> str:
        """Return a number: with so many decimals, or with four digits where it is logarithmic."""
        if self is Scale.LINEAR:
            return number_text(value, decimals)
        return significant_text(value, 4)
