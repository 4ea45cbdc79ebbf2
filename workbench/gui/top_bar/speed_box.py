"""The real-time factor that is wanted."""

from bisect import bisect_left, bisect_right

from PyQt6.QtWidgets import QWidget

from workbench.gui.actions import SPEEDS
from workbench.gui.number_field import NumberField
from workbench.gui.units import Unit

SLOWEST, FASTEST = 0.01, 20.0
"""What a flight can be asked for."""
LONGEST = 11
"""Of its text and arrows, in digits."""


class SpeedBox(NumberField):
    """A number of times real time; its arrows go from one usual factor to the next.

    Args:
        parent: in which it stands.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Speed wanted, in times real time", parent=parent)
        self.set_range(Unit("×"), SLOWEST, FASTEST)
        self.show_si(1.0)
        self.setFixedWidth(LONGEST * self.fontMetrics().horizontalAdvance("0"))
        self.setToolTip("Speed wanted: simulated seconds in a second; arrows step through presets")

    def show_factor(self, factor: float) -> None:
        """Show what is in force, unless the user is about to type another."""
        if factor != self.value() and not self.is_typed_in and not self.fault:
            self.show_si(factor)

    def stepBy(self, steps: int) -> None:
        """Go to the next usual factor, and so on."""
        self.restore()
        for _ in range(abs(steps)):
            self.setValue(next_speed(self.value(), up=steps > 0))


def next_speed(factor: float, *, up: bool) -> float:
    """Return the nearest usual factor above or below one."""
    if up:
        at = bisect_right(SPEEDS, factor)
        return SPEEDS[at] if at < len(SPEEDS) else FASTEST
    at = bisect_left(SPEEDS, factor)
    return SPEEDS[at - 1] if at else min(factor, SPEEDS[0])
