"""The figure of a step of a load: the load, the response, tilt and rotor speeds."""

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.load_metrics import BACK, LoadMetrics
from workbench.design.load_step import LoadResponse, moved
from workbench.design.plots import PALETTE, label, legend, stacked, styled, widen
from workbench.design.plots_panels import BEFORE, draw_rotor_use
from workbench.design.response_metrics import number
from workbench.design.step_response import EDGE
from workbench.scenario.loads import find_load

WIDTH = 26
"""Of a sentence beside a panel [characters]."""


@styled
def plot_load(flown: LoadResponse) -> Figure:
    """Return the figure of a load, with the band within which it counts as settled."""
    load = find_load(flown.load)
    end = float(flown.time[-1])
    shown = flown.recording.between(EDGE - BEFORE, EDGE + end)
    time = shown.time - EDGE
    figure, panels = stacked(
        f"{shown.vehicle.name}: {load.label}, a step of {flown.amplitude:.4g} {load.unit}", 4
    )
    pushed, response, tilt, rotors = panels
    acting = np.where(time >= 0.0, flown.amplitude, 0.0)
    pushed.plot(time, acting, color=PALETTE.command, drawstyle="steps-post", label="load")
    widen(pushed, acting)
    label(pushed, f"load: {load.label}", f"{load.name.partition('_')[0]} [{load.unit}]")
    deviation = moved(load, shown)
    response.plot(time, deviation, color=PALETTE.ours, label="response")
    widen(response, deviation)
    label(response, f"response: {load.response}", f"deviation [{load.response_unit}]")
    _draw_settling(response, flown.metrics, float(deviation[-1]))
    legend(response)
    tilt.plot(time, np.degrees(shown.tilt), color=PALETTE.ours)
    widen(tilt, np.degrees(shown.tilt))
    label(tilt, "tilt", "tilt [°]")
    draw_rotor_use(rotors, time, shown)
    legend(rotors)
    rotors.set_xlim(-BEFORE, time[-1])
    _write_metrics(pushed, flown)
    figure.align_ylabels()
    return figure


def _draw_settling(axes: Axes, metrics: LoadMetrics, steady: float) -> None:
    """Draw the band within which the response counts as settled, and when it does."""
    if np.isnan(metrics.settling_time):
        return
    band = BACK * metrics.peak
    axes.axhspan(
        steady - band,
        steady + band,
        color=PALETTE.window,
        lw=0,
        zorder=0,
        label="steady state ± 5 % of the peak",
    )
    axes.axvline(metrics.settling_time, color=PALETTE.mean, ls=":", label="settled")


def _write_metrics(axes: Axes, flown: LoadResponse) -> None:
    """Write the metrics beside a panel."""
    metrics, unit = flown.metrics, find_load(flown.load).response_unit
    lines = (
        f"peak  {number(metrics.peak, '.4g')} {unit}",
        f"peak time  {number(metrics.peak_time, '.3f')} s",
        f"settling time  {number(metrics.settling_time, '.3f')} s",
        f"steady error  {number(metrics.steady_state_error, '.1f')} % of the peak",
        f"peak rotor use  {100.0 * flown.peak_rotor_use:.0f} %",
        *textwrap.wrap(metrics.withheld, WIDTH),
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
