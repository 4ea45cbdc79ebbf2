"""The figure of one step: command and response, force, acceleration, rotor speeds."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.plots import PALETTE, legend, stacked, styled
from workbench.design.plots_panels import (
    BEFORE,
    draw_acceleration,
    draw_force,
    draw_response,
    draw_rotor_use,
    shown_part,
)
from workbench.design.response_metrics import StepMetrics, number
from workbench.design.step_response import EDGE, StepResponse
from workbench.scenario.axes import find_axis

_BAND = 0.02
"""What counts as settled, as share of the steady state; python-control's default."""
_WIDTH = 26
"""Of a sentence beside a panel [characters]."""


@styled
def plot_step(step: StepResponse) -> Figure:
    """Return a step's figure, with its settling band and metrics."""
    axis = step.axis
    shown = shown_part(step)
    time = shown.time - EDGE
    figure, panels = stacked(
        f"{shown.vehicle.name}: {axis} step of {step.amplitude:g} {find_axis(axis).unit}", 4
    )
    response, drive, acceleration, rotors = panels
    draw_response(response, shown, axis)
    _draw_settling(response, step.metrics)
    legend(response)
    draw_force(drive, shown, axis)
    draw_acceleration(acceleration, shown, axis)
    draw_rotor_use(rotors, time, shown)
    legend(rotors)
    rotors.set_xlim(-BEFORE, time[-1])
    _write_metrics(drive, step)
    figure.align_ylabels()
    return figure


def _draw_settling(axes: Axes, metrics: StepMetrics) -> None:
    """Draw the band within which the response counts as settled, and when it does."""
    steady = metrics.steady_state_value
    if np.isnan(steady):
        return
    band = abs(_BAND * steady)
    axes.axhspan(
        steady - band,
        steady + band,
        color=PALETTE.window,
        lw=0,
        zorder=0,
        label="steady state ± 2 %",
    )
    if np.isfinite(metrics.settling_time):
        axes.axvline(metrics.settling_time, color=PALETTE.mean, ls=":", label="settled")


def _write_metrics(axes: Axes, step: StepResponse) -> None:
    """Write the metrics beside a panel."""
    metrics, unit = step.metrics, find_axis(step.axis).unit
    lines = (
        f"rise time  {number(metrics.rise_time, '.3f')} s",
        f"settling time  {number(metrics.settling_time, '.3f')} s",
        f"overshoot  {number(metrics.overshoot, '.2f')} %",
        f"undershoot  {number(metrics.undershoot, '.2f')} %",
        f"steady state  {number(metrics.steady_state_value, '.4g')} {unit}",
        f"error  {number(metrics.steady_state_error, '.2f')} %",
        f"peak rotor use  {100.0 * step.peak_rotor_use:.0f} %",
        *textwrap.wrap(metrics.withheld, _WIDTH),
    )
    axes.annotate(
        "\n".join(lines),
        (1.0, 1.0),
        xytext=(8, 0),
        xycoords="axes fraction",
        textcoords="offset points",
        va="top",
        fontsize=8.5,
        linespacing=1.5,
    )
