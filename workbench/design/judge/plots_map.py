"""Plot numbers of a loop over the operating map, and their sensitivity to gains."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from workbench.design.plots import label_panel, styled, titled

if TYPE_CHECKING:
    from workbench.design.judge.operating_map import OperatingMap
    from workbench.design.judge.sensitivity import Sensitivity


_FULL_COLOUR_ELASTICITY = 1.5
"""Elasticity from which on the colour is darkest [% per %]."""
_MIN_SHOWN_ELASTICITY = 0.005
"""Gains with smaller elasticities for all metrics are left out of the figure [% per %]."""


@styled
def plot_map(found: "OperatingMap") -> Figure:
    """Return the figure of contours of smallest phase margin, disk margin and damping."""
    figure = titled(
        f"{found.vehicle}: the weakest loop over {found.first.name} and {found.second.name}",
        14.0,
        4.4,
    )
    panels = (
        ("smallest phase margin", "deg", np.degrees(found.phase_margin), 2.0),
        ("smallest disk margin", "1", found.disk_margin, 0.05),
        ("least damping ratio", "1", found.damping, 0.05),
    )
    for axes, (name, unit, values, least) in zip(figure.subplots(1, 3), panels, strict=True):
        _draw_contours(axes, found, values, unit, least)
        label_panel(
            axes,
            name,
            _metric_title(found.second.name, found.second.unit),
            _metric_title(found.first.name, found.first.unit),
        )
    return figure


@styled
def plot_sensitivity(found: "tuple[Sensitivity, ...]", title: str) -> Figure:
    """Return the figure of sensitivities: a table of percent of metric per percent of gain."""
    rows = [each for each in found if np.isfinite(list(each.elasticities.values())).all()]
    names = [
        name
        for name in found[0].elasticities
        if any(abs(each.elasticities[name]) > _MIN_SHOWN_ELASTICITY for each in rows)
    ]
    values = np.array([[each.elasticities[name] for name in names] for each in rows])
    values = values.reshape(len(rows), len(names))
    figure = Figure(figsize=(3.6 + 0.85 * len(names), 1.8 + 0.42 * len(rows)), layout="constrained")
    axes = figure.subplots()
    axes.imshow(
        values,
        cmap="RdBu_r",
        vmin=-_FULL_COLOUR_ELASTICITY,
        vmax=_FULL_COLOUR_ELASTICITY,
        aspect="auto",
    )
    for row, column in np.ndindex(values.shape):
        value = values[row, column]
        axes.text(
            column,
            row,
            "0"
            if abs(value) < _MIN_SHOWN_ELASTICITY
            else f"{value:+.2f}"
            if abs(value) < 99.0
            else f"{value:+.0f}",
            ha="center",
            va="center",
            fontsize=8,
            color="white" if abs(value) > 0.8 * _FULL_COLOUR_ELASTICITY else "black",
        )
    axes.set_xticks(range(len(names)), names, rotation=35, ha="right")
    axes.set_yticks(range(len(rows)), [each.metric for each in rows])
    axes.grid(visible=False)
    axes.set_title(f"{title}\nchange of a metric per change of a gain [% per %]")
    return figure


def _draw_contours(
    axes: Axes, found: "OperatingMap", values: np.ndarray, unit: str, least: float
) -> None:
    """Draw filled contours with a colour scale, which spans at least `least`.

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


def _metric_title(name: str, unit: str) -> str:
    return f"{name.replace('_', ' ')} [{unit}]"
