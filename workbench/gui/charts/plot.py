"""A plot of finished curves from time 0 on, as responses laid over each other."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from PyQt6.QtCore import QPoint
from PyQt6.QtGui import QContextMenuEvent
from PyQt6.QtWidgets import QVBoxLayout, QWidget

from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.chart_head import ChartHead
from workbench.gui.charts.chart_menu import make_plot_menu
from workbench.gui.charts.copies import Copies
from workbench.gui.charts.curve_set import Extent
from workbench.gui.charts.curve_style import CurveStyle
from workbench.gui.charts.decimation import Peaks
from workbench.gui.charts.legend import Entry
from workbench.gui.charts.named_curve import NamedCurve
from workbench.gui.charts.scene import Axis, Limit, Line, Scene
from workbench.gui.charts.steady_range import round_ends
from workbench.gui.charts.table_text import Column
from workbench.gui.charts.ticks import decimals_for, number_text
from workbench.gui.charts.window_statistics import value_at
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace


class StaticPlot(QWidget):
    """Shows named curves over a common axis until they are set anew.

    Args:
        workspace: colours, units and preferences.
        parent: whose life it shares.

    Attributes:
        head: title and legend.
        canvas: where it is painted.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._curves: dict[str, NamedCurve] = {}
        self._limits: tuple[tuple[float, str], ...] = ()
        self._x_label, self._y_label, self._unit = "s", "", ""
        self._ends: tuple[float, float] | None = None
        self._cut: tuple[float, float] | None = None
        self._hint = "Nothing to show yet"
        self._holds = 0
        self._copies = Copies(workspace, self)
        self.head = ChartHead(workspace.look)
        self.head.hide_pause()
        self.canvas = Canvas(workspace.look)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(2)
        box.addWidget(self.head)
        box.addWidget(self.canvas, 1)
        self._describe()
        self.canvas.resized.connect(self.redraw)
        self.canvas.hovered.connect(self._hover)
        self.canvas.turned.connect(self._turn)
        self.canvas.boxed.connect(self._box)
        self.canvas.reset_wanted.connect(self.show_all)
        self.head.legend.toggled.connect(self._toggle)
        self.head.menu_wanted.connect(self._open_menu)
        workspace.preferences.changed.connect(self._on_preference)

    @contextmanager
    def together(self) -> Iterator[None]:
        """Let what is set within be drawn once, at the end."""
        self._holds += 1
        try:
            yield
        finally:
            self._holds -= 1
            if not self._holds:
                self._describe()
                self.redraw()

    def set_curve(
        self,
        name: str,
        time: np.ndarray,
        values: np.ndarray,
        style: CurveStyle = CurveStyle.SOLID,
        colour: int = 0,
    ) -> None:
        """Set a curve, or replace the one of that name; the arrays are kept, not copied.

        Args:
            name: in the legend.
            time: of the samples (n), rising [s].
            values: (n), in the SI unit of the axis.
            style: of its stroke.
            colour: its number, `COMMAND` for that of commands.
        """
        before = self._curves.get(name)
        visible = before.visible if before is not None else True
        self._curves[name] = NamedCurve(name, time, values, style, colour, visible)
        if before is None:
            self._describe()
        self.redraw()

    def remove_curve(self, name: str) -> None:
        """Remove a curve; nothing happens where there is none of that name."""
        if self._curves.pop(name, None) is not None:
            self._describe()
            self.redraw()

    def clear(self) -> None:
        """Remove all curves."""
        self._curves.clear()
        self._describe()
        self.redraw()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the curves."""
        return tuple(self._curves)

    def set_limits(self, limits: Sequence[tuple[float, str]]) -> None:
        """Draw lines across at these values, in SI, with their labels."""
        self._limits = tuple(limits)
        self.redraw()

    def set_axes(self, x_label: str, y_label: str, unit: str = "") -> None:
        """Name the axes.

        Args:
            x_label: below, with its unit, as "Time s".
            y_label: of the values, without their unit.
            unit: SI, of the values; it is shown as the user prefers.
        """
        self._x_label, self._y_label, self._unit = x_label, y_label, unit
        self._describe()
        self.redraw()

    def set_title(self, title: str) -> None:
        """Give the plot a name."""
        self.head.set_title(title)
        self._describe()

    def set_hint(self, hint: str) -> None:
        """Say what is to be done where there is nothing to show."""
        self._hint = hint
        self.redraw()

    def set_window(self, left: float, right: float) -> None:
        """Show a part of time [s]."""
        self._ends = (left, right) if right > left else None
        self.redraw()

    def show_all(self) -> None:
        """Show all of all curves."""
        self._ends = self._cut = None
        self.redraw()

    def copy_picture(self) -> None:
        """Copy the plot as a picture."""
        self._copies.copy_picture(self)

    def copy_data(self) -> None:
        """Copy the curves that are seen, in SI, with tabs between."""
        self._copies.copy_data(self._columns())

    def save_picture(self) -> None:
        """Write the plot as a picture (PNG) to the folder for logs."""
        self._copies.save_picture(self, self.head.title)

    def save_data(self) -> None:
        """Write the curves that are seen (CSV), in SI, to the folder for logs."""
        self._copies.save_data(self._columns(), self.head.title)

    def redraw(self) -> None:
        """Draw anew; within `together`, later."""
        if self._holds:
            return
        left, right = self._time_ends()
        layout = self.canvas.layout_for(1)
        columns = self.canvas.columns_for(layout)
        extent, lines, look = Extent(), [], self._workspace.look
        for number, each in enumerate(self._curves.values(), 1):
            if each.visible:
                time, values = Peaks().reduce(*each.cut(left, right), left, right, columns)
                values = extent.take(values)
                curves = look.colours.curves
                colour = look.colours.command
                if each.colour >= 0:
                    colour = curves[each.colour % len(curves)]
                shown = number if len(self._curves) > 1 and each.colour >= 0 else 0
                lines.append(Line(time, values, 0, colour, each.style, shown))
        axis = self._axis(extent)
        limits = tuple(Limit(value, label) for value, label in self._limits)
        self.canvas.show_scene(
            Scene(left, right, 0.0, self._x_label, (axis,), tuple(lines), limits, hint=self._hint)
        )
        self._show_legend()

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Offer what can be done."""
        if event is not None:
            make_plot_menu(self).popup(event.globalPos())

    def _columns(self) -> tuple[Column, ...]:
        return tuple(
            Column(each.name, self._unit, each.time, each.values)
            for each in self._curves.values()
            if each.visible
        )

    def _time_ends(self) -> tuple[float, float]:
        if self._ends is not None:
            return self._ends
        times = [each.time for each in self._curves.values() if each.visible and len(each.time)]
        left = min((float(time[0]) for time in times), default=0.0)
        right = max((float(time[-1]) for time in times), default=1.0)
        return left, right if right > left else left + 1.0

    def _unit_shown(self) -> Unit:
        return unit_for(self._unit, self._workspace.preferences)

    def _axis(self, extent: Extent) -> Axis:
        unit = self._unit_shown()
        if self._cut is not None:
            return Axis(unit, unit.shown(self._cut[0]), unit.shown(self._cut[1]), self._y_label)
        if not np.isfinite(extent.low):
            return Axis(unit, -1.0, 1.0, self._y_label)
        # A limit that is near is seen; one far away would flatten the curves.
        span = max(extent.high - extent.low, 1e-9)
        near = [
            value
            for value, _ in self._limits
            if extent.low - 0.5 * span <= value <= extent.high + 0.5 * span
        ]
        extent.take(np.array(near))
        low, high = unit.shown(extent.low), unit.shown(extent.high)
        return Axis(unit, *round_ends(low, high, 1e-3), self._y_label)

    def _show_legend(self) -> None:
        when, axis = self.canvas.cursor_time, self.canvas.scene.axes[0]
        decimals = decimals_for(axis.high - axis.low)
        entries = []
        for number, each in enumerate(self._curves.values(), 1):
            text = ""
            if when is not None:
                value = axis.unit.shown(value_at(each.time, each.values, when))
                text = f"{number_text(value, decimals)}\N{NO-BREAK SPACE}{axis.unit.symbol}".strip()
            shown = number if len(self._curves) > 1 and each.colour >= 0 else 0
            entries.append(Entry(each.name, text, each.colour, each.style, shown, each.visible))
        self.head.legend.show_entries(entries)

    def _hover(self, time: float | None) -> None:
        self.canvas.set_cursor(time)
        self._show_legend()

    def _turn(self, time: float, share: float, factor: float, values: bool) -> None:
        if values:
            axis = self.canvas.scene.axes[0]
            about = axis.low + share * (axis.high - axis.low)
            ends = about - (about - axis.low) * factor, about + (axis.high - about) * factor
            self._cut = axis.unit.read(ends[0]), axis.unit.read(ends[1])
        else:
            left, right = self._time_ends()
            self._ends = time - (time - left) * factor, time + (right - time) * factor
        self.redraw()

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        axis = self.canvas.scene.axes[0]
        span = axis.high - axis.low
        self._ends = left, right
        if high - low < 0.98:
            ends = axis.low + low * span, axis.low + high * span
            self._cut = axis.unit.read(ends[0]), axis.unit.read(ends[1])
        self.redraw()

    def _toggle(self, index: int) -> None:
        name = list(self._curves)[index]
        self._curves[name] = self._curves[name].toggled()
        self.redraw()

    def _open_menu(self, place: QPoint) -> None:
        make_plot_menu(self).popup(place)

    def _describe(self) -> None:
        if self._holds:
            return
        self.setAccessibleName(f"Plot {self.head.title}".strip())
        names = ", ".join(self._curves) or "no curves"
        self.setAccessibleDescription(f"{self._y_label} of {names}, over {self._x_label}".strip())

    def _on_preference(self, name: str) -> None:
        if name.endswith("_unit"):
            self.redraw()
