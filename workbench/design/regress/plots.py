"""The picture of a flown curve over its band."""

import io
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.plots import PALETTE, legend, styled, widen
from workbench.design.regress.verdict import Comparison

_SVG: Any = {"svg.fonttype": "none", "svg.hashsalt": "workbench", "path.simplify": True}
LEAST_SPAN = 1e-3
"""Numerical noise does not fill a picture."""


@styled
def plot_curve(curve: Comparison) -> Figure:
    """Return a curve's figure: what was flown, the baseline, the band, and where it is left.

    A second panel shows all of it as differences from the baseline, where a narrow band is seen.
    """
    beside = curve.baseline is not None
    figure = Figure(figsize=(10.0 if beside else 6.2, 2.5), layout="constrained")
    panels = figure.subplots(1, 2 if beside else 1, squeeze=False)[0]
    _draw(panels[0], curve, np.zeros(len(curve.flown.time)))
    panels[0].set_ylabel(f"{curve.signal} [{curve.unit}]")
    if curve.baseline is not None:
        middle = np.interp(curve.flown.time, curve.baseline.time, curve.baseline.values)
        _draw(panels[1], curve, middle)
        panels[1].set_ylabel(f"difference [{curve.unit}]")
        legend(panels[1])
    return figure


def _draw(axes: Axes, curve: Comparison, less: np.ndarray) -> None:
    """Draw everything, less some values at the flown times."""
    time, values = curve.flown.time, curve.flown.values - less
    shown = [values]
    if curve.band is not None and curve.baseline is not None:
        low, high = curve.band.low - less, curve.band.high - less
        axes.fill_between(time, low, high, color=PALETTE.window, lw=0, label="allowed")
        baseline = np.interp(time, curve.baseline.time, curve.baseline.values) - less
        axes.plot(time, baseline, color=PALETTE.command, ls="--", lw=1.1, label="baseline")
        shown += [low, high]
    axes.plot(time, values, color=PALETTE.ours, label="flown")
    outside = curve.excesses > 0.0
    if outside.any():
        beyond = np.where(outside, values, np.nan)
        axes.plot(time, beyond, color=PALETTE.limit, lw=2.6, label="out of band")
    widen(axes, *shown, least=LEAST_SPAN)
    axes.set_xlim(time[0], time[-1])
    axes.set_xlabel("time since the edge [s]")


def inline_svg(figure: Figure) -> str:
    """Return a figure as an <svg> element to stand in a page."""
    stream = io.StringIO()
    with rc_context(_SVG):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]
