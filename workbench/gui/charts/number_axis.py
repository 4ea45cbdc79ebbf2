"""An axis of a chart with the least decimals that distinguish its numbers."""

from collections.abc import Sequence

import pyqtgraph as pg
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import QFontMetricsF
from PyQt6.QtWidgets import QGraphicsSceneResizeEvent

from workbench.common.plain_text import html_text, plain_name
from workbench.common.quantity import number_text
from workbench.gui.charts.ticks import Scale, decade_text, decade_ticks, decimals_for_step

MAX_AXIS_NAME_CHARACTERS = 40
"""Largest number of characters that are shown of an axis' name; more would cover its numbers."""
WIDEST_AXIS_NUMBER = "\N{MINUS SIGN}00.00"
"""The widest number that an axis usually has."""
ANGLE_STEPS_DEG = (15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0)
"""Spacings of ticks along an axis of at least a right angle [deg]."""
NUMBERED_TICK_LEVEL, PLAIN_TICK_LEVEL = 1.0, 0.0
"""Spacing of ticks of a logarithmic axis with and without a number, by which pyqtgraph tells levels
apart."""


class NumberAxis(pg.AxisItem):
    """An axis with the least decimals that distinguish its numbers, and a horizontal name.

    The name of a value axis is above its highest number, that of a time axis in a line below.
    """

    redrawn = pyqtSignal()
    """Its appearance has changed."""

    def update(self, *place: object) -> None:
        """Request a repaint."""
        super().update(*place)
        self.redrawn.emit()

    def show_scale(self, scale: Scale) -> None:
        """Show a scale."""
        if self.logMode is not (scale is Scale.LOGARITHMIC):
            self.setLogMode(scale is Scale.LOGARITHMIC)

    def tickValues(
        self, minVal: float, maxVal: float, size: float
    ) -> list[tuple[float, list[float]]]:
        """Return the positions of ticks, by level."""
        if not self.logMode:
            ticks: list[tuple[float, list[float]]] = super().tickValues(minVal, maxVal, size)
            return ticks
        metrics = QFontMetricsF(self.style["tickFont"])
        across = self.orientation == "bottom"
        room = (
            1.2 * metrics.horizontalAdvance(WIDEST_AXIS_NUMBER)
            if across
            else 1.6 * metrics.height()
        )
        numbered, bare = decade_ticks(minVal, maxVal, max(2, int(size / room)))
        return [(NUMBERED_TICK_LEVEL, numbered), (PLAIN_TICK_LEVEL, bare)]

    def tickSpacing(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, float]]:
        """Return spacing and offset of ticks, by level: those of angles divide a turn."""
        span = abs(maxVal - minVal)
        if not self.labelText.endswith("°") or not 90.0 <= span < ANGLE_STEPS_DEG[-1]:
            spacing: list[tuple[float, float]] = super().tickSpacing(minVal, maxVal, size)
            return spacing
        most = max(1.0, size / (1.25 * QFontMetricsF(self.style["tickFont"]).height()))
        step = next(each for each in ANGLE_STEPS_DEG if span <= most * each or each > 0.5 * span)
        return [(step, 0.0)]

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        """Return the texts at the ticks."""
        if self.logMode:
            return [
                "" if spacing == PLAIN_TICK_LEVEL else decade_text(10.0**value) for value in values
            ]
        decimals = decimals_for_step(spacing * scale)
        return [number_text(value * scale, decimals) for value in values]

    def show_name(self, name: str) -> None:
        """Show a name with its unit."""
        shown = html_text(plain_name(name, MAX_AXIS_NAME_CHARACTERS))
        if self.labelText != shown:
            self.setLabel(shown)
            self.label.setRotation(0.0)
            self.resizeEvent()

    def resizeEvent(self, event: QGraphicsSceneResizeEvent | None = None) -> None:
        """Place the name."""
        super().resizeEvent(event)
        box, line = self.label.boundingRect(), QFontMetricsF(self.label.font()).height()
        if self.orientation == "bottom":
            self.label.setPos(self.width() - box.width(), self.height() - box.height() + 2.0)
        elif self.orientation == "left":
            self.label.setPos(max(0.0, self.width() - box.width()), -box.height() - 0.4 * line)
        else:
            self.label.setPos(0.0, -box.height() - 0.4 * line)
