"""Find the loop whose gains cause an oscillation."""

import cmath
import math

import numpy as np

from workbench.control.controller import Controller

RESONANT_GAIN, MIN_EXCESS_TIME_S = 1.25, 0.7
"""A loop that amplifies its command by this factor causes the swing, observed over whole waves for
at least this time [s]."""
ANGLE_ERROR_UNITS = ("1", "rad")
"""Units of the error of an attitude loop."""
SPEED_ERROR_UNITS = ("m/s",)
"""Units of the error of a velocity loop."""


class Suspect:
    """Finds out which loop along an axis causes a swing.

    The loop that amplifies its command is the cause. A loop that only follows its command is not;
    then the loop around it is. With T = y / (y + e) at the frequency of the swing, y is the
    controlled signal of a loop and e its error. For a swing of roll and pitch the inner loop is
    attitude and the outer one velocity; for a slow swing the inner one is velocity, and the outer
    one position while the position is held.

    Args:
        controller: the flying controller.
        axis: roll, pitch, yaw, height, or x and y of a slow swing.
        frequency: frequency of the swing [Hz].
        begun: time at which observation starts [s].
        slow: whether it is a swing of a velocity or position loop.
        held: whether a place is held.
    """

    def __init__(
        self,
        controller: Controller,
        axis: str,
        frequency: float,
        begun: float,
        *,
        slow: bool = False,
        held: bool = False,
    ) -> None:
        self.axis, self.frequency, self._begun, self.slow = axis, frequency, begun, slow
        along = {"roll": "y", "pitch": "x", "height": "z"}.get(axis, axis)
        loops = [loop for loop in controller.loops if loop.axis == along]
        moving = [loop for loop in loops if not loop.hold]
        holding = [loop for loop in loops if loop.hold and slow and held]
        inner = {"roll": ANGLE_ERROR_UNITS, "pitch": ANGLE_ERROR_UNITS, "yaw": ()}.get(
            axis, SPEED_ERROR_UNITS if slow else ()
        )
        follows = (loop for loop in moving if controller.points[loop.error] in inner)
        self._outer = next(iter(holding + moving), None)
        self._inner = next(follows, None)
        if self._inner is not None:
            self._place = controller.point_names.index(self._inner.error)
        self._phasors = [0j, 0j]

    @property
    def needs_signals(self) -> bool:
        """Whether the law's signals are needed beside the axis's own."""
        return self._inner is not None and self._inner is not self._outer

    def look(self, time: float, value: float, signals: np.ndarray) -> None:
        """Add the inner loop's controlled signal, and the signals at the loop points.

        Args:
            time: present time [s].
            value: controlled signal, in its unit.
            signals: those of an update in which all parts of the law run (P).
        """
        turn = cmath.exp(-2j * math.pi * self.frequency * time)
        for index, each in enumerate((value, float(signals[self._place]))):
            self._phasors[index] += turn * each

    def is_known(self, time: float) -> bool:
        """Return whether enough was observed by a time [s]."""
        waves = math.ceil(MIN_EXCESS_TIME_S * self.frequency) / self.frequency
        return not self.needs_signals or time >= self._begun + waves

    @property
    def loop(self) -> str:
        """The loop that causes the swing, in words."""
        if self._outer is None:
            return self.axis
        found = self._outer
        value, error = self._phasors
        if self._inner is not None and abs(value) > RESONANT_GAIN * abs(value + error):
            found = self._inner
        return found.name.replace("_", " ")
