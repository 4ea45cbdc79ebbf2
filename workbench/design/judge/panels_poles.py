"""Panels of poles: the root locus over a loop's gain, and the map of the closed loop's poles.

Poles of the sampled loop are drawn in continuous terms, s = ln(z) / period.
"""

import math

import numpy as np
from matplotlib.axes import Axes

from workbench.design.judge.loop_response import CutModel
from workbench.design.judge.margins import LoopMargins
from workbench.design.judge.modes import natural_poles
from workbench.design.plots import PALETTE, label

_GAINS = np.geomspace(0.02, 50.0, 400)
_DAMPING = (0.2, 0.4, 0.6, 0.8)


def reach(poles: np.ndarray, crossover: float, highest: float) -> float:
    """Return how far from the origin poles are worth showing [rad/s].

    Sampled poles at negative z alternate at every sample, and lie at the highest frequency.
    """
    swinging = np.abs(poles[(np.abs(poles.imag) > 1e-6) & (np.abs(poles) < 0.9 * highest)])
    least = 4.0 * crossover if math.isfinite(crossover) else 1.0
    return 1.25 * max(least, float(swinging.max(initial=0.0)))


def draw_locus(axes: Axes, model: CutModel, point: str, margins: LoopMargins, shown: float) -> None:
    """Draw where the poles go as the loop's gain goes from nothing to fifty times its value."""
    A, b, c = model.cut(point)
    back = np.outer(b, c)
    poles = np.linalg.eigvals(A + _GAINS[:, None, None] * back)
    colours = np.repeat(np.log10(_GAINS), poles.shape[1])
    found = natural_poles_2d(poles.ravel(), model.period)
    dots = axes.scatter(
        found.real, found.imag, c=colours, s=3.0, cmap="viridis", vmin=-1.7, vmax=1.7, lw=0
    )
    opened = natural_poles(np.linalg.eigvals(A), model.period)
    closed = natural_poles(np.linalg.eigvals(model.A), model.period)
    axes.plot(opened.real, opened.imag, "x", color=PALETTE.command, ms=6)
    axes.plot(closed.real, closed.imag, "s", color=PALETTE.mean, ms=4, mfc="none")
    for factor in (margins.gain_margin, margins.gain_reduction_margin):
        if margins.stable and factor > 0.0 and math.isfinite(factor):
            verge = natural_poles(np.linalg.eigvals(A + factor * back), model.period)
            verge = verge[np.abs(verge.real) < 1e-4 * np.maximum(np.abs(verge), 1.0)]
            verge = verge[np.abs(verge) > 1e-2]
            axes.plot(verge.real, verge.imag, "o", color=PALETTE.limit, ms=5, mfc="none")
            if len(verge):
                top = verge[np.argmax(verge.imag)]
                axes.annotate(
                    f"gain x {factor:.3g}",
                    (top.real, top.imag),
                    xytext=(4, 4),
                    textcoords="offset points",
                    fontsize=7.5,
                    color=PALETTE.limit,
                )
    bar = axes.figure.colorbar(dots, ax=axes, ticks=[-1, 0, 1], shrink=0.8, pad=0.02)
    bar.ax.set_yticklabels(["0.1", "1", "10"])
    bar.set_label("factor on the loop's gain [1]", fontsize=8)
    _frame(axes, shown, "root locus: x opened, squares as it is")


def draw_poles(axes: Axes, poles: np.ndarray, shown: float) -> None:
    """Draw the closed loop's poles over lines of equal damping and natural frequency."""
    for damping in _DAMPING:
        angle = math.acos(damping)
        x, y = -2.0 * shown * math.cos(angle), 2.0 * shown * math.sin(angle)
        axes.plot([0.0, x, np.nan, 0.0, x], [0.0, y, np.nan, 0.0, -y], color="0.75", lw=0.8)
        size = min(0.93 * shown / math.sin(angle), 0.93 * shown / math.cos(angle))
        axes.annotate(
            f"{damping:g}",
            (-size * math.cos(angle), size * math.sin(angle)),
            fontsize=7.5,
            color="0.35",
            ha="center",
            va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
        )
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 100)
    for size in _round_steps(shown):
        axes.plot(size * np.cos(turn), size * np.sin(turn), ":", color="0.7", lw=0.8)
    axes.plot(poles.real, poles.imag, "x", color=PALETTE.ours, ms=6, mew=1.6)
    outside = int((np.maximum(np.abs(poles.real), np.abs(poles.imag)) > shown).sum())
    note = f", {outside} more outside" if outside else ""
    _frame(axes, shown, f"poles of the closed loop{note}")
    axes.grid(visible=False)


def natural_poles_2d(poles: np.ndarray, period: float) -> np.ndarray:
    """Return poles (N) in continuous terms, NaN for those that forget within a sample."""
    if not period:
        return poles
    with np.errstate(divide="ignore"):
        found: np.ndarray = np.log(np.where(np.abs(poles) > 1e-9, poles, np.nan)) / period
    return found


def _round_steps(shown: float) -> np.ndarray:
    """Return a few round numbers up to a size."""
    step = 10.0 ** math.floor(math.log10(shown / 2.0))
    step *= 5.0 if shown / step > 10.0 else 2.0 if shown / step > 4.0 else 1.0
    return np.arange(step, 1.5 * shown, step)


def _frame(axes: Axes, shown: float, title: str) -> None:
    axes.axvline(0.0, color=PALETTE.limit, lw=0.8)
    axes.set_xlim(-shown, 0.35 * shown)
    axes.set_ylim(-shown, shown)
    label(axes, title, "imaginary part [rad/s]")
    axes.set_xlabel("real part [1/s]")
