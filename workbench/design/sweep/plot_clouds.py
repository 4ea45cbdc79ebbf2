"""A metric over each of many swept numbers, a cloud of candidates a panel."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.metrics import Metric
from workbench.design.plots import PALETTE
from workbench.design.sweep.best import BestCandidate
from workbench.design.sweep.plot_marks import (
    BEST,
    axis_label,
    colour_limits,
    metric_label,
    shown_values,
)
from workbench.design.sweep.table import SweepTable

_COLUMNS = 3


def draw_clouds(table: SweepTable, metric: Metric, best: BestCandidate | None) -> Figure:
    """Return the figure, with each number's rank correlation with the metric."""
    count = len(table.ranges)
    columns = min(_COLUMNS, count)
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
    """Draw one panel; what was lost stands at its foot."""
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
        axes.plot(x[best.index], values[best.index], ls="", label="best", zorder=6, **BEST)
    correlation = rank_correlation(x, values)
    told = "" if np.isnan(correlation) else f": rank correlation {correlation:+.2f}"
    axes.set_title(f"{span.name}{told}")


def rank_correlation(x: np.ndarray, y: np.ndarray) -> float:
    """Return Spearman's rank correlation of what is finite in both, NaN if that says nothing."""
    from scipy.stats import rankdata

    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < 3 or np.ptp(x[known]) == 0.0 or np.ptp(y[known]) == 0.0:
        return float("nan")
    return float(np.corrcoef(rankdata(x[known]), rankdata(y[known]))[0, 1])
