"""The picture of a tuning run: responses before and after in every case, and what is to spare."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.design.plots import PALETTE, label, styled, widen
from workbench.design.tune.case import NOMINAL
from workbench.design.tune.measure import Responses
from workbench.design.tune.tuning import Result, Tuning
from workbench.scenario.axes import find_axis

BEFORE, AFTER = 0, 1
_CORNERS = 0.3
"""Opacity of what flies beside the vehicle as described."""
_WIDEST = 1.5
"""Of a bar: more to spare, or more missing, than this is drawn as this."""


@styled
def plot_tuning(found: Tuning) -> Figure:
    """Return the figure of a run."""
    axes = list(dict.fromkeys(axis for axis, _ in found.responses))
    shown = [*found.as_described, *found.in_corners]
    rows = max(1, len(axes))
    height = max(1.9 * rows, 0.17 * len(shown) + 1.0) + 0.6
    figure = Figure(figsize=(11.0, height), layout="constrained")
    figure.suptitle(_title(found), x=0.01, ha="left", fontsize=11, fontweight="bold")
    left, right = figure.subfigures(1, 2, width_ratios=(1.25, 1.0), squeeze=False)[0]
    if axes:
        panels = left.subplots(len(axes), 1, squeeze=False)[:, 0]
        for panel, axis in zip(panels, axes, strict=True):
            _draw_responses(panel, found, axis)
        panels[-1].set_xlabel("time since the command's edge [s]")
        handles, labels = panels[0].get_legend_handles_labels()
        left.legend(handles, labels, loc="outside lower center", ncols=4)
    _draw_reserves(right.subplots(), shown)
    return figure


def _title(found: Tuning) -> str:
    end = "all wishes met" if found.met else "wishes not met"
    if found.met and found.shortfalls:
        end = f"all wishes met, {len(found.shortfalls)} of them widened"
    return f"{found.vehicle}: tuned, {end}"


def _draw_responses(panel: Axes, found: Tuning, axis: str) -> None:
    """Draw the step of an axis, before and after, in all cases."""
    command = found.steps[axis].amplitude
    curves = {
        case: flown for (flown_axis, case), flown in found.responses.items() if flown_axis == axis
    }
    described = curves.pop(NOMINAL)
    panel.axhline(command, ls="--", color=PALETTE.command, lw=1.2, label="command")
    for index, flown in enumerate(curves.values()):
        name = "after, in corners" if index == 0 else None
        panel.plot(
            flown.time,
            flown.response[AFTER],
            color=PALETTE.ours,
            alpha=_CORNERS,
            lw=1.0,
            label=name,
        )
    panel.plot(
        described.time, described.response[BEFORE], color=PALETTE.mean, ls=":", label="before"
    )
    panel.plot(described.time, described.response[AFTER], color=PALETTE.ours, label="after")
    panel.set_xlim(0.0, _end(described, command))
    widen(panel, np.clip(described.response, -0.3 * abs(command), 1.6 * abs(command)), command, 0.0)
    what = "yaw rate" if axis == "yaw" else f"velocity along {axis}"
    label(panel, f"{what}, step of {command:g} {find_axis(axis).unit}", f"[{find_axis(axis).unit}]")


def _end(flown: Responses, command: float) -> float:
    """Return when the response has been at rest for a while [s]."""
    away = np.abs(flown.response[AFTER] - flown.response[AFTER][-1]) > 0.02 * abs(command)
    settled = flown.time[np.flatnonzero(away)[-1]] if away.any() else flown.time[-1]
    return float(min(flown.time[-1], max(1.0, 1.6 * settled)))


def _draw_reserves(panel: Axes, results: list[Result]) -> None:
    """Draw how much each wish has to spare, before and after."""
    places = np.arange(len(results))[::-1]
    before = [float(r.required.reserves(np.array([r.before]))[0]) for r in results]
    after = [result.reserve for result in results]
    colors = [PALETTE.ours if result.met else PALETTE.limit for result in results]
    panel.barh(places, np.clip(after, -_WIDEST, _WIDEST), color=colors, height=0.7, label="after")
    panel.plot(
        np.clip(before, -_WIDEST, _WIDEST),
        places,
        "|",
        color=PALETTE.mean,
        ms=9,
        mew=2,
        label="before",
    )
    panel.axvline(0.0, color=PALETTE.command, lw=1.0)
    panel.set_yticks(places, [_name(result) for result in results], fontsize=7)
    panel.set_ylim(-0.8, len(results) - 0.2)
    panel.set_xlabel("to spare, as a share of the limit")
    panel.set_title("wishes")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def _name(result: Result) -> str:
    wish = result.required.wish
    corner = "" if result.required.case == NOMINAL else ", worst corner"
    return f"{wish.name}{corner}"
