"""The figure that compares controllers."""

from matplotlib.figure import Figure

from workbench.design.comparison import COMPARISON_PANELS, ControllerComparison
from workbench.design.plots import curve_name, label_panel, series_look, styled, widen

_TITLES = {
    "x": ("step along x", "share of the command [1]"),
    "y": ("step along y", "share of the command [1]"),
    "z": ("step along z", "share of the command [1]"),
    "yaw": ("step of the yaw rate", "share of the command [1]"),
    "path": ("figure of eight, from above", "y [m]"),
    "push": ("after a push", "distance [m]"),
    "upside_down": ("from upside down", "height gained [m]"),
    "wind": ("in wind of 8 m/s", "distance [m]"),
}


@styled
def plot_comparison(found: ControllerComparison) -> Figure:
    """Return the figure: a panel for each flight, a line for each controller."""
    flown = [
        name for name in COMPARISON_PANELS if any(name in each.curves for each in found.controllers)
    ]
    columns = min(4, max(1, len(flown)))
    rows = max(1, -(-len(flown) // columns))
    figure = Figure(figsize=(3.4 * columns, 2.7 * rows + 0.6), layout="constrained")
    names = ", ".join(each.name for each in found.controllers)
    figure.suptitle(f"{found.vehicle}: {names}", x=0.01, ha="left", fontweight="bold")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[len(flown) :]:
        axes.set_axis_off()
    for axes, panel in zip(panels, flown, strict=False):
        label_panel(axes, *_TITLES[panel], "x [m]" if panel == "path" else "time [s]")
        for number, each in enumerate(found.controllers):
            if panel in each.curves:
                across, along = each.curves[panel]
                axes.plot(across, along, label=curve_name(each.name), **series_look(number))
        if panel == "path":
            axes.set_aspect("equal", adjustable="datalim")
        elif panel in COMPARISON_PANELS[:4]:
            axes.set_ylim(-0.3, 1.7)
        else:
            widen(
                axes, *(each.curves[panel][1] for each in found.controllers if panel in each.curves)
            )
    handles = {line.get_label(): line for axes in panels[: len(flown)] for line in axes.get_lines()}
    if handles:
        figure.legend(handles.values(), handles.keys(), loc="outside lower left", ncols=8)
    return figure
