"""Panels of a loop over frequency: Bode's two, and Nyquist's with the disk of the disk margin."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from workbench.design.judge.loop_response import LoopResponses
from workbench.design.judge.margins import LoopMargins, frequency_grid
from workbench.design.plots import PALETTE, label

_DISK_REACH = 60.0
"""A disk wider than this is drawn as if it were as wide: a straight edge."""
_PLATE = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
"""Behind words that a curve may pass under."""


def shown_frequencies(loops: LoopResponses, margins: LoopMargins) -> np.ndarray:
    """Return the frequencies (F) [rad/s] worth showing: around the crossover, up to the highest."""
    grid = frequency_grid(loops)
    middle = margins.crossover if np.isfinite(margins.crossover) else grid[-1] / 100.0
    return grid[(grid > middle / 50.0) & (grid < middle * 100.0)]


def draw_magnitude(
    axes: Axes, frequency: np.ndarray, response: np.ndarray, margins: LoopMargins
) -> None:
    """Draw |L|, |S| and |T|, with crossover and bandwidth."""
    curves = (
        ("L", response, "-", PALETTE.ours),
        ("S = 1 / (1 + L)", 1.0 / (1.0 + response), "--", PALETTE.mean),
        ("T = L / (1 + L)", response / (1.0 + response), "-.", PALETTE.series[2]),
    )
    for name, curve, dashes, colour in curves:
        axes.semilogx(frequency, _decibel(curve), dashes, color=colour, label=name)
    axes.axhline(0.0, color=PALETTE.command, lw=0.8)
    left = float(np.fmin(margins.crossover, margins.bandwidth))
    _mark_frequency(axes, margins.crossover, PALETTE.ours, "crossover", (left, 0.02))
    _mark_frequency(axes, margins.bandwidth, PALETTE.series[2], "bandwidth", (left, 0.08))
    axes.set_ylim(-45.0, 45.0)
    label(axes, "Bode: magnitude", "magnitude [dB]")
    axes.set_xlabel("frequency [rad/s]")
    axes.legend(loc="upper right", fontsize=7.5)


def draw_phase(
    axes: Axes, frequency: np.ndarray, response: np.ndarray, margins: LoopMargins
) -> None:
    """Draw the phase of L, with the phase margin at the crossover."""
    phase = np.degrees(np.unwrap(np.angle(response)))
    at = np.interp(margins.crossover, frequency, phase) if margins.crossover > 0.0 else phase[0]
    phase -= 360.0 * round((at + 180.0) / 360.0 - 0.25)
    axes.semilogx(frequency, phase, color=PALETTE.ours)
    axes.axhline(-180.0, color=PALETTE.limit, lw=1.0)
    if math.isfinite(margins.crossover) and margins.stable:
        at = float(np.interp(margins.crossover, frequency, phase))
        axes.plot([margins.crossover] * 2, [-180.0, at], color=PALETTE.mean, lw=2.5)
        axes.annotate(
            f"{at + 180.0:.0f} deg",
            (margins.crossover, -180.0),
            xytext=(0, -4 if at > -180.0 else 4),
            textcoords="offset points",
            ha="center",
            va="top" if at > -180.0 else "bottom",
            fontsize=8,
            color=PALETTE.mean,
            bbox=_PLATE,
        )
    low, high = min(float(phase.min()), -200.0), max(float(phase.max()), -80.0)
    axes.set_ylim(max(low, -450.0) - 10.0, high + 10.0)
    axes.yaxis.set_major_locator(MultipleLocator(45.0))
    label(axes, "Bode: phase, with its margin at the crossover", "phase [deg]")
    axes.set_xlabel("frequency [rad/s]")


def draw_nyquist(
    axes: Axes, response: np.ndarray, margins: LoopMargins, *, legend: bool = True
) -> None:
    """Draw L in the complex plane, with the disk that it must not enter."""
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(np.cos(turn), np.sin(turn), ":", color="0.5", lw=1.0, label="unit circle")
    if margins.disk_margin > 0.0:
        share = min(0.5 * margins.disk_margin, 1.0 - 1.0 / _DISK_REACH)
        near, far = (1.0 - share) / (1.0 + share), (1.0 + share) / (1.0 - share)
        axes.fill(
            -0.5 * (near + far) + 0.5 * (far - near) * np.cos(turn),
            0.5 * (far - near) * np.sin(turn),
            color=PALETTE.window,
            label=f"disk margin {margins.disk_margin:.2f}",
            zorder=0,
        )
    axes.plot(response.real, response.imag, color=PALETTE.ours, label="L")
    axes.plot(response.real, -response.imag, color=PALETTE.ours, lw=0.7, alpha=0.5)
    axes.plot([-1.0], [0.0], "+", color=PALETTE.limit, ms=9, mew=1.8, label="-1")
    for factor in (margins.gain_margin, margins.gain_reduction_margin):
        if factor > 0.0 and math.isfinite(factor) and margins.stable and 1.0 / factor < 3.2:
            axes.plot([-1.0 / factor], [0.0], "o", color=PALETTE.mean, ms=4)
    axes.set_xlim(-3.2, 1.6)
    axes.set_ylim(-2.4, 2.4)
    axes.set_aspect("equal")
    label(axes, "Nyquist", "imaginary part [1]")
    axes.set_xlabel("real part [1]")
    if legend:
        axes.legend(loc="lower left", fontsize=7.5, frameon=True, framealpha=0.85, edgecolor="none")


def _decibel(values: np.ndarray) -> np.ndarray:
    decibel: np.ndarray = 20.0 * np.log10(np.maximum(np.abs(values), 1e-9))
    return decibel


def _mark_frequency(
    axes: Axes, frequency: float, colour: str, name: str, place: tuple[float, float]
) -> None:
    """Mark a frequency, if there is one, and name it left of a place in the panel.

    Left of crossover and bandwidth there is always room; their colours tell them apart.
    """
    if math.isfinite(frequency):
        axes.axvline(frequency, color=colour, lw=0.9, ls=":")
        axes.annotate(
            f"{name} {frequency:.3g}",
            place,
            xycoords=("data", "axes fraction"),
            xytext=(-4, 0),
            textcoords="offset points",
            ha="right",
            fontsize=7.5,
            color=colour,
            bbox=_PLATE,
        )
