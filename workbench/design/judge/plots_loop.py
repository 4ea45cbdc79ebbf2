"""All of one loop in one picture, and all loops in another."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.control.controller import Loop
from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import LoopMargins, loop_margins
from workbench.design.judge.modes import natural_poles
from workbench.design.judge.panels_frequency import (
    draw_magnitude,
    draw_nyquist,
    draw_phase,
    shown_frequencies,
)
from workbench.design.judge.panels_poles import draw_locus, draw_poles, reach
from workbench.design.judge.step_pair import INPUTS, OUTPUTS, STEPS, StepPair, linear_step
from workbench.design.linear.model import LinearModel
from workbench.design.plots import PALETTE, label, styled, widen
from workbench.scenario.axes import find_axis

SAMPLES = 640
"""Of a linear step where nothing was flown."""


@styled
def plot_loop(
    model: LinearModel, loop: Loop, steps: tuple[StepPair, ...] = (), *, cut: str = "actuator"
) -> Figure:
    """Return Bode, Nyquist, root locus, poles and step of one loop.

    Args:
        model: the closed loop; one that holds its place for a loop that does.
        loop: which.
        steps: linear and flown ones, if there are any.
        cut: where to open the loop, actuator or error.
    """
    point = loop.point(cut)
    loops, margins = loop_responses(model, [point]), loop_margins(model, point)
    frequency = shown_frequencies(loops, margins)
    response = loops.at(frequency)[0]
    figure = Figure(figsize=(13.0, 7.6), layout="constrained")
    magnitude, nyquist, locus, phase, step, poles = figure.subplots(2, 3).ravel()
    where = f"cut at {point}" if loop.error != loop.actuator else f"cut at its error, {point}"
    figure.suptitle(
        f"{loop.name} loop at {model.trim.point.label}, {where}\n{_in_words(margins)}",
        x=0.01,
        ha="left",
        fontsize=11,
        fontweight="bold",
    )
    draw_magnitude(magnitude, frequency, response, margins)
    draw_phase(phase, frequency, response, margins)
    draw_nyquist(nyquist, response, margins)
    closed = natural_poles(np.linalg.eigvals(model.A), model.period)
    shown = reach(closed, margins.crossover, loops.highest)
    draw_locus(locus, model, point, margins, shown)
    draw_poles(poles, closed, shown)
    shows = [pair for pair in steps if pair.axis == loop.axis and not loop.hold]
    if shows:
        draw_step_pair(step, shows[0])
    else:
        draw_linear_step(step, model, loop)
    return figure


@styled
def plot_loops(
    steering: LinearModel, holding: LinearModel | None = None, *, cut: str = "actuator"
) -> Figure:
    """Return the Nyquist curves of all loops, each with its margins.

    Args:
        steering: the closed loop while a pilot steers.
        holding: while a place is held; without it, the loops that hold a place are left out.
        cut: where to open the loops, actuator or error.
    """
    shown = [loop for loop in steering.loops if not loop.hold or holding is not None]
    rows = -(-len(shown) // 3)
    figure = Figure(figsize=(12.0, 3.9 * rows + 0.6), layout="constrained")
    figure.suptitle(
        f"all loops at {steering.trim.point.label}, cut at the {cut}",
        x=0.01,
        ha="left",
        fontsize=11,
        fontweight="bold",
    )
    panels = figure.subplots(rows, 3, squeeze=False).ravel()
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    for axes, loop in zip(panels, shown, strict=False):
        model = holding if loop.hold and holding is not None else steering
        point = loop.point(cut)
        loops, margins = loop_responses(model, [point]), loop_margins(model, point)
        response = loops.at(shown_frequencies(loops, margins))[0]
        draw_nyquist(axes, response, margins, legend=loop is shown[0])
        axes.set_title(f"{loop.name}\n{_in_few_words(margins)}", fontsize=9)
    return figure


def draw_step_pair(axes: Axes, pair: StepPair) -> None:
    """Draw a step as the linear model has it, beside the flown one."""
    unit = find_axis(pair.axis).unit
    end = pair.time <= _settled(pair)
    time = pair.time[end]
    axes.axhline(pair.amplitude, color=PALETTE.command, ls="--", lw=1.0, label="command")
    if pair.flown is not None:
        axes.plot(time, pair.flown_response[end], color=PALETTE.ours, label="flown")
    linear = pair.linear_response[end]
    axes.plot(time, linear, "-.", color=PALETTE.mean, label="linear")
    widen(axes, np.clip(linear, -4.0 * abs(pair.amplitude), 4.0 * abs(pair.amplitude)))
    what = "yaw rate" if pair.axis == "yaw" else f"velocity along {pair.axis}"
    label(axes, f"step of {pair.amplitude:g} {unit}", f"{what} [{unit}]")
    axes.set_xlabel("time since the command's edge [s]")
    axes.legend(loc="lower right")


def draw_linear_step(axes: Axes, model: LinearModel, loop: Loop) -> None:
    """Draw the linear model's answer to a step, of what was not flown."""
    axis = "" if loop.hold else loop.axis
    if axis:
        amplitude, unit = dict(STEPS)[axis], find_axis(axis).unit
        response = linear_step(model, INPUTS[axis], OUTPUTS[axis], SAMPLES) * amplitude
        what = "yaw rate" if axis == "yaw" else f"velocity along {axis}"
    else:
        amplitude, unit, axis = 1.0, "m", loop.name[-1]
        response = linear_step(model, f"reference_p_{axis}", f"p_{axis}", SAMPLES)
        what = f"position along {axis}"
    axes.axhline(amplitude, color=PALETTE.command, ls="--", lw=1.0, label="command")
    time = model.period * np.arange(SAMPLES)
    axes.plot(time, response, "-.", color=PALETTE.mean, label="linear")
    widen(axes, np.clip(response, -4.0 * amplitude, 4.0 * amplitude))
    label(axes, f"step of {amplitude:g} {unit}, linear", f"{what} [{unit}]")
    axes.set_xlabel("time since the command's edge [s]")
    axes.legend(loc="lower right")


def _settled(pair: StepPair) -> float:
    """Return until when a step is worth showing [s]."""
    times = [m.settling_time for m in (pair.linear, pair.flown) if m is not None]
    settled = max((t for t in times if math.isfinite(t)), default=float(pair.time[-1]))
    return max(1.5, 2.0 * settled)


def _in_words(margins: LoopMargins) -> str:
    """Return all margins in one line."""
    if not margins.stable:
        return "unstable: the closed loop has a growing mode"
    down = margins.gain_reduction_margin
    parts = [
        f"gain margin {margins.gain_margin:.3g}" + (f" (down to {down:.3g})" if down else ""),
        f"phase margin {math.degrees(margins.phase_margin):.1f} deg",
        f"delay margin {1e3 * margins.delay_margin:.1f} ms",
        f"disk margin {margins.disk_margin:.2f}",
        f"peak sensitivity {margins.peak_sensitivity:.2f}",
        f"bandwidth {margins.bandwidth:.3g} rad/s",
    ]
    return ", ".join(parts)


def _in_few_words(margins: LoopMargins) -> str:
    if not margins.stable:
        return "unstable"
    return (
        f"gain x {margins.gain_margin:.2g}, phase {math.degrees(margins.phase_margin):.0f} deg, "
        f"disk {margins.disk_margin:.2f}"
    )
