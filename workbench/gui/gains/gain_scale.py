"""Where a value stands on a slider, and how far a key moves it."""

import math
from enum import Enum

from PyQt6.QtCore import Qt

from workbench.gui.units import Unit
from workbench.scenario.parameters import Parameter

DIGITS = 3
"""Significant digits that a slider gives."""
_KNEE = 10.0
"""Where 0 is allowed, values below default / KNEE are spread evenly, those above by their ratio."""
_UP = (Qt.Key.Key_Right, Qt.Key.Key_Up)
_DOWN = (Qt.Key.Key_Left, Qt.Key.Key_Down)


class StepSize(Enum):
    """Of a step, as a multiple of the plain one."""

    FINEST = 0.1
    FINE = 1.0
    COARSE = 5.0


class GainScale:
    """Maps values of a row to places 0 .. 1 along a slider, and back; ever rising.

    By ratio where all values are positive and span more than a decade; by ratio with an even
    stretch around 0 where 0 is allowed; evenly where there is no more than a decade, where only
    whole numbers mean something, or where the default is an end.

    Args:
        row: the parameter.
        unit: in which its values are round.
    """

    def __init__(self, row: Parameter, unit: Unit) -> None:
        self._row, self._unit = row, unit
        self._low, self._high = row.minimum, row.maximum
        even = row.whole or row.default in (row.maximum,)
        if not even and self._low > 0.0:
            even = self._high <= 10.0 * self._low
        self._even = even
        size = max(abs(self._low), abs(self._high))
        self._knee = abs(row.default) / _KNEE or size / 100.0
        self._first = self._bend(self._low)
        self._span = self._bend(self._high) - self._first

    def place(self, value: float) -> float:
        """Return where a value stands, 0 .. 1; one beyond the limits stands at the end."""
        value = min(max(value, self._low), self._high)
        return (self._bend(value) - self._first) / self._span

    def value(self, place: float) -> float:
        """Return the value at a place, within the limits."""
        if place <= 0.0:
            return self._low
        if place >= 1.0:
            return self._high
        bent = self._first + place * self._span
        return self.held(self._unbend(bent))

    def round_value(self, place: float) -> float:
        """Return the allowed value at a place, with three digits as it is shown."""
        shown = self._unit.shown(self.value(place))
        return self.held(self._unit.read(float(f"{shown:.{DIGITS - 1}e}")))

    def stepped(self, value: float, direction: int, size: StepSize) -> float:
        """Return the allowed value that is a step from another one, up (1) or down (-1)."""
        shown = self._unit.shown(value)
        step = 1.0 if self._row.whole else self._unit.shown(self.step(value)) * size.value
        return self.held(self._unit.read(round(shown + direction * step, 9)))

    def held(self, value: float) -> float:
        """Return the allowed value that is next to one."""
        if self._row.whole:
            value = float(round(value))
        return min(max(value, self._low), self._high)

    def step(self, value: float) -> float:
        """Return the step of an arrow key: 1, 2 or 5 times a power of ten, some 2 % of the value.

        Args:
            value: at which it is made.
        """
        if self._row.whole:
            return 1.0
        size = max(abs(value), self._smallest())
        return _round_step(0.02 * size)

    def _smallest(self) -> float:
        """Return the size at which steps get no finer."""
        return self._low if self._low > 0.0 else self._knee

    def _bend(self, value: float) -> float:
        if self._even:
            return value
        return math.log(value) if self._low > 0.0 else math.asinh(value / self._knee)

    def _unbend(self, bent: float) -> float:
        if self._even:
            return bent
        return math.exp(bent) if self._low > 0.0 else self._knee * math.sinh(bent)


def decimals(step: float) -> int:
    """Return the decimals that show a step."""
    return min(6, max(0, -math.floor(math.log10(step) + 1e-9)))


def _round_step(step: float) -> float:
    """Return the nearest of 1, 2, 5 times a power of ten, by ratio."""
    power = 10.0 ** math.floor(math.log10(step))
    nearest = min((1.0, 2.0, 5.0, 10.0), key=lambda each: abs(math.log(step / (each * power))))
    return float(f"{nearest * power:.0e}")


def size_of(modifiers: Qt.KeyboardModifier) -> StepSize:
    """Return the step of a key that is pressed: plain, with Shift coarse, with Ctrl finest."""
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return StepSize.COARSE
    if modifiers & Qt.KeyboardModifier.ControlModifier:
        return StepSize.FINEST
    return StepSize.FINE


def key_step(key: int, modifiers: Qt.KeyboardModifier) -> tuple[int, StepSize] | None:
    """Return direction and size of the step that a key makes, None of another key."""
    if key in _UP:
        return 1, size_of(modifiers)
    if key in _DOWN:
        return -1, size_of(modifiers)
    if key in (Qt.Key.Key_PageUp, Qt.Key.Key_PageDown):
        return (1 if key == Qt.Key.Key_PageUp else -1), StepSize.COARSE
    return None


def moves(key: int) -> bool:
    """Return whether a key makes a step."""
    return key_step(key, Qt.KeyboardModifier.NoModifier) is not None
