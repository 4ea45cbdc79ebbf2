"""Draw frequency responses of a loop: magnitude, phase, Nyquist curve and gang of four."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from workbench.design.judge.gang_of_four import GangOfFour
from workbench.design.judge.loop_response import LoopResponses, decibels
from workbench.design.judge.margins import LoopMargins, frequency_grid
from workbench.design.plots import PALETTE, label_panel, note

_DISK_REACH = 60.0
"""Limit of the drawn size of a disk; a larger one has a straight edge."""
_TEXT_BACKGROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
"""Background of text that curves may cross."""


def shown_frequencies(loops: LoopResponses, margins: LoopMargins) -> np.ndarray:
    """Return the frequencies (F) to show [rad/s]: around the crossover, up to the highest."""
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
        axes.semilogx(frequency, decibels(curve), dashes, color=colour, label=name)
    axes.axhline(0.0, color=PALETTE.command, lw=0.8)
    left = float(np.fmin(margins.crossover, margins.bandwidth))
    _mark_frequency(axes, margins.crossover, PALETTE.ours, "crossover", (left, 0.02))
    _mark_frequency(axes, margins.bandwidth, PALETTE.series[2], "bandwidth", (left, 0.08))
    axes.set_ylim(-45.0, 45.0)
    label_panel(axes, "Bode: magnitude", "magnitude [dB]", "frequency [rad/s]")
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
        below, offset = ("top", -4.0) if at > -180.0 else ("bottom", 4.0)
        look = {"ha": "center", "va": below, "color": PALETTE.mean, "bbox": _TEXT_BACKGROUND}
        place = (margins.crossover, -180.0)
        note(axes, f"{at + 180.0:.0f} deg", place, (0.0, offset), size=8.0, **look)
    low, high = min(float(phase.min()), -200.0), max(float(phase.max()), -80.0)
    axes.set_ylim(max(low, -450.0) - 10.0, high + 10.0)
    axes.yaxis.set_major_locator(MultipleLocator(45.0))
    label_panel(
        axes, "Bode: phase, with its margin at the crossover", "phase [deg]", "frequency [rad/s]"
    )


def draw_nyquist(
    axes: Axes, response: np.ndarray, margins: LoopMargins, *, legend: bool = True
) -> None:
    """Draw L in the complex plane, with the disk of the disk margin."""
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
    label_panel(axes, "Nyquist", "imaginary part [1]", "real part [1]")
    if legend:
        axes.legend(loc="lower left", fontsize=7.5, frameon=True, framealpha=0.85, edgecolor="none")


def draw_gang(control: Axes, load: Axes, gang: GangOfFour) -> None:
    """Draw |KS| and |GS|, each with its peak; S and T are drawn with the magnitude of L."""
    for axes, name, response, unit in (
        (control, "KS: control sensitivity", gang.control_sensitivity, gang.control_per_error),
        (load, "GS: load sensitivity", gang.load_sensitivity, gang.error_per_control),
    ):
        size = np.abs(response)
        axes.loglog(gang.frequency, size, color=PALETTE.ours)
        top = int(np.argmax(size))
        axes.plot(gang.frequency[top], size[top], "o", color=PALETTE.mean, ms=4)
        text = f"{size[top]:.3g} at {gang.frequency[top]:.3g} rad/s"
        note(
            axes,
            text,
            (0.03, 0.04),
            within="axes fraction",
            color=PALETTE.mean,
            bbox=_TEXT_BACKGROUND,
        )
        label_panel(axes, name, f"size [{unit}]", "frequency [rad/s]")


def _mark_frequency(
    axes: Axes, frequency: float, colour: str, name: str, place: tuple[float, float]
) -> None:
    """Mark a frequency, if there is one, with its name at the left.

    There is always space left of crossover and bandwidth; their colours differ.
    """
    if math.isfinite(frequency):
        axes.axvline(frequency, color=colour, lw=0.9, ls=":")
        within = ("data", "axes fraction")
        look: dict[str, Any] = {"ha": "right", "color": colour, "bbox": _TEXT_BACKGROUND}
        note(axes, f"{name} {frequency:.3g}", place, (-4.0, 0.0), within=within, **look)
