"""The map of a metric over two swept numbers."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PatchCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from workbench.design.metrics import Metric
from workbench.design.sweep.best import BestCandidate
from workbench.design.sweep.plot_marks import (
    HATCH,
    axis_label,
    colour_limits,
    mark_points,
    metric_label,
    shown_values,
)
from workbench.design.sweep.ranges import SweepRange
from workbench.design.sweep.table import SweepTable

COLOURS = "viridis"
_NO_VALUE = "0.8"
_DOT = 90.0
"""Area of a candidate off the grid [points²]."""


def draw_map(table: SweepTable, metric: Metric, best: BestCandidate | None) -> Figure:
    """Return the map of a metric; cells of a grid, dots for other candidates."""
    figure = Figure(figsize=(8.2, 6.2), layout="constrained")
    axes = figure.subplots()
    values = shown_values(table, metric)
    norm = Normalize(*colour_limits(values))
    draw = _draw_cells if table.method == "grid" else _draw_dots
    kinds = draw(axes, table, values, norm)
    mark_points(axes, table, best)
    x, y = table.ranges
    for axis, span in ((axes.xaxis, x), (axes.yaxis, y)):
        if span.log:
            axis.axes.set(**{f"{axis.axis_name}scale": "log"})
        axis.set_label_text(axis_label(span))
    axes.grid(visible=False)
    beyond = bool(np.nanmax(values, initial=-np.inf) > norm.vmax)
    figure.colorbar(
        ScalarMappable(norm, COLOURS),
        ax=axes,
        label=metric_label(table, metric),
        extend="max" if beyond else "neither",
    )
    handles = [*axes.get_legend_handles_labels()[0], *kinds]
    if handles:
        axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4)
    return figure


def cell_edges(values: np.ndarray, span: SweepRange) -> np.ndarray:
    """Return the borders (N + 1) between values (N) in order, half-way, logarithmic or not."""
    points = np.log(values) if span.log else values
    if len(points) == 1:
        return np.array([span.low, span.high])
    middle = 0.5 * (points[1:] + points[:-1])
    ends = 2.0 * points[0] - middle[0], 2.0 * points[-1] - middle[-1]
    edges = np.array([ends[0], *middle, ends[1]])
    return np.exp(edges) if span.log else edges


def _draw_cells(axes: Axes, table: SweepTable, values: np.ndarray, norm: Normalize) -> list[Patch]:
    """Draw a grid's cells; return what its legend needs besides."""
    x, y = table.ranges
    edges_x, edges_y = cell_edges(x.grid, x), cell_edges(y.grid, y)
    columns = np.abs(table.parameters[:, 0, None] - x.grid).argmin(axis=1)
    rows = np.abs(table.parameters[:, 1, None] - y.grid).argmin(axis=1)
    cells = np.full((y.points, x.points), np.nan)
    cells[rows, columns] = values
    axes.pcolormesh(edges_x, edges_y, cells, norm=norm, cmap=COLOURS)
    lost = np.isfinite(table.diverged_at)
    kinds = [
        (lost, HATCH, "diverged"),
        (~lost & np.isnan(values), {"facecolor": _NO_VALUE, "lw": 0.0}, "no value"),
    ]
    legend = []
    for which, style, name in kinds:
        boxes = [
            Rectangle(
                (edges_x[i], edges_y[j]), edges_x[i + 1] - edges_x[i], edges_y[j + 1] - edges_y[j]
            )
            for i, j in zip(columns[which], rows[which], strict=True)
        ]
        if boxes:
            axes.add_collection(PatchCollection(boxes, **style))
            legend.append(Patch(label=name, **style))
    axes.set_xlim(edges_x[0], edges_x[-1])
    axes.set_ylim(edges_y[0], edges_y[-1])
    return legend


def _draw_dots(axes: Axes, table: SweepTable, values: np.ndarray, norm: Normalize) -> list[Patch]:
    """Draw candidates off the grid as dots."""
    lost = np.isfinite(table.diverged_at)
    known = np.isfinite(values)
    a, b = table.parameters.T
    area = _DOT * min(1.0, 200.0 / max(1, len(table)))
    axes.scatter(a[known], b[known], area, values[known], norm=norm, cmap=COLOURS, lw=0.0)
    other = ~known & ~lost
    if other.any():
        axes.scatter(a[other], b[other], area, _NO_VALUE, lw=0.0, label="no value")
    if lost.any():
        axes.scatter(a[lost], b[lost], area, "0.5", marker="x", lw=1.0, label="diverged")
    return []
