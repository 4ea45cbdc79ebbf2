"""The figure of an identification: intervals, a part of the flight, and correlations of errors."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.plots import as_text
from workbench.extras.flightdata.identify.flight_piece import make_piece
from workbench.extras.flightdata.identify.model_rows import model_rows
from workbench.extras.flightdata.identify.report import IdentificationReport
from workbench.extras.flightdata.identify.search import MIN_FREE_RUN_S

MIN_COMPARED_VALUE = 1e-7
"""Smallest described value for a comparison."""
DRAWN_SPAN_S = 6.0
"""Time drawn of the run with the most motion [s]."""


def draw_identified(report: IdentificationReport, path: Path) -> None:
    """Draw the figure to a file."""
    as_text(plot_identified(report)).savefig(path, dpi=120)


def plot_identified(report: IdentificationReport) -> Figure:
    """Return the figure of an identification."""
    figure = Figure(figsize=(11.0, 8.5), layout="constrained")
    grid = figure.add_gridspec(2, 1)
    upper, lower = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    left, right = upper.subplots(1, 2, width_ratios=(3, 2))
    _draw_intervals(left, report)
    _draw_whiteness(right, report)
    _draw_flight(lower.subplots(2, 1, sharex=True), report)
    return figure


def _draw_intervals(axes: Axes, report: IdentificationReport) -> None:
    known = [(row, row.described) for row in report.rows if row.described]
    rows = [row for row, described in known if abs(described) > MIN_COMPARED_VALUE]
    shares = [
        [each / described for each in (row.value, row.low, row.high)]
        for row, described in known
        if abs(described) > MIN_COMPARED_VALUE
    ]
    for place, (value, low, high) in enumerate(reversed(shares)):
        axes.plot([low, high], [place, place], color="C0", linewidth=3, alpha=0.5)
        axes.plot(value, place, "o", color="C0")
    axes.axvline(1.0, color="black", linewidth=0.8)
    axes.set_yticks(range(len(rows)), [row.name for row in reversed(rows)])
    axes.set_xlabel("over what is described, with intervals of 95 %")
    ends = [high for _, _, high in shares]
    axes.set_xlim(0.0, min(4.0, max([2.0, *(1.1 * end for end in ends)])))


def _draw_whiteness(axes: Axes, report: IdentificationReport) -> None:
    fit = report.found.fit
    lags = np.arange(1, report.correlations.shape[1] + 1) / report.correlations.shape[1]
    for name, line in zip(fit.channels, report.correlations, strict=True):
        axes.plot(lags, line, linewidth=0.8, label=name)
    bound = 1.96 / math.sqrt(len(fit.innovations))
    axes.axhspan(-bound, bound, color="0.85", zorder=0)
    axes.set_xlabel("lag [s]")
    axes.set_ylabel("autocorrelation of errors of prediction")
    axes.legend(fontsize="small")


def _draw_flight(rows: Sequence[Axes], report: IdentificationReport) -> None:
    found = report.found
    runs = [run for flight in found.flights for run in flight.pieces(MIN_FREE_RUN_S)]
    run = max(runs, key=lambda each: float(np.std(each.force[:, 2])))
    many = min(len(run.time), round((DRAWN_SPAN_S + 1.0) * run.rate))
    begin = max(0, (len(run.time) - many) // 2)
    run = run.only(slice(begin, begin + many))
    piece = make_piece(run, found.vehicle)
    model = model_rows(found.vehicle, found.fit.named, piece)
    time = run.time[0] + np.arange(len(model)) * piece.row
    skip = time > time[0] + 0.5
    force, turn = rows
    force.plot(time[skip], piece.force[skip, 2], color="0.6", label="measured")
    force.plot(time[skip], model[skip, 5], color="C0", label="model")
    force.set_ylabel("specific force along z [m/s²]")
    force.legend(loc="upper right", fontsize="small")
    axis = int(np.argmax(np.std(piece.turn, axis=0)))
    size = max(1, round(0.03 / piece.row))
    shape = np.ones(size) / size
    turn.plot(time[skip], np.convolve(piece.turn[:, axis], shape, "same")[skip], color="0.6")
    turn.plot(time[skip], np.convolve(model[:, axis], shape, "same")[skip], color="C0")
    turn.set_ylabel(f"angular acceleration\nabout {'xyz'[axis]} [rad/s²], mean of 30 ms")
    turn.set_xlabel("time [s]")
