"""The figure of a sweep: curves over one parameter, a map over two, scatter plots over more."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PatchCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from workbench.common.quantity import display_unit
from workbench.design.metrics import MARGIN_METRICS, Metric
from workbench.design.plots import PALETTE, styled
from workbench.design.sweep.best import BestCandidate, unaffected_numbers_text
from workbench.design.sweep.ranges import SweepRange
from workbench.design.sweep.table import SweepTable
from workbench.scenario.axes import find_axis

LOST_HATCH: Any = {"facecolor": "0.94", "edgecolor": "0.65", "hatch": "////", "lw": 0.0}
"""Style for lost candidates."""
PRESENT_MARKER: Any = {"marker": "o", "ms": 9, "mfc": "white", "mec": "black", "mew": 1.5}
BEST_MARKER: Any = {"marker": "*", "ms": 16, "mfc": PALETTE.mean, "mec": "white", "mew": 1.0}
_COLOUR_SCALE_QUANTILE = 0.95
"""Share of the candidates within the colour scale; others have its last colour."""
SWEEP_COLOUR_MAP = "viridis"
_NO_VALUE_COLOUR = "0.8"
_NO_VALUE_STYLE: Any = {"facecolor": _NO_VALUE_COLOUR, "lw": 0.0}
_DOT_AREA_PT2 = 90.0
"""Area of the dot of a candidate off the grid [points²]."""
_CLOUD_COLUMNS = 3
_DRAWN_METRICS = ("rise_time", "settling_time", "overshoot", "steady_state_error", "peak_rotor_use")
"""Metrics drawn in addition to the requested one and margins."""


def axis_label(span: SweepRange) -> str:
    """Return the axis label of a swept number, with its unit."""
    return f"{span.name} [{span.unit}]"


def metric_label(table: SweepTable, metric: Metric) -> str:
    """Return the axis label of a metric, with its unit."""
    unit = display_unit(table.units[table.names.index(metric.name)]).symbol
    return f"{metric.name.replace('_', ' ')} [{unit or '1'}]"


def shown_values(table: SweepTable, metric: Metric) -> np.ndarray:
    """Return the values of a metric (N) to draw: angles in degrees, NaN if not finite."""
    values = display_unit(metric.unit).factor * table.column(metric.name)
    return np.where(np.isfinite(values), values, np.nan)


def colour_limits(values: np.ndarray) -> tuple[float, float]:
    """Return the limits of a colour scale, without a few outliers."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, most, high = finite.min(), np.quantile(finite, _COLOUR_SCALE_QUANTILE), finite.max()
    high = most if high - low > 2.0 * (most - low) > 0.0 else high
    return float(low), float(high if high > low else low + 1.0)


def mark_points(axes: Axes, table: SweepTable, best: BestCandidate | None) -> None:
    """Mark the present values, if within the ranges, and the best candidate on a map."""
    x, y = table.ranges
    if x.low <= table.present[0] <= x.high and y.low <= table.present[1] <= y.high:
        axes.plot(*table.present, ls="", label="present", zorder=5, **PRESENT_MARKER)
    if best:
        axes.plot(*best.parameters, ls="", label="best", zorder=6, **BEST_MARKER)


def draw_metric_map(table: SweepTable, metric: Metric, best: BestCandidate | None) -> Figure:
    """Return the map of a metric, with cells for a grid and dots for other candidates."""
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
        ScalarMappable(norm, SWEEP_COLOUR_MAP),
        ax=axes,
        label=metric_label(table, metric),
        extend="max" if beyond else "neither",
    )
    handles = [*axes.get_legend_handles_labels()[0], *kinds]
    if handles:
        axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4)
    return figure


def cell_edges(values: np.ndarray, span: SweepRange) -> np.ndarray:
    """Return the borders (N + 1) halfway between ordered values (N), logarithmic or not."""
    points = np.log(values) if span.log else values
    if len(points) == 1:
        return np.array([span.low, span.high])
    middle = 0.5 * (points[1:] + points[:-1])
    ends = 2.0 * points[0] - middle[0], 2.0 * points[-1] - middle[-1]
    edges = np.array([ends[0], *middle, ends[1]])
    return np.exp(edges) if span.log else edges


def _draw_cells(axes: Axes, table: SweepTable, values: np.ndarray, norm: Normalize) -> list[Patch]:
    """Draw the cells of a grid; return additional handles for its legend."""
    x, y = table.ranges
    edges_x, edges_y = cell_edges(x.grid, x), cell_edges(y.grid, y)
    columns = np.abs(table.parameters[:, 0, None] - x.grid).argmin(axis=1)
    rows = np.abs(table.parameters[:, 1, None] - y.grid).argmin(axis=1)
    cells = np.full((y.points, x.points), np.nan)
    cells[rows, columns] = values
    axes.pcolormesh(edges_x, edges_y, cells, norm=norm, cmap=SWEEP_COLOUR_MAP)
    lost = np.isfinite(table.diverged_at)
    kinds = [
        (lost, LOST_HATCH, "diverged"),
        (~lost & np.isnan(values), _NO_VALUE_STYLE, "no value"),
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
    area = _DOT_AREA_PT2 * min(1.0, 200.0 / max(1, len(table)))
    axes.scatter(a[known], b[known], area, values[known], norm=norm, cmap=SWEEP_COLOUR_MAP, lw=0.0)
    other = ~known & ~lost
    if other.any():
        axes.scatter(a[other], b[other], area, _NO_VALUE_COLOUR, lw=0.0, label="no value")
    if lost.any():
        axes.scatter(a[lost], b[lost], area, "0.5", marker="x", lw=1.0, label="diverged")
    return []


def draw_clouds(table: SweepTable, metric: Metric, best: BestCandidate | None) -> Figure:
    """Return the figure, with each number's rank correlation with the metric."""
    count = len(table.ranges)
    columns = min(_CLOUD_COLUMNS, count)
    rows = math.ceil(count / columns)
    figure = Figure(figsize=(3.9 * columns, 2.9 * rows + 0.7), layout="constrained")
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
    values = shown_values(table, metric)
    low, high = colour_limits(values)
    for index, axes in enumerate(panels.flat):
        if index >= count:
            axes.set_axis_off()
            continue
        _draw_cloud(axes, table, index, values, best)
        axes.set_xlabel(axis_label(table.ranges[index]))
    for axes in panels[:, 0]:
        axes.set_ylabel(metric_label(table, metric))
    room = 0.06 * (high - low)
    panels[0, 0].set_ylim(low - room, high + room)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=4)
    return figure


