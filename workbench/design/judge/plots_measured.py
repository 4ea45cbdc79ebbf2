"""The picture of a measured loop: Bode beside its linear model, with coherence and spread."""

import math

import numpy as np
from matplotlib.figure import Figure

from workbench.design.judge.loop_measurement import Measurement
from workbench.design.judge.measured_loop import COHERENT
from workbench.design.plots import PALETTE, label, legend, stacked, styled

SIGMAS = 2.0
"""Half the height of the bars, in standard deviations."""


@styled
def plot_measurement(found: Measurement) -> Figure:
    """Return the figure of a measurement; lines that are not coherent are pale."""
    measured, model = found.measured, found.model
    frequency, good = measured.frequency, measured.coherence >= COHERENT
    figure, panels = stacked(f"{found.vehicle}: {found.loop}, as modelled and as measured", 3)
    sizes, phases, coherence = panels
    spread = np.minimum(SIGMAS * measured.deviation, 0.9)
    modelled = np.unwrap(np.angle(model))
    turned = modelled + np.angle(measured.response / model)
    for axes, curve, points, bars in (
        (
            sizes,
            _decibel(model),
            _decibel(measured.response),
            np.array([-_decibel(1.0 - spread), _decibel(1.0 + spread)]),
        ),
        (phases, np.degrees(modelled), np.degrees(turned), np.degrees(np.array([spread, spread]))),
    ):
        axes.semilogx(frequency, curve, color=PALETTE.mean, label="linear model")
        for which, alpha, name in ((good, 1.0, "measured, two sigmas"), (~good, 0.25, "")):
            axes.errorbar(
                frequency[which],
                points[which],
                bars[:, which],
                fmt="o",
                ms=3.0,
                lw=1.0,
                color=PALETTE.ours,
                alpha=alpha,
                label=name or None,
            )
    low, high = _decibel(model).min(), _decibel(model).max()
    sizes.set_ylim(low - 8.0, high + 8.0)
    shown = np.degrees(modelled)
    phases.set_ylim(shown.min() - 40.0, shown.max() + 40.0)
    label(sizes, "open loop: magnitude", "|L| [dB]")
    label(phases, "open loop: phase", "phase [°]")
    legend(sizes)
    coherence.semilogx(frequency, measured.coherence, "o-", ms=3.0, color=PALETTE.ours)
    coherence.axhline(COHERENT, color=PALETTE.limit, lw=1.0)
    coherence.set_ylim(-0.03, 1.05)
    label(coherence, "coherence, the lower end of its interval", "coherence [1]")
    for axes in panels:
        if math.isfinite(found.margins.bandwidth):
            axes.axvline(found.margins.bandwidth, color=PALETTE.command, lw=0.8)
    coherence.set_xlabel("frequency [rad/s], the line is the bandwidth")
    figure.align_ylabels()
    return figure


def _decibel(values: np.ndarray) -> np.ndarray:
    found: np.ndarray = 20.0 * np.log10(np.abs(values))
    return found
