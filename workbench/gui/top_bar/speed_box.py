"""The real-time factor that is wanted."""

from bisect import bisect_left, bisect_right

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QDoubleSpinBox, QWidget

from workbench.gui.actions import SPEEDS

SLOWEST, FASTEST = 0.01, 20.0
"""What a flight can be asked for."""
LONGEST = 11
"""Of its text and arrows, in digits."""


class SpeedBox(QDoubleSpinBox):
    """A number of times real time; its arrows go from one usual factor to the next.

    Args:
        parent: in which it stands.
    """

    wanted = pyqtSignal(float)
    """The user wants this factor."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setRange(SLOWEST, FASTEST)
        self.setDecimals(2)
        self.setValue(1.0)
        self.setSuffix("\N{NO-BREAK SPACE}×")
        self.setKeyboardTracking(False)
        self.setFixedWidth(LONGEST * self.fontMetrics().horizontalAdvance("0"))
        self.setAccessibleName(f"Speed wanted, in times real time, {SLOWEST:g} to {FASTEST:g}")
        self.setToolTip("Speed wanted: simulated seconds in a second; arrows step through presets")
        self.valueChanged.connect(self.wanted)

    def show_factor(self, factor: float) -> None:
        """Show what is in force, unless the user is about to type another."""
        line = self.lineEdit()
        typing = self.hasFocus() and line is not None and line.isModified()
        if factor != self.value() and not typing:
            self.blockSignals(True)
            self.setValue(factor)
            self.blockSignals(False)

    def stepBy(self, steps: int) -> None:
        """Go to the next usual factor, and so on."""
        for _ in range(abs(steps)):
            self.setValue(next_speed(self.value(), up=steps > 0))


def next_speed(factor: float, *, up: bool) -> float:
    """Return the nearest usual factor above or below one."""
    if up:
        at = bisect_right(SPEEDS, factor)
        return SPEEDS[at] if at < len(SPEEDS) else FASTEST
    at = bisect_left(SPEEDS, factor)
    return SPEEDS[at - 1] if at else min(factor, SPEEDS[0])
