"""Figures of a judgement: one loop, all loops, maps, sensitivities, rates, measurements."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.control.loop import Loop
from workbench.design.judge.gang_of_four import gang_of_four
from workbench.design.judge.loop_response import decibels, loop_responses
from workbench.design.judge.margins import (
    LoopMargins,
    loop_margins,
    response_margins,
)
from workbench.design.judge.measured_loop import MIN_COHERENCE
from workbench.design.judge.modes import Mode, natural_poles
from workbench.design.judge.phase_budget import PHASE_BUDGET_PARTS, PhaseBudget
from workbench.design.judge.plots_frequency import (
    draw_gang,
    draw_magnitude,
    draw_nyquist,
    draw_phase,
    shown_frequencies,
)
from workbench.design.judge.plots_poles import draw_locus, draw_poles, pole_plot_radius
from workbench.design.judge.sampled_stability import (
    SAFE_PHASE_MARGIN_RAD,
    SLOW_MODE_RAD_S,
    SlowestRate,
)
from workbench.design.judge.step_pair import PAPER_STEPS, StepPair
from workbench.design.linear.model import LinearModel
from workbench.design.linear_step import STEP_INPUTS, STEP_OUTPUTS, linear_step
from workbench.design.plots import (
    PALETTE,
    label_panel,
    legend,
    stacked,
    styled,
    titled,
    widen,
)
from workbench.scenario.axes import find_axis

if TYPE_CHECKING:  # these load Drake
    from workbench.design.judge.loop_measurement import Measurement

LINEAR_STEP_SAMPLES = 640
"""Number of samples of a linear step without a flight."""
ERROR_BAR_SIGMAS = 2.0
"""Half height of the error bars, in standard deviations."""


@styled
def plot_loop(
    model: LinearModel,
    loop: Loop,
    steps: tuple[StepPair, ...] = (),
    *,
    cut: str = "actuator",
    named: Sequence[Mode] = (),
) -> Figure:
    """Return the figure of one loop: Bode, Nyquist, gang of four, root locus, poles and step.

    Args:
        model: the closed loop; one that holds its position for a loop that holds a position.
        loop: its name.
        steps: linear and flown ones, if any.
        cut: where to open the loop, actuator or error.
        named: modes of the model, of which those of joints are named.
    """
    point = loop.point(cut)
    loops, margins = loop_responses(model, [point]), loop_margins(model, point)
    frequency = shown_frequencies(loops, margins)
    response = loops.at(frequency)[0]
    where = f"cut at {point}" if loop.error != loop.actuator else f"cut at its error, {point}"
    figure = titled(
        f"{loop.name} loop at {model.trim.point.label}, {where}\n{_in_words(margins)}", 16.5, 7.6
    )
    panels = figure.subplots(2, 4).ravel()
    magnitude, nyquist, locus, control, phase, step, poles, load = panels
    draw_magnitude(magnitude, frequency, response, margins)
    draw_phase(phase, frequency, response, margins)
    draw_nyquist(nyquist, response, margins)
    draw_gang(control, load, gang_of_four(model, loop, cut))
    closed = natural_poles(np.linalg.eigvals(model.A), model.period)
    shown = pole_plot_radius(closed, margins.crossover, loops.highest)
    draw_locus(locus, model, point, margins, shown)
    draw_poles(poles, closed, shown, named)
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
    """Return the figure of Nyquist curves of all loops, each with its margins.

    Args:
        steering: the closed loop while a pilot steers.
        holding: the same while a position is held; None leaves out the loops that hold a position.
        cut: where to open the loops, actuator or error.
    """
    shown = [loop for loop in steering.loops if not loop.hold or holding is not None]
    rows = -(-len(shown) // 3)
    width, height = 12.0, 3.9 * rows + 0.6
    figure = Figure(figsize=(width, height))
    title = f"all loops at {steering.trim.point.label}, cut at the {cut}"
    figure.suptitle(title, x=0.01, y=1.0 - 0.1 / height, ha="left", fontsize=11, fontweight="bold")
    # a layout engine measures every text, which takes as long as drawing
    panels = figure.subplots(
        rows,
        3,
        sharex=True,
        sharey=True,
        squeeze=False,
        gridspec_kw={
            "left": 0.6 / width,
            "right": 1.0 - 0.1 / width,
            "bottom": 0.45 / height,
            "top": 1.0 - 0.65 / height,
            "wspace": 0.25,
            "hspace": 0.25,
        },
    ).ravel()
    for axes in panels[len(shown) :]:
        axes.set_visible(False)
    for axes in panels[max(0, len(shown) - 3) : len(shown)]:
        axes.tick_params(labelbottom=True)  # also above a panel that is left out
    for model in filter(None, (steering, holding)):
        held = model is holding
        found = loop_responses(model, [loop.point(cut) for loop in shown if loop.hold is held])
        these = [(a, loop) for a, loop in zip(panels, shown, strict=False) if loop.hold is held]
        for index, margins in enumerate(response_margins(found)):
            axes, loop = these[index]
            response = found.at(shown_frequencies(found, margins))[index]
            draw_nyquist(axes, response, margins, legend=loop is shown[0])
            place = shown.index(loop)
            if place + 3 < len(shown):
                axes.set_xlabel("")
            if place % 3:
                axes.set_ylabel("")
            axes.set_title(f"{loop.name}\n{_in_few_words(margins)}", fontsize=9)
    return figure


def plot_phase(budgets: Sequence[PhaseBudget], title: str) -> Figure:
    """Return the figure of phase budgets, as bars from 0 to -180 degrees.

    Args:
        budgets: of the loops.
        title: of the figure.
    """
    names = [f"{each.loop}\n{each.crossover:.3g} rad/s" for each in budgets]
    longest = max((len(line) for name in names for line in name.split("\n")), default=0)
    width, height = 10.0, 0.55 * len(budgets) + 1.6
    figure = Figure(figsize=(width, height))
    axes = figure.subplots(
        gridspec_kw={
            "left": (0.2 + 0.075 * longest) / width,
            "right": 1.0 - 0.12 / width,
            "bottom": 0.8 / height,
            "top": 1.0 - 0.3 / height,
        }
    )
    ends, starts = np.zeros(len(budgets)), np.zeros(len(budgets))
    for number, part in enumerate(PHASE_BUDGET_PARTS):
        turned = np.degrees([getattr(each, part) for each in budgets])
        if np.abs(turned).max(initial=0.0) < 1e-6:
            continue
        # phase lead goes to the other side of 0, so that bars never overlap
        begin = np.where(turned < 0.0, ends, starts)
        axes.barh(names, turned, left=begin, color=f"C{number}", label=part)
        ends, starts = ends + np.minimum(turned, 0.0), starts + np.maximum(turned, 0.0)
    axes.axvline(-180.0, color="0.3", ls="--", lw=1.0)
    axes.invert_yaxis()
    axes.set_xlabel("phase at the crossover [deg]; what is left to the dashed line is the margin")
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
    if axes.containers:  # an unstable loop has no phase budget
        figure.legend(loc="lower center", ncols=len(PHASE_BUDGET_PARTS), fontsize=8, frameon=False)
    return figure


def draw_step_pair(axes: Axes, pair: StepPair) -> None:
    """Draw the linear and the flown response to a step."""
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
    label_panel(
        axes,
        f"step of {pair.amplitude:g} {unit}",
        f"{what} [{unit}]",
        "time since the command's edge [s]",
    )
    axes.legend(loc="lower right")


def draw_linear_step(axes: Axes, model: LinearModel, loop: Loop) -> None:
    """Draw the response of the linear model to a step that was not flown."""
    axis = "" if loop.hold else loop.axis
    if axis:
        amplitude, unit = dict(PAPER_STEPS)[axis], find_axis(axis).unit
        response = (
            linear_step(model, STEP_INPUTS[axis], STEP_OUTPUTS[axis], LINEAR_STEP_SAMPLES)
            * amplitude
        )
        what = "yaw rate" if axis == "yaw" else f"velocity along {axis}"
    else:
        amplitude, unit, axis = 1.0, "m", loop.name[-1]
        response = linear_step(model, f"reference_p_{axis}", f"p_{axis}", LINEAR_STEP_SAMPLES)
        what = f"position along {axis}"
    axes.axhline(amplitude, color=PALETTE.command, ls="--", lw=1.0, label="command")
    time = model.period * np.arange(LINEAR_STEP_SAMPLES)
    axes.plot(time, response, "-.", color=PALETTE.mean, label="linear")
    widen(axes, np.clip(response, -4.0 * amplitude, 4.0 * amplitude))
    label_panel(
        axes,
        f"step of {amplitude:g} {unit}, linear",
        f"{what} [{unit}]",
        "time since the command's edge [s]",
    )
    axes.legend(loc="lower right")


def _settled(pair: StepPair) -> float:
    """Return the time up to which to show a step [s]."""
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


@styled
def plot_rates(found: SlowestRate, title: str) -> Figure:
    """Return the figure of largest growth rate and smallest phase margin over control period."""
    figure, (growth, phase) = stacked(title, 2, height=2.4, right=0.2)
    time = [1e3 * sample.period for sample in found.samples]
    growth.plot(time, [sample.growth for sample in found.samples], ".-", color=PALETTE.ours)
    growth.axhline(0.0, color=PALETTE.limit, lw=1.0)
    growth.ticklabel_format(axis="y", useOffset=False)
    label_panel(
        growth,
        f"the mode that dies out slowest, of those above {SLOW_MODE_RAD_S:g} rad/s; stable below 0",
        "growth rate [1/s]",
    )
    degrees = [math.degrees(sample.phase_margin) for sample in found.samples]
    phase.plot(time, degrees, ".-", color=PALETTE.ours)
    phase.axhline(math.degrees(SAFE_PHASE_MARGIN_RAD), color=PALETTE.mean, ls="--", lw=1.0)
    label_panel(
        phase,
        "smallest phase margin; safe above the dashed line",
        "phase [deg]",
        "control period [ms]",
    )
    return figure


@styled
def plot_measurement(found: "Measurement") -> Figure:
    """Return the figure of a measurement; frequencies of low coherence are pale."""
    measured, model = found.measured, found.model
    frequency, good = measured.frequency, measured.coherence >= MIN_COHERENCE
    figure, panels = stacked(f"{found.vehicle}: {found.loop}, as modelled and as measured", 3)
    sizes, phases, coherence = panels
    spread = np.minimum(ERROR_BAR_SIGMAS * measured.deviation, 0.9)
    modelled = np.unwrap(np.angle(model))
    turned = modelled + np.angle(measured.response / model)
    for axes, curve, points, bars in (
        (
            sizes,
            decibels(model),
            decibels(measured.response),
            np.array([-decibels(1.0 - spread), decibels(1.0 + spread)]),
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
    low, high = decibels(model).min(), decibels(model).max()
    sizes.set_ylim(low - 8.0, high + 8.0)
    shown = np.degrees(modelled)
    phases.set_ylim(shown.min() - 40.0, shown.max() + 40.0)
    label_panel(sizes, "open loop: magnitude", "|L| [dB]")
    label_panel(phases, "open loop: phase", "phase [°]")
    legend(sizes)
    coherence.semilogx(frequency, measured.coherence, "o-", ms=3.0, color=PALETTE.ours)
    coherence.axhline(MIN_COHERENCE, color=PALETTE.limit, lw=1.0)
    coherence.set_ylim(-0.03, 1.05)
    label_panel(coherence, "coherence, the lower end of its interval", "coherence [1]")
    for axes in panels:
        if math.isfinite(found.margins.bandwidth):
            axes.axvline(found.margins.bandwidth, color=PALETTE.command, lw=0.8)
    coherence.set_xlabel("frequency [rad/s], the line is the bandwidth")
    return figure
