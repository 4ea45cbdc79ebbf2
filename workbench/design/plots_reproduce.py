"""The paper's figures 8-11: command and response, force or torque, acceleration."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.plots import PALETTE, legend, stacked, styled, widen
from workbench.design.plots_panels import (
    BEFORE,
    draw_acceleration,
    draw_force,
    draw_response,
    shown_part,
)
from workbench.design.reproduce import Row
from workbench.design.step_response import (
    EDGE,
    axis_acceleration,
    axis_force,
)
from workbench.scenario.axes import find_axis

_FAR = 3.0
"""A paper's mean further off than this many spans of our curve is named instead of drawn."""


@styled
def plot_reproduced(row: Row) -> Figure:
    """Return a step's figure, with the panels that the paper has."""
    axis, paper = row.paper.axis, row.paper
    shown = shown_part(row.flight)
    figure, panels = stacked(
        f"{shown.vehicle.name} beside the paper's figure {paper.number}: "
        f"{axis} step of {paper.command:g} {find_axis(axis).unit}",
        3,
    )
    response, drive, acceleration = panels
    draw_response(response, shown, axis)
    draw_force(drive, shown, axis)
    _draw_means(
        drive,
        axis_force(shown, axis),
        row.t90,
        row.mean_force,
        paper.mean_force,
        find_axis(axis).force_unit,
    )
    draw_acceleration(acceleration, shown, axis)
    _draw_means(
        acceleration,
        axis_acceleration(shown, axis),
        row.t90,
        row.mean_acceleration,
        paper.mean_acceleration,
        find_axis(axis).acceleration_unit,
    )
    for axes, letter in zip(panels, "abc", strict=True):
        axes.set_title(f"({letter}) {axes.get_title(loc='left')}")
        if np.isfinite(row.t90):
            axes.axvspan(0.0, row.t90, color=PALETTE.window, lw=0, zorder=0, label="window")
        legend(axes)
    figure.align_ylabels()
    panels[-1].set_xlim(-BEFORE, shown.time[-1] - EDGE)
    return figure


def _draw_means(
    axes: Axes, values: np.ndarray, t90: float, mean: float, paper: float, unit: str
) -> None:
    """Draw a curve's mean over the window beside the paper's."""
    if np.isfinite(t90):
        axes.plot(
            [0.0, t90],
            [mean, mean],
            color=PALETTE.mean,
            lw=2.2,
            solid_capstyle="butt",
            label=f"mean in window {mean:.3g} {unit}",
        )
    name = f"paper's mean {paper:g} {unit}"
    if abs(paper) <= _FAR * float(np.abs(values).max()):
        axes.axhline(paper, color=PALETTE.paper, ls="--", lw=1.3, label=name)
        widen(axes, values, paper)
    else:
        axes.plot(
            [], [], color=PALETTE.paper, ls="--", lw=1.3, label=f"{name}\n(far off this scale)"
        )
