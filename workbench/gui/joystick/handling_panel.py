"""The panel of the sticks' preferences: sliders, and the resulting stick curve."""

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QRectF, QSignalBlocker, QSize, Qt
from PyQt6.QtWidgets import QSizePolicy, QSlider, QWidget

from workbench.gui.instruments.plane_view import PlaneView
from workbench.gui.joystick.pilot import HANDLING_PREFERENCES
from workbench.gui.joystick.piloting import CENTRED_STICKS, Handling, Sticks
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import NO_MARGINS, buddy, button, grid, hbox, label, named, vbox
from workbench.gui.preferences import Preferences, find_preference
from workbench.gui.theme import Look
from workbench.gui.units import entered_number_text, quantity_unit

STICK_CURVE_POINTS = 81
STICK_DOT_RADIUS_PX = 3.5
HANDLING_SLIDER_STEPS = 200
"""Number of steps of a slider."""


class CurveView(PlaneView):
    """Shaped over raw input, with a dot for each deflected axis.

    Args:
        look: source of colours.
    """

    def __init__(self, look: Look) -> None:
        super().__init__(look, "Curve of the sticks")
        self._handling, self._sticks = Handling(), CENTRED_STICKS
        self._dead_band = pg.LinearRegionItem((0.0, 0.0), movable=False)
        self._axes = [pg.InfiniteLine(0.0, angle) for angle in (0, 90)]
        self._diagonal = pg.InfiniteLine((0.0, 0.0), 45.0)
        self._line = pg.PlotCurveItem(antialias=True)
        self._dots = pg.ScatterPlotItem(size=2.0 * STICK_DOT_RADIUS_PX)
        self._said = pg.TextItem("pushed →\ncommanded ↑", anchor=(1.0, 1.0))
        self._said.setPos(1.0, -1.0)  # below the curve
        self.add(
            *(self._dead_band, *self._axes, self._diagonal),
            *(self._line, self._dots, self._said),
        )
        self.show_area(QRectF(-1.0, -1.0, 2.0, 2.0))
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(130, 120)
        self.apply_colours()
        self.show_handling(self._handling)

    def sizeHint(self) -> QSize:
        """Return a small square."""
        return QSize(180, 170)

    def show_handling(self, handling: Handling) -> None:
        """Show the curve of all axes."""
        if handling == self._handling and self._line.xData is not None:
            return
        self._handling = handling
        raws = np.linspace(-1.0, 1.0, STICK_CURVE_POINTS)
        self._line.setData(raws, [handling.shaped(raw) for raw in raws.tolist()])
        self._dead_band.setRegion((-handling.dead_band, handling.dead_band))
        self.setAccessibleName(
            f"Curve of the sticks: half stick commands {handling.shaped(0.5):.0%}, full stick "
            f"{handling.shaped(1.0):.0%}"
        )

    def show_sticks(self, sticks: Sticks) -> None:
        """Show the sticks' positions on it."""
        if sticks != self._sticks:
            self._sticks = sticks
            seen = [raw for raw in sticks if raw != 0.0]
            self._dots.setData(seen, [self._handling.shaped(raw) for raw in seen])

    def apply_colours(self) -> None:
        """Apply the colours of the look, and the font."""
        super().apply_colours()
        self.view.setBackgroundColor(self.look.colour("field"))
        self.view.setBorder(self.pen("line"))
        self._dead_band.setBrush(self.look.colour("line"))
        for line in (*self._axes, *self._dead_band.lines):
            line.setPen(self.pen("line"))
        self._diagonal.setPen(self.pen("muted", 1.0, Qt.PenStyle.DotLine))
        self._line.setPen(self.pen("accent", 2.0))
        self._dots.setPen(self.pen("card"))
        self._dots.setBrush(self.look.colour("accent"))
        self._said.setColor(self.look.colour("muted"))
        self._said.setFont(self.font())


class HandlingPanel(QWidget):
    """Sliders for the preferences of the sticks.

    Args:
        preferences: storage of the values.
        look: source of colours.

    Attributes:
        curve: the curve beside them.
        sliders: sliders by the name of their preference.
    """

    def __init__(self, preferences: Preferences, look: Look) -> None:
        super().__init__()
        self._preferences = preferences
        self.curve = CurveView(look)
        self.sliders: dict[str, QSlider] = {}
        self._values: dict[str, Label] = {}
        rows = map(self._make_row, HANDLING_PREFERENCES)
        fields = grid(*rows, spacing=(12, 2), stretches=(0, 1))
        fields.setRowStretch(len(HANDLING_PREFERENCES) + 1, 1)
        defaults = named(
            button("Defaults", self._reset, "quiet compact", "Restore the defaults of all five."),
            "Restore the default feel of the sticks",
        )
        top = hbox(label("Feel of the sticks", "heading"), 1, defaults)
        left = vbox(top, (fields, 1), spacing=0)
        hbox((left, 3), (self.curve, 1), of=self, margins=NO_MARGINS, spacing=16)
        preferences.changed.connect(self._follow)

    def _make_row(self, name: str) -> tuple[QWidget, ...]:
        row = find_preference(name)
        slider = QSlider(Qt.Orientation.Horizontal, self)
        slider.setRange(0, HANDLING_SLIDER_STEPS)
        slider.setPageStep(HANDLING_SLIDER_STEPS // 10)
        set_tip(slider, row.help)
        low, high = self._text(name, row.minimum), self._text(name, row.maximum)
        slider.setAccessibleName(f"{row.label}, {low} to {high}")
        value = label()
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        value.setMinimumWidth(9 * self.fontMetrics().averageCharWidth())
        self.sliders[name], self._values[name] = slider, value
        self._follow(name)
        slider.valueChanged.connect(lambda place: self._move(name, place))
        before = buddy(row.label, slider, kind="")
        set_tip(before, row.help)
        return before, slider, value

    def _move(self, name: str, place: int) -> None:
        row = find_preference(name)
        value = row.minimum + place / HANDLING_SLIDER_STEPS * (row.maximum - row.minimum)
        step = 0.1 if row.unit == "m/s" else 0.01
        self._preferences.set(name, min(max(round(value / step) * step, row.minimum), row.maximum))

    def _follow(self, name: str) -> None:
        """Show the present preferences."""
        if name in ("speed_unit", "angle_unit"):
            for each in HANDLING_PREFERENCES:
                self._values[each].setText(self._text(each, self._preferences.number(each)))
        if name not in self.sliders:
            return
        row, value = find_preference(name), self._preferences.number(name)
        slider = self.sliders[name]
        with QSignalBlocker(slider):
            slider.setValue(
                round((value - row.minimum) / (row.maximum - row.minimum) * HANDLING_SLIDER_STEPS)
            )
        self._values[name].setText(self._text(name, value))

    def _text(self, name: str, value: float) -> str:
        unit = quantity_unit(find_preference(name), self._preferences)
        return f"{entered_number_text(value, unit)}{unit.suffix}"

    def _reset(self) -> None:
        for name in HANDLING_PREFERENCES:
            self._preferences.reset(name)
