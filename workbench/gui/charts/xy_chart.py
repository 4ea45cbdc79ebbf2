"""Signals over another signal, at the same times: a path seen from above, a phase portrait."""

import math

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.chart import Column, Command, Ends, round_ends
from workbench.gui.charts.content import Axis, Content, Line, Point
from workbench.gui.charts.curve import Curve, Extent
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.statistics import value_at
from workbench.gui.charts.window_plot import WindowPlot
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace

MOST_POINTS = 3000
"""Of a curve that are drawn; others between them are left out."""


class XYChart(WindowPlot):
    """Draws every signal but the first over the first; see `WindowPlot`.

    Args:
        workspace: colours, units and preferences.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        is_equal: whether a metre is as long across as upwards.
    """

    PERIOD = 0.1

    equal_changed = pyqtSignal()
    """The user has chosen equal scales, or not."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        self.is_equal = False
        self._when: float | None = None
        self._zoomed = False
        self._model.hint = "Drag a signal here for x, then one or more for y"

    @property
    def curves(self) -> tuple[Curve, ...]:
        """What is drawn over the first signal."""
        return tuple(self.signals)[1:]

    def set_equal(self, equal: bool) -> None:
        """Let both axes have the same scale, or each its own."""
        self.is_equal = equal
        self._settle()

    def show_time(self, time: float | None) -> None:
        """Mark where the curves were at a time [s]; None takes the dots away."""
        self._when = time
        if self.isVisible():
            self.redraw()

    def make(self) -> None:
        """Draw anew, from the newest samples."""
        self.redraw()

    def toggle_curve(self, index: int) -> None:
        """Hide a curve, or show it again."""
        self.curves[index].visible = not self.curves[index].visible
        self.redraw()

    def reset(self) -> None:
        """Show all of all curves."""
        self._zoomed = False
        super().reset()

    def redraw(self) -> None:
        """Draw anew."""
        self.canvas.show_content(self._content())
        self._show_numbers()

    def columns(self) -> tuple[Column, ...]:
        """Return the samples that are seen, in SI, over time."""
        return tuple(Column(each.label, each.unit, *self.samples(each)) for each in self.signals)

    def _commands(self) -> list[Command]:
        """Return what can be done; cursors and statistics are of charts over time."""
        over_time = (
            "Statistics",
            "Always show zero",
            "Set cursor A",
            "Set cursor B",
            "Clear cursors",
        )
        equal = Command("Equal scales", "E", self._choose_equal, self.is_equal)
        kept = [each for each in super()._commands() if each.text not in over_time]
        return [equal, *kept]

    def _choose_equal(self, equal: bool) -> None:
        self.set_equal(equal)
        self.equal_changed.emit()

    def _point(self, time: float | None) -> None:
        """Draw no crosshair over x: it would meet a curve more than once."""

    def _turn(self, time: float, share: float, factor: float, values: bool) -> None:
        self._zoomed = True
        if self.is_equal:
            self._model.window.zoom_values(self._model.axis_ends, share, factor)
        super()._turn(time, share, factor, values and not self.is_equal)

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        self._zoomed = True
        super()._box(left, right, low, high)

    def _entries(self) -> list[Entry]:
        """Return the legend: y over x, with both where the cursor of other charts is."""
        made = []
        for curve in self.curves:
            value = ""
            if self._when is not None:
                units = (
                    unit_for(each.unit, self._workspace.preferences)
                    for each in (self.signals[0], curve)
                )
                pair = zip(units, self._at(curve, self._when), strict=True)
                value = ", ".join(unit.text(number) for unit, number in pair)
            label = f"{curve.label} over {self.signals[0].label}"
            colour = self._workspace.look.curve(curve.colour)
            made.append(
                Entry(label, value, colour, curve.style, self._number(curve), curve.visible)
            )
        return made

    def _at(self, curve: Curve, when: float) -> tuple[float, float]:
        """Return x and y of a curve at a time [s]; NaN outside of the samples."""
        time, x, y = self._pairs(curve)
        return value_at(time, x, when), value_at(time, y, when)

    def _pairs(self, curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return times [s], x and y of a curve."""
        time, x = self.samples(self.first_of(curve))
        own, y = self.samples(curve)
        if len(own) == 0:
            return time[:0], x[:0], y[:0]
        if len(own) != len(time) or (own != time).any():
            y = np.interp(time, own, y, left=np.nan, right=np.nan)
        return time, x, y

    def _number(self, curve: Curve) -> int:
        return curve.number - 1 if len(self.curves) > 1 else 0

    def _content(self) -> Content:
        """Return what is to be drawn."""
        shown = [each for each in self.curves if each.visible]
        if not shown:
            one = f"{self.signals[0].label} is x: add a signal for y" if len(self.signals) else ""
            return Content(left=0.0, right=1.0, hint=one or self._model.hint)
        across = unit_for(self.signals[0].unit, self._workspace.preferences)
        units = [*dict.fromkeys(each.axis_unit for each in shown)]
        wide, extents = Extent(), [Extent() for _ in units]
        lines, points = [], []
        for curve in shown:
            time, x, y = self._pairs(curve)
            every, axis = max(1, math.ceil(len(time) / MOST_POINTS)), units.index(curve.axis_unit)
            x, y = wide.take(x) * across.factor, extents[axis].take(y)
            colour = self._workspace.look.curve(curve.colour)
            number = self._number(curve)
            lines.append(Line(x[::every], y[::every], axis, colour, curve.style, number))
            if self._when is not None:
                points.append(Point(*self._at(curve, self._when), axis, colour))
        if not self._zoomed:
            self._model.window.show(*_ends(wide, across))
        window = self._model.window
        window.forget_ranges()
        shown_in = [unit_for(unit, self._workspace.preferences) for unit in units]
        ends = [
            window.values(index, *_ends(extent, unit), self._now)
            for index, (unit, extent) in enumerate(zip(shown_in, extents, strict=True))
        ]
        left, right = self.window_ends
        if self.is_equal:
            left, right, ends[0] = self._equalled(left, right, ends[0])
        axes = tuple(Axis(unit, *each) for unit, each in zip(shown_in, ends, strict=True))
        self._model.show_axes(axes)
        points = [each._replace(x=each.x * across.factor) for each in points]
        return Content(
            left=left,
            right=right,
            x_label=f"{self.signals[0].label} {across.symbol}".strip(),
            x_unit=across.symbol,
            axes=axes,
            lines=tuple(lines),
            points=tuple(points),
        )

    def _equalled(self, left: float, right: float, ends: Ends) -> tuple[float, float, Ends]:
        """Return ends of both axes, one of them widened, so that they have the same scale."""
        low, high = ends
        size = self.canvas.view
        scale = max((right - left) / max(size.width(), 1.0), (high - low) / max(size.height(), 1.0))
        wide, tall = 0.5 * scale * size.width(), 0.5 * scale * size.height()
        x, y = 0.5 * (left + right), 0.5 * (low + high)
        return x - wide, x + wide, (y - tall, y + tall)


def _ends(extent: Extent, unit: Unit) -> Ends:
    """Return round ends of an axis, as shown."""
    if extent.low > extent.high:
        return 0.0, 1.0
    return round_ends(unit.shown(extent.low), unit.shown(extent.high), 1e-3)
