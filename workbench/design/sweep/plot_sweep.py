"""The picture of a sweep: curves over one parameter, a map over two, clouds over more."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.metrics import MARGINS, Metric, for_people
from workbench.design.plots import PALETTE, styled
from workbench.design.sweep.best import BestCandidate, what_does_not_move
from workbench.design.sweep.plot_clouds import draw_clouds
from workbench.design.sweep.plot_map import cell_edges, draw_map
from workbench.design.sweep.plot_marks import HATCH, axis_label, metric_label
from workbench.design.sweep.table import SweepTable
from workbench.scenario.axes import find_axis

_CURVES = ("rise_time", "settling_time", "overshoot", "steady_state_error", "peak_rotor_use")
"""Drawn besides the metric that is asked for, and margins."""


@styled
def plot_sweep(table: SweepTable, metric: str, best: BestCandidate | None = None) -> Figure:
    """Return the picture of a sweep.

    Args:
        table: what was flown.
        metric: that is drawn.
        best: marked, where there is one.

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
        figure = draw_map(table, shown, best)
    else:
        figure = draw_clouds(table, shown, best)
    note = what_does_not_move(table, metric)
    figure.suptitle(
        f"{title}\n{note}" if note else title, x=0.01, ha="left", fontsize=11, fontweight="bold"
    )
    return figure


def _draw_curves(table: SweepTable, shown: Metric, best: BestCandidate | None) -> Figure:
    """Draw metrics over the one parameter that was swept."""
    names = dict.fromkeys((shown.name, *_CURVES, *(metric.name for metric in MARGINS)))
    metrics = [m for name in names for m in table.metrics if m.name == name]
    figure = Figure(figsize=(8.2, 1.5 * len(metrics) + 1.0), layout="constrained")
    panels = list(figure.subplots(len(metrics), 1, sharex=True, squeeze=False)[:, 0])
    order = np.argsort(table.parameters[:, 0])
    x = table.parameters[order, 0]
    for axes, metric in zip(panels, metrics, strict=True):
        scale, _ = for_people(metric.unit)
        axes.plot(x, scale * table.column(metric.name)[order], ".-", color=PALETTE.ours, ms=4)
        axes.set_title(metric.name.replace("_", " "))
        axes.set_ylabel(metric_label(table, metric).split(" ")[-1])
        _mark(axes, table, order, best)
    panels[-1].set_xlabel(axis_label(table.ranges[0]))
    if table.ranges[0].log:
        panels[-1].set_xscale("log")
    panels[-1].set_xlim(table.ranges[0].low, table.ranges[0].high)
    handles = {label: h for h, label in zip(*panels[0].get_legend_handles_labels(), strict=True)}
    if handles:
        figure.legend(handles.values(), handles.keys(), loc="outside right upper")
    figure.align_ylabels(panels)
    return figure


def _mark(axes: Axes, table: SweepTable, order: np.ndarray, best: BestCandidate | None) -> None:
    """Mark what is and what is best, and hatch where candidates were lost."""
    span = table.ranges[0]
    if span.low <= table.present[0] <= span.high:
        axes.axvline(table.present[0], color=PALETTE.command, ls="--", lw=1.2, label="present")
    if best:
        axes.axvline(best.parameters[0], color=PALETTE.mean, lw=1.2, label="best")
    lost = np.isfinite(table.diverged_at[order])
    edges = cell_edges(table.parameters[order, 0], span)
    for index in np.flatnonzero(lost):
        axes.axvspan(edges[index], edges[index + 1], label="diverged", zorder=0, **HATCH)
