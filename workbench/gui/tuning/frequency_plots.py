"""Plots over a common frequency axis, with a common cursor and guides."""

import math
from collections.abc import Sequence

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.content import ReferenceLine
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.layout import NO_MARGINS, grid
from workbench.gui.workspace import Workspace

WHOLE_AXIS = (-math.inf, math.inf)
MIN_PLOT_HEIGHT_PX = 150
"""Least height of a legible plot [px]."""


class FrequencyPlots(QWidget):
    """Plots over a common frequency axis, with a common cursor.

    Args:
        workspace: source of colours.
        titles: titles in order.

    Attributes:
        plots: the plots, in order.
    """

    columns = 2
    """Number of plots side by side."""
    pointed = pyqtSignal(object)
    """Frequency under the mouse [rad/s], None when it has left."""

    def __init__(self, workspace: Workspace, titles: Sequence[str]) -> None:
        super().__init__()
        self._linking = False
        self.plots = tuple(StaticPlot(workspace) for _ in titles)
        self._box = grid(of=self, margins=NO_MARGINS, spacing=(2, 2))
        for place, (plot, title) in enumerate(zip(self.plots, titles, strict=True)):
            self._box.addWidget(plot, place // self.columns, place % self.columns)
            plot.setMinimumHeight(MIN_PLOT_HEIGHT_PX)
            plot.set_hint("Not known yet: the analyst is computing it")
            plot.show_head(False)
            plot.set_title(title)
            plot.cursor_moved.connect(self.pointed)
            plot.picture_changed.connect(lambda plot=plot: self._link(plot))

    def set_cursor(self, frequency: float | None) -> None:
        """Set the cursor of all plots to a frequency [rad/s], or remove it."""
        for plot in self.plots:
            if plot.cursor_time != frequency:
                plot.set_cursor(frequency)

    def show_window(self, left: float, right: float) -> None:
        """Show the frequencies between two [rad/s]."""
        for plot in self.plots:
            plot.set_window(left, right)

    def _link(self, plot: StaticPlot) -> None:
        """Zoom all plots to the frequencies of one."""
        if self._linking:
            return
        self._linking = True
        for other in self.plots:
            if other is not plot and other.window_ends != plot.window_ends:
                other.set_window(*plot.window_ends)
        self._linking = False


GuidesWithCaption = tuple[list[ReferenceLine], str]
"""Lines in a plot, and their caption."""


def keep_curves(plot: StaticPlot, names: Sequence[str]) -> None:
    """Keep only the curves of these names, in this order, which determines their numbers."""
    if plot.names != tuple(names):
        curves = {each.label: each for each in plot.curves}
        plot.clear()
        for name in names:
            each = curves[name]
            plot.set_curve(name, *each.samples(-math.inf), each.style, each.colour, each.group)
