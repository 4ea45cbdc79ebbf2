"""Figures of a judgement: one loop, all loops, maps, sensitivities, rates, measurements."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from workbench.control.controller import Loop
from workbench.design.judge.gang_of_four import GangOfFour, gang_of_four
from workbench.design.judge.loop_response import LoopResponses, loop_responses
from workbench.design.judge.margins import (
    LoopMargins,
    frequency_grid,
    loop_margins,
    response_margins,
)
from workbench.design.judge.measured_loop import COHERENT
from workbench.design.judge.modes import GONE, natural_poles
from workbench.design.judge.phase_budget import PARTS, PhaseBudget
from workbench.design.judge.sampled_stability import SAFE_PHASE, SLOW, SlowestRate
from workbench.design.judge.step_pair import STEPS, StepPair
from workbench.design.linear.model import LinearModel
from workbench.design.linear_step import INPUTS, OUTPUTS, linear_step
from workbench.design.plots import PALETTE, label, legend, note, stacked, styled, titled, widen
from workbench.scenario.axes import find_axis

if TYPE_CHECKING:  # these load Drake
    from workbench.design.judge.loop_measurement import Measurement
    from workbench.design.judge.operating_map import OperatingMap
    from workbench.design.judge.sensitivity import Sensitivity

_DISK_REACH = 60.0
"""Limit of the drawn size of a disk; a larger one has a straight edge."""
_PLATE = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
"""Background of text that curves may cross."""
_GAINS = np.geomspace(0.02, 50.0, 400)
_DAMPING = (0.2, 0.4, 0.6, 0.8)
SAMPLES = 640
"""Number of samples of a linear step without a flight."""
_STRONGEST = 1.5
"""Elasticity from which on the colour is darkest [% per %]."""
_FAINT = 0.005
"""Gains with smaller elasticities for all metrics are left out of the figure [% per %]."""
SIGMAS = 2.0
"""Half height of the error bars, in standard deviations."""


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
        axes.semilogx(frequency, _decibel(curve), dashes, color=colour, label=name)
    axes.axhline(0.0, color=PALETTE.command, lw=0.8)
    left = float(np.fmin(margins.crossover, margins.bandwidth))
    _mark_frequency(axes, margins.crossover, PALETTE.ours, "crossover", (left, 0.02))
    _mark_frequency(axes, margins.bandwidth, PALETTE.series[2], "bandwidth", (left, 0.08))
    axes.set_ylim(-45.0, 45.0)
    label(axes, "Bode: magnitude", "magnitude [dB]", "frequency [rad/s]")
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
        look = {"ha": "center", "va": below, "color": PALETTE.mean, "bbox": _PLATE}
        place = (margins.crossover, -180.0)
        note(axes, f"{at + 180.0:.0f} deg", place, (0.0, offset), size=8.0, **look)
    low, high = min(float(phase.min()), -200.0), max(float(phase.max()), -80.0)
    axes.set_ylim(max(low, -450.0) - 10.0, high + 10.0)
    axes.yaxis.set_major_locator(MultipleLocator(45.0))
    label(axes, "Bode: phase, with its margin at the crossover", "phase [deg]", "frequency [rad/s]")


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
    label(axes, "Nyquist", "imaginary part [1]", "real part [1]")
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
        note(axes, text, (0.03, 0.04), within="axes fraction", color=PALETTE.mean, bbox=_PLATE)
        label(axes, name, f"size [{unit}]", "frequency [rad/s]")


def _decibel(values: np.ndarray) -> np.ndarray:
    decibel: np.ndarray = 20.0 * np.log10(np.maximum(np.abs(values), 1e-9))
    return decibel


def _mark_frequency(
    axes: Axes, frequency: float, colour: str, name: str, place: tuple[float, float]
) -> None:
    """Mark a frequency, if there is one, with its name at the left.

    There is always space left of crossover and bandwidth; their colours differ.
    """
    if math.isfinite(frequency):
        axes.axvline(frequency, color=colour, lw=0.9, ls=":")
        within = ("data", "axes fraction")
        look: dict[str, Any] = {"ha": "right", "color": colour, "bbox": _PLATE}
        note(axes, f"{name} {frequency:.3g}", place, (-4.0, 0.0), within=within, **look)


def reach(poles: np.ndarray, crossover: float, highest: float) -> float:
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
    poles = np.linalg.eigvals(A + _GAINS[:, None, None] * back)
    lasting = np.abs(poles.ravel()) > GONE
    colours = np.repeat(np.log10(_GAINS), poles.shape[1])[lasting]
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
    _frame(axes, shown, "root locus: x opened, squares as it is")


def draw_poles(axes: Axes, poles: np.ndarray, shown: float) -> None:
    """Draw the poles of the closed loop over lines of equal damping and natural frequency."""
    for damping in _DAMPING:
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
    outside = int((np.maximum(np.abs(poles.real), np.abs(poles.imag)) > shown).sum())
    more = f", {outside} more outside" if outside else ""
    _frame(axes, shown, f"poles of the closed loop{more}")
    axes.grid(visible=False)


def _round_steps(shown: float) -> np.ndarray:
    """Return a few round numbers up to a limit."""
    step = 10.0 ** math.floor(math.log10(shown / 2.0))
    step *= 5.0 if shown / step > 10.0 else 2.0 if shown / step > 4.0 else 1.0
    return np.arange(step, 1.5 * shown, step)


def _frame(axes: Axes, shown: float, title: str) -> None:
    axes.axvline(0.0, color=PALETTE.limit, lw=0.8)
    axes.set_xlim(-shown, 0.35 * shown)
    axes.set_ylim(-shown, shown)
    label(axes, title, "imaginary part [rad/s]", "real part [1/s]")


@styled
def plot_loop(
    model: LinearModel, loop: Loop, steps: tuple[StepPair, ...] = (), *, cut: str = "actuator"
) -> Figure:
    """Return the figure of one loop: Bode, Nyquist, gang of four, root locus, poles and step.

    Args:
        model: the closed loop; one that holds its position for a loop that holds a position.
        loop: its name.
        steps: linear and flown ones, if any.
        cut: where to open the loop, actuator or error.
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
    for number, part in enumerate(PARTS):
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
        figure.legend(loc="lower center", ncols=len(PARTS), fontsize=8, frameon=False)
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
    label(
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
    label(
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
        label(
            axes,
            name,
            _named(found.second.name, found.second.unit),
            _named(found.first.name, found.first.unit),
        )
    return figure


@styled
def plot_sensitivity(found: "tuple[Sensitivity, ...]", title: str) -> Figure:
    """Return the figure of sensitivities: a table of percent of metric per percent of gain."""
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
    """Return the figure of largest growth rate and smallest phase margin over control period."""
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
    label(
        phase,
        "smallest phase margin; safe above the dashed line",
        "phase [deg]",
        "control period [ms]",
    )
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


def _named(name: str, unit: str) -> str:
    return f"{name.replace('_', ' ')} [{unit}]"


@styled
def plot_measurement(found: "Measurement") -> Figure:
    """Return the figure of a measurement; frequencies of low coherence are pale."""
    measured, model = found.measured, found.model
    frequency, good = measured.frequency, measured.coherence >= COHERENT
    figure, panels = stacked(f"{found.vehicle}: {found.loop}, as modelled and as measured", 3)
    sizes, phases, coherence = panels
    spread = np.minimum(SIGMAS * measured.deviation, 0.9)
    modelled = np.unwrap(np.angle(model))
    turned = modelled + np.angle(measured.response / model)
    for axes, curve, points, bars in (
        (
            sizes,
            _decibel(model),
            _decibel(measured.response),
            np.array([-_decibel(1.0 - spread), _decibel(1.0 + spread)]),
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
    low, high = _decibel(model).min(), _decibel(model).max()
    sizes.set_ylim(low - 8.0, high + 8.0)
    shown = np.degrees(modelled)
    phases.set_ylim(shown.min() - 40.0, shown.max() + 40.0)
    label(sizes, "open loop: magnitude", "|L| [dB]")
    label(phases, "open loop: phase", "phase [°]")
    legend(sizes)
    coherence.semilogx(frequency, measured.coherence, "o-", ms=3.0, color=PALETTE.ours)
    coherence.axhline(COHERENT, color=PALETTE.limit, lw=1.0)
    coherence.set_ylim(-0.03, 1.05)
    label(coherence, "coherence, the lower end of its interval", "coherence [1]")
    for axes in panels:
        if math.isfinite(found.margins.bandwidth):
            axes.axvline(found.margins.bandwidth, color=PALETTE.command, lw=0.8)
    coherence.set_xlabel("frequency [rad/s], the line is the bandwidth")
    return figure
