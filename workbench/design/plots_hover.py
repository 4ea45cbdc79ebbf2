"""The figure of a hover check: drift and tilt of the hover, and the four steps."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.hover_check import DRIFT, OVERSHOOT, TILT, HoverReport
from workbench.design.plots import PALETTE, label, legend, styled, widen
from workbench.design.plots_panels import BEFORE, draw_response, shown_part
from workbench.design.response_metrics import number
from workbench.design.step_response import EDGE, StepResponse, axis_command, axis_velocity


@styled
def plot_hover(report: HoverReport) -> Figure:
    """Return the figure of a hover check."""
    figure = Figure(figsize=(12.5, 8.4), layout="constrained")
    vehicle = report.hover.vehicle
    figure.suptitle(
        f"{vehicle.name}: ten seconds of hover, and a step on every axis",
        x=0.01,
        ha="left",
        fontsize=11,
        fontweight="bold",
    )
    panels = figure.subplots(3, 2)
    time = report.hover.time
    _draw_hover(panels[0, 0], time, 1000.0 * report.drift, 1000.0 * DRIFT)
    label(panels[0, 0], "distance from where it began", "distance [mm]")
    _draw_hover(panels[0, 1], time, np.degrees(report.tilt), float(np.degrees(TILT)))
    label(panels[0, 1], "tilt away from where it began", "angle [deg]")
    legend(panels[0, 1])
    for axes, step in zip(panels[1:].flat, report.steps, strict=True):
        _draw_step(axes, step)
    for axes in panels[1:, 1]:
        legend(axes)
    figure.align_ylabels()
    return figure


def _draw_hover(axes: Axes, time: np.ndarray, values: np.ndarray, limit: float) -> None:
    """Draw what a hover must keep small, with its limit."""
    axes.plot(time, values, color=PALETTE.ours, label="flown")
    axes.axhline(limit, color=PALETTE.limit, lw=1.0, label="limit")
    axes.set_xlim(time[0], time[-1])
    widen(axes, values, 0.0, limit)
    axes.set_xlabel("time [s]")


def _draw_step(axes: Axes, step: StepResponse) -> None:
    """Draw command and response with the overshoot that is allowed."""
    shown = shown_part(step)
    draw_response(axes, shown, step.axis)
    steady = step.metrics.steady_state_value
    most = (1.0 + OVERSHOOT / 100.0) * (step.amplitude if math.isnan(steady) else steady)
    axes.axhline(most, color=PALETTE.limit, lw=1.0, label=f"overshoot of {OVERSHOOT:g} %")
    widen(axes, axis_velocity(shown, step.axis), axis_command(shown, step.axis), most)
    over = number(step.metrics.overshoot, ".1f")
    axes.set_title(f"{axes.get_title(loc='left')}, overshoot {over} %")
    axes.set_xlim(-BEFORE, shown.time[-1] - EDGE)
    axes.set_xlabel("time since the command's edge [s]")
