"""Pictures of the operating map, of the sensitivities, and of the slowest rate."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from workbench.design.judge.operating_map import OperatingMap
from workbench.design.judge.sampled_stability import SAFE_PHASE, SLOW, SlowestRate
from workbench.design.judge.sensitivity import Sensitivity
from workbench.design.plots import PALETTE, label, stacked, styled

_STRONGEST = 1.5
"""Elasticities from here on have the darkest colour [% per %]."""
_FAINT = 0.005
"""Gains that change no metric by this share are left out of the picture [% per %]."""


@styled
def plot_map(found: OperatingMap) -> Figure:
    """Return contours of smallest phase margin, smallest disk margin and least damping."""
    figure = Figure(figsize=(14.0, 4.4), layout="constrained")
    figure.suptitle(
        f"{found.vehicle}: the weakest loop over {found.first.name} and {found.second.name}",
        x=0.01,
        ha="left",
        fontsize=11,
        fontweight="bold",
    )
    panels = (
        ("smallest phase margin", "deg", np.degrees(found.phase_margin), 2.0),
        ("smallest disk margin", "1", found.disk_margin, 0.05),
        ("least damping ratio", "1", found.damping, 0.05),
    )
    for axes, (name, unit, values, least) in zip(figure.subplots(1, 3), panels, strict=True):
        _draw_contours(axes, found, values, unit, least)
        label(axes, name, _named(found.second.name, found.second.unit))
        axes.set_xlabel(_named(found.first.name, found.first.unit))
    return figure


@styled
def plot_sensitivity(found: tuple[Sensitivity, ...], title: str) -> Figure:
    """Return a table in colours: percent of each metric per percent of each gain."""
    rows = [each for each in found if np.isfinite(list(each.elasticities.values())).all()]
    names = [
        name
        for name in found[0].elasticities
        if any(abs(each.elasticities[name]) > _FAINT for each in rows)
    ]
    values = np.array([[each.elasticities[name] for name in names] for each in rows])
    values = values.reshape(len(rows), len(names))
    figure = Figure(figsize=(3.6 + 0.85 * len(names), 1.8 + 0.42 * len(rows)), layout="constrained")
    axes = figure.subplots()
    axes.imshow(values, cmap="RdBu_r", vmin=-_STRONGEST, vmax=_STRONGEST, aspect="auto")
    for row, column in np.ndindex(values.shape):
        value = values[row, column]
        axes.text(
            column,
            row,
            "0"
            if abs(value) < _FAINT
            else f"{value:+.2f}"
            if abs(value) < 99.0
            else f"{value:+.0f}",
            ha="center",
            va="center",
            fontsize=8,
            color="white" if abs(value) > 0.8 * _STRONGEST else "black",
        )
    axes.set_xticks(range(len(names)), names, rotation=35, ha="right")
    axes.set_yticks(range(len(rows)), [each.metric for each in rows])
    axes.grid(visible=False)
    axes.set_title(f"{title}\nchange of a metric per change of a gain [% per %]")
    return figure


@styled
def plot_rates(found: SlowestRate, title: str) -> Figure:
    """Return the fastest growth and the smallest phase margin over the control period."""
    figure, (growth, phase) = stacked(title, 2, height=2.4, right=0.2)
    time = [1e3 * sample.period for sample in found.samples]
    growth.plot(time, [sample.growth for sample in found.samples], ".-", color=PALETTE.ours)
    growth.axhline(0.0, color=PALETTE.limit, lw=1.0)
    growth.ticklabel_format(axis="y", useOffset=False)
    label(
        growth,
        f"the mode that dies out slowest, of those above {SLOW:g} rad/s; stable below 0",
        "growth rate [1/s]",
    )
    degrees = [math.degrees(sample.phase_margin) for sample in found.samples]
    phase.plot(time, degrees, ".-", color=PALETTE.ours)
    phase.axhline(math.degrees(SAFE_PHASE), color=PALETTE.mean, ls="--", lw=1.0)
    label(phase, "smallest phase margin; safe above the dashed line", "phase [deg]")
    phase.set_xlabel("control period [ms]")
    return figure


def _draw_contours(
    axes: Axes, found: OperatingMap, values: np.ndarray, unit: str, least: float
) -> None:
    """Draw filled contours with a scale beside them, which spans `least` or more.

    Points that cannot be flown stay white.
    """
    axes.grid(visible=False)
    known = values[np.isfinite(values)]
    if not len(known):
        axes.text(0.5, 0.5, "no such flight", transform=axes.transAxes, ha="center")
        return
    middle = 0.5 * float(known.min() + known.max())
    half = 0.5 * max(float(np.ptp(known)), least)
    levels = MaxNLocator(10).tick_values(middle - half, middle + half)
    place = found.first_values, found.second_values
    if min(values.shape) < 2:
        norm = Normalize(levels[0], levels[-1])
        filled: Any = axes.pcolormesh(*place, values, shading="nearest", cmap="viridis", norm=norm)
    else:
        filled = axes.contourf(*place, values, levels, cmap="viridis")
        lines = axes.contour(*place, values, levels, colors="white", linewidths=0.7)
        axes.clabel(lines, fmt="%.3g", fontsize=7.5)
    axes.figure.colorbar(filled, ax=axes, label=f"[{unit}]")


def _named(name: str, unit: str) -> str:
    return f"{name.replace('_', ' ')} [{unit}]"
