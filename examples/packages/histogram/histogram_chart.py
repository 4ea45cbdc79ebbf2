"""A chart of how often signals have which value."""

import numpy as np

from workbench.gui.charts.chart_kind import ChartKind
from workbench.gui.charts.curve import CurveSet, fixed_source
from workbench.gui.charts.window_plot import WindowPlot


class HistogramChart(WindowPlot):
    """Shows the probability density of the values of signals, in their SI units."""

    def __init__(self, workspace):
        super().__init__(workspace)
        self.set_axes("Value", "Density", x_unit="SI")

    def make(self):
        """Compute the densities."""
        curves = CurveSet()
        for signal in self.signals:
            _, values = self.samples(signal)
            if len(values):
                density, edges = np.histogram(values, bins=30, density=True)
                source = fixed_source(0.5 * (edges[:-1] + edges[1:]), density)
                curves.add(signal.label, "1", source, signal.colour, signal.style)
        self.show_curves(curves)


HISTOGRAM = ChartKind("histogram", "Histogram", HistogramChart)
