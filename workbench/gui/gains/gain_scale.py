"""The scale of a gain: values as positions along a slider, with round steps."""

import math

from workbench.common.parameter import Parameter
from workbench.common.quantity import DisplayUnit

SLIDER_DIGITS = 3
"""Significant digits of a slider's values."""
_LINEAR_RANGE_DIVISOR = 10.0
"""Where 0 is allowed, values below default / KNEE are spread evenly, those above by their ratio."""


class GainScale:
    """Maps values of a row to positions 0 .. 1 along a slider, and back; strictly increasing.

    Logarithmic if all values are positive and span more than a decade; logarithmic with a linear
    part around 0 if 0 is allowed; linear if they span no more than a decade, if only whole numbers
    are allowed, or if the default is an end.

    Args:
        row: the parameter.
        unit: unit in which its values are round.
    """

    def __init__(self, row: Parameter, unit: DisplayUnit) -> None:
        self._row, self._unit = row, unit
        self._low, self._high = row.minimum, row.maximum
        even = row.whole or row.default in (row.maximum,)
        if not even and self._low > 0.0:
            even = self._high <= 10.0 * self._low
        self._even = even
        size = max(abs(self._low), abs(self._high))
        self._knee = abs(row.default) / _LINEAR_RANGE_DIVISOR or size / 100.0
        self._first = self._bend(self._low)
        self._span = self._bend(self._high) - self._first

    def place(self, value: float) -> float:
        """Return the position of a value, 0 .. 1; values beyond the limits are at the ends."""
        value = min(max(value, self._low), self._high)
        return (self._bend(value) - self._first) / self._span

    def value(self, place: float) -> float:
        """Return the value at a position, within the limits."""
        if place <= 0.0:
            return self._low
        if place >= 1.0:
            return self._high
        bent = self._first + place * self._span
        return self.held(self._unbend(bent))

    def round_value(self, place: float) -> float:
        """Return the allowed value at a position, with three digits as it is shown."""
        shown = self._unit.shown(self.value(place))
        return self.held(self._unit.read(float(f"{shown:.{SLIDER_DIGITS - 1}e}")))

    def stepped(self, value: float, direction: int, size: float) -> float:
        """Return the allowed value one step above (1) or below (-1) another one."""
        shown = self._unit.shown(value)
        step = 1.0 if self._row.whole else self._unit.shown(self.step(value)) * size
        return self.held(self._unit.read(round(shown + direction * step, 9)))

    def held(self, value: float) -> float:
        """Return the nearest allowed value."""
        if self._row.whole:
            value = float(round(value))
        return min(max(value, self._low), self._high)

    def step(self, value: float) -> float:
        """Return the step of an arrow key: 1, 2 or 5 times a power of ten, about 2 % of the value.

        Args:
            value: value at which the step is made.
        """
        if self._row.whole:
            return 1.0
        size = max(abs(value), self._low if self._low > 0.0 else self._knee)
        return _round_step(0.02 * size)

    def _bend(self, value: float) -> float:
        if self._even:
            return value
        return math.log(value) if self._low > 0.0 else math.asinh(value / self._knee)

    def _unbend(self, bent: float) -> float:
        if self._even:
            return bent
        return math.exp(bent) if self._low > 0.0 else self._knee * math.sinh(bent)


def _round_step(step: float) -> float:
    """Return the nearest of 1, 2, 5 times a power of ten, by ratio."""
    power = 10.0 ** math.floor(math.log10(step))
    nearest = min((1.0, 2.0, 5.0, 10.0), key=lambda each: abs(math.log(step / (each * power))))
    return float(f"{nearest * power:.0e}")
