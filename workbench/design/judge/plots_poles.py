"""Draw poles of a loop and their root locus."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from workbench.common.plain_text import plain_name
from workbench.design.judge.margins import LoopMargins
from workbench.design.judge.modes import MIN_POLE_RADIUS, Mode, natural_poles
from workbench.design.linear.model import LinearModel
from workbench.design.plots import PALETTE, label_panel, note

_LOCUS_GAINS = np.geomspace(0.02, 50.0, 400)
_DAMPING_LINES = (0.2, 0.4, 0.6, 0.8)


def pole_plot_radius(poles: np.ndarray, crossover: float, highest: float) -> float:
    """Return the distance from the origin up to which to show poles [rad/s].

    Sampled poles at negative z alternate at every sample, and are at the highest frequency.
    """
    swinging = np.abs(poles[(np.abs(poles.imag) > 1e-6) & (np.abs(poles) < 0.9 * highest)])
    least = 4.0 * crossover if math.isfinite(crossover) else 1.0
    return 1.25 * max(least, float(swinging.max(initial=0.0)))


def draw_locus(
    axes: Axes, model: LinearModel, point: str, margins: LoopMargins, shown: float
) -> None:
    """Draw the root locus for loop gains from zero to fifty times the present one.

    Poles of a sampled loop are drawn in continuous time, s = ln(z) / period.
    """
    A, b, c = model.cut(point)
    back = np.outer(b, c)
    poles = np.linalg.eigvals(A + _LOCUS_GAINS[:, None, None] * back)
    lasting = np.abs(poles.ravel()) > MIN_POLE_RADIUS
    colours = np.repeat(np.log10(_LOCUS_GAINS), poles.shape[1])[lasting]
    found = natural_poles(poles.ravel()[lasting], model.period)
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
                place = (top.real, top.imag)
                note(axes, f"gain x {factor:.3g}", place, (4.0, 4.0), color=PALETTE.limit)
    bar = axes.figure.colorbar(dots, ax=axes, ticks=[-1, 0, 1], shrink=0.8, pad=0.02)
    bar.ax.set_yticklabels(["0.1", "1", "10"])
    bar.set_label("factor on the loop's gain [1]", fontsize=8)
    _frame_pole_axes(axes, shown, "root locus: x opened, squares as it is")


def draw_poles(axes: Axes, poles: np.ndarray, shown: float, named: Sequence[Mode] = ()) -> None:
    """Draw the poles of the closed loop over lines of equal damping and natural frequency.

    Args:
        axes: to draw in.
        poles: in continuous time [1/s].
        shown: distance from the origin up to which to draw [rad/s].
        named: modes, of which those of joints get their names.
    """
    for damping in _DAMPING_LINES:
        angle = math.acos(damping)
        x, y = -2.0 * shown * math.cos(angle), 2.0 * shown * math.sin(angle)
        axes.plot([0.0, x, np.nan, 0.0, x], [0.0, y, np.nan, 0.0, -y], color="0.75", lw=0.8)
        size = min(0.93 * shown / math.sin(angle), 0.93 * shown / math.cos(angle))
        place = (-size * math.cos(angle), size * math.sin(angle))
        plate = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        note(axes, f"{damping:g}", place, color="0.35", ha="center", va="center", bbox=plate)
    turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 100)
    for size in _round_steps(shown):
        axes.plot(size * np.cos(turn), size * np.sin(turn), ":", color="0.7", lw=0.8)
    axes.plot(poles.real, poles.imag, "x", color=PALETTE.ours, ms=6, mew=1.6)
    for mode in named:
        if mode.joint and mode.frequency < shown:
            note(axes, plain_name(mode.joint), (mode.real, mode.imaginary), (5.0, 3.0))
    outside = int((np.maximum(np.abs(poles.real), np.abs(poles.imag)) > shown).sum())
    more = f", {outside} more outside" if outside else ""
    _frame_pole_axes(axes, shown, f"poles of the closed loop{more}")
    axes.grid(visible=False)


def _round_steps(shown: float) -> np.ndarray:
    """Return a few round numbers up to a limit."""
    step = 10.0 ** math.floor(math.log10(shown / 2.0))
    step *= 5.0 if shown / step > 10.0 else 2.0 if shown / step > 4.0 else 1.0
    return np.arange(step, 1.5 * shown, step)


def _frame_pole_axes(axes: Axes, shown: float, title: str) -> None:
    axes.axvline(0.0, color=PALETTE.limit, lw=0.8)
    axes.set_xlim(-shown, 0.35 * shown)
    axes.set_ylim(-shown, shown)
    label_panel(axes, title, "imaginary part [rad/s]", "real part [1/s]")
