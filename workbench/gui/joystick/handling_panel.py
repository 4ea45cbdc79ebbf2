"""How strongly sticks are felt: a slider for each preference, and the curve that comes of it."""

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSlider,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.joystick.curve_view import CurveView
from workbench.gui.preference_table import find_preference
from workbench.gui.preferences import Preferences
from workbench.gui.style import dressed
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for

NAMES = (
    "stick_speed",
    "stick_yaw_rate",
    "stick_sensitivity",
    "stick_expo",
    "stick_dead_band",
)
STEPS = 200
"""Of a slider, from end to end."""
PERCENT = Unit("%", 100.0)


class HandlingPanel(QWidget):
    """Sliders for the preferences of sticks.

    Args:
        preferences: where they are kept.
        look: colours.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        curve: drawn beside.
        sliders: by the name of their preference.
    """

    def __init__(self, preferences: Preferences, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._preferences = preferences
        self.curve = CurveView(look, self)
        self.sliders: dict[str, QSlider] = {}
        self._values: dict[str, QLabel] = {}
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(1, 1)
        for line, name in enumerate(NAMES):
            self._add(grid, line, name)
        defaults = dressed(QPushButton("Defaults", self), "quiet compact")
        defaults.setToolTip("Give all five their defaults.")
        defaults.setAccessibleName("Give the sticks their default handling")
        defaults.clicked.connect(self._reset)
        grid.setRowStretch(len(NAMES) + 1, 1)
        heading = dressed(QLabel("Feel of the sticks", self), "heading")
        top = QHBoxLayout()
        top.addWidget(heading)
        top.addStretch(1)
        top.addWidget(defaults)
        left = QVBoxLayout()
        left.setSpacing(0)
        left.addLayout(top)
        left.addLayout(grid, 1)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(16)
        layout.addLayout(left, 3)
        layout.addWidget(self.curve, 1)
        preferences.changed.connect(self._follow)

    def _add(self, grid: QGridLayout, line: int, name: str) -> None:
        row = find_preference(name)
        slider = QSlider(Qt.Orientation.Horizontal, self)
        slider.setRange(0, STEPS)
        slider.setPageStep(STEPS // 10)
        slider.setToolTip(row.help)
        low, high = self._text(name, row.minimum), self._text(name, row.maximum)
        slider.setAccessibleName(f"{row.label}, {low} to {high}")
        label = QLabel(row.label, self)
        label.setBuddy(slider)
        label.setToolTip(row.help)
        value = QLabel(self)
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        value.setMinimumWidth(9 * self.fontMetrics().averageCharWidth())
        self.sliders[name], self._values[name] = slider, value
        for column, widget in enumerate((label, slider, value)):
            grid.addWidget(widget, line, column)
        self._follow(name)
        slider.valueChanged.connect(lambda place: self._move(name, place))

    def _move(self, name: str, place: int) -> None:
        row = find_preference(name)
        value = row.minimum + place / STEPS * (row.maximum - row.minimum)
        step = 0.1 if row.unit == "m/s" else 0.01
        self._preferences.set(name, min(max(round(value / step) * step, row.minimum), row.maximum))

    def _follow(self, name: str) -> None:
        """Show what is preferred now."""
        if name in ("speed_unit", "angle_unit"):
            for each in NAMES:
                self._values[each].setText(self._text(each, self._preferences.number(each)))
        if name not in self.sliders:
            return
        row, value = find_preference(name), self._preferences.number(name)
        slider = self.sliders[name]
        slider.blockSignals(True)
        slider.setValue(round((value - row.minimum) / (row.maximum - row.minimum) * STEPS))
        slider.blockSignals(False)
        self._values[name].setText(self._text(name, value))

    def _text(self, name: str, value: float) -> str:
        si = find_preference(name).unit
        if si == "1":
            return PERCENT.text(value, 0)
        return unit_for(si, self._preferences).text(value, 1)

    def _reset(self) -> None:
        for name in NAMES:
            self._preferences.reset(name)