def _draw_cloud(
    axes: Axes,
    table: SweepTable,
    index: int,
    values: np.ndarray,
    best: BestCandidate | None,
) -> None:
    """Draw one panel, with lost candidates at its bottom."""
    span, x = table.ranges[index], table.parameters[:, index]
    if span.log:
        axes.set_xscale("log")
    axes.plot(x, values, ".", color=PALETTE.ours, ms=4, alpha=0.6, label="candidates")
    lost = np.isfinite(table.diverged_at)
    if lost.any():
        foot = axes.get_xaxis_transform()
        axes.plot(
            x[lost],
            np.full(lost.sum(), 0.02),
            "x",
            color="0.5",
            ms=4,
            transform=foot,
            label="diverged",
        )
    if span.low <= table.present[index] <= span.high:
        axes.axvline(table.present[index], color=PALETTE.command, ls="--", lw=1.2, label="present")
    if best:
        axes.plot(x[best.index], values[best.index], ls="", label="best", zorder=6, **BEST_MARKER)
    correlation = rank_correlation(x, values)
    told = "" if np.isnan(correlation) else f": rank correlation {correlation:+.2f}"
    axes.set_title(f"{span.name}{told}")


def rank_correlation(x: np.ndarray, y: np.ndarray) -> float:
    """Return Spearman's rank correlation of values finite in both, NaN if meaningless."""
    from scipy.stats import rankdata

    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < 3 or np.ptp(x[known]) == 0.0 or np.ptp(y[known]) == 0.0:
        return float("nan")
    return float(np.corrcoef(rankdata(x[known]), rankdata(y[known]))[0, 1])


@styled
def plot_sweep(table: SweepTable, metric: str, best: BestCandidate | None = None) -> Figure:
    """Return the figure of a sweep.

    Args:
        table: of the sweep.
        metric: the one to draw.
        best: the candidate to mark, if any.

    Raises:
        WorkbenchError: if the metric is unknown or was not measured.
    """
    shown = table.metric(metric)
    case = table.case
    what = f"{case.axis} step of {case.amplitude:g} {find_axis(case.axis).unit}"
    title = f"{table.vehicle}: {what}, {shown.name.replace('_', ' ')} of {len(table)} candidates"
    if len(table.ranges) == 1:
        figure = _draw_curves(table, shown, best)
    elif len(table.ranges) == 2:
        figure = draw_metric_map(table, shown, best)
    else:
        figure = draw_clouds(table, shown, best)
    note = unaffected_numbers_text(table, metric)
    figure.suptitle(
        f"{title}\n{note}" if note else title, x=0.01, ha="left", fontsize=11, fontweight="bold"
    )
    return figure


def _draw_curves(table: SweepTable, shown: Metric, best: BestCandidate | None) -> Figure:
    """Draw metrics over the only swept parameter."""
    names = dict.fromkeys(
        (shown.name, *_DRAWN_METRICS, *(metric.name for metric in MARGIN_METRICS))
    )
    metrics = [m for name in names for m in table.metrics if m.name == name]
    figure = Figure(figsize=(8.2, 1.5 * len(metrics) + 1.0), layout="constrained")
    panels = list(figure.subplots(len(metrics), 1, sharex=True, squeeze=False)[:, 0])
    order = np.argsort(table.parameters[:, 0])
    x = table.parameters[order, 0]
    for axes, metric in zip(panels, metrics, strict=True):
        scale = display_unit(metric.unit).factor
        axes.plot(x, scale * table.column(metric.name)[order], ".-", color=PALETTE.ours, ms=4)
        axes.set_title(metric.name.replace("_", " "))
        axes.set_ylabel(metric_label(table, metric).split(" ")[-1])
        _mark_sweep_values(axes, table, order, best)
    panels[-1].set_xlabel(axis_label(table.ranges[0]))
    if table.ranges[0].log:
        panels[-1].set_xscale("log")
    panels[-1].set_xlim(table.ranges[0].low, table.ranges[0].high)
    handles = {label: h for h, label in zip(*panels[0].get_legend_handles_labels(), strict=True)}
    if handles:
        figure.legend(handles.values(), handles.keys(), loc="outside right upper")
    figure.align_ylabels(panels)
    return figure


def _mark_sweep_values(
    axes: Axes, table: SweepTable, order: np.ndarray, best: BestCandidate | None
) -> None:
    """Mark the present and the best values, and hatch the regions of lost candidates."""
    span = table.ranges[0]
    if span.low <= table.present[0] <= span.high:
        axes.axvline(table.present[0], color=PALETTE.command, ls="--", lw=1.2, label="present")
    if best:
        axes.axvline(best.parameters[0], color=PALETTE.mean, lw=1.2, label="best")
    lost = np.isfinite(table.diverged_at[order])
    edges = cell_edges(table.parameters[order, 0], span)
    for index in np.flatnonzero(lost):
        axes.axvspan(edges[index], edges[index + 1], label="diverged", zorder=0, **LOST_HATCH)
