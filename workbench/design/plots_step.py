"""Figures of steps: of a command, of a load, of a hover check, and compared with the paper."""

import math
import textwrap
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from workbench.common.quantity import number_or_dash
from workbench.design.attitude_step import AttitudeResponse, response_to_setpoint
from workbench.design.flown_step import axis_velocity
from workbench.design.hover_check import (
    MAX_CHECK_OVERSHOOT_PCT,
    MAX_HOVER_DRIFT_M,
    MAX_HOVER_TILT_RAD,
    HoverReport,
)
from workbench.design.load_metrics import LOAD_SETTLING_BAND
from workbench.design.load_step import LoadResponse, response_to_load
from workbench.design.plots import (
    PALETTE,
    draw_command,
    label_panel,
    legend,
    note,
    series_look,
    stacked,
    styled,
    titled,
    widen,
)
from workbench.design.reproduce import ReproducedRow
from workbench.design.step_metrics import SETTLING_BAND, StepMetrics
from workbench.design.step_response import (
    STEP_EDGE_S,
    StepResponse,
    axis_acceleration,
    axis_command,
    axis_force,
)
from workbench.scenario.attitude_axes import find_attitude_axis
from workbench.scenario.axes import find_axis
from workbench.scenario.loads import find_load
from workbench.session.recording import Recording

_NOTE_WIDTH_CHARS = 26
"""Width of the text beside a panel [characters]."""
SHOWN_BEFORE_EDGE_S = 0.5
"""Time shown before the edge of the command [s]."""
_FAR_MEAN_SPANS = 3.0
"""A mean of the paper that is farther off than this many spans of our curve is only stated."""


@styled
def plot_step(step: StepResponse) -> Figure:
    """Return the figure of a step, with its settling band and metrics."""
    axis, metrics, unit = step.axis, step.metrics, find_axis(step.axis).unit
    shown = shown_part(step)
    time = shown.time
    figure, panels = stacked(f"{shown.vehicle.name}: {axis} step of {step.amplitude:g} {unit}", 4)
    response, drive, acceleration, rotors = panels
    draw_response(response, shown, axis)
    steady = metrics.steady_state_value
    if np.isfinite(steady):
        band = abs(SETTLING_BAND * steady)
        _draw_settling(
            response, step.before + steady, band, metrics.settling_time, "steady state ± 2 %"
        )
    legend(response)
    draw_force(drive, shown, axis)
    draw_acceleration(acceleration, shown, axis)
    draw_rotor_use(rotors, time, shown)
    legend(rotors)
    rotors.set_xlim(-SHOWN_BEFORE_EDGE_S, time[-1])
    _write_metrics(drive, metrics, unit)
    return figure


@styled
def plot_attitude_step(step: AttitudeResponse) -> Figure:
    """Return the figure of a step of an attitude or a rate, with its settling band and metrics."""
    row, metrics = find_attitude_axis(step.axis), step.metrics
    end = step.edge + float(step.time[-1])
    shown = step.recording.between(step.edge - SHOWN_BEFORE_EDGE_S, end)
    time = shown.time - step.edge
    figure, panels = stacked(
        f"{shown.vehicle.name}: {row.label} step of {step.amplitude:g} {row.unit}", 4
    )
    response, tilt, moment, rotors = panels
    setpoint = np.where(time >= 0.0, step.amplitude, 0.0)
    moved = response_to_setpoint(row, shown)
    draw_command(response, time, setpoint, lw=1.2)
    response.plot(time, moved, color=PALETTE.ours, label="response")
    widen(response, setpoint, moved)
    label_panel(response, f"{row.label}: setpoint and response", f"{row.label} [{row.unit}]")
    steady = metrics.steady_state_value
    if np.isfinite(steady):
        band = abs(SETTLING_BAND * steady)
        _draw_settling(response, steady, band, metrics.settling_time, "steady state ± 2 %")
    legend(response)
    tilt.plot(time, np.degrees(shown.tilt), color=PALETTE.ours)
    widen(tilt, np.degrees(shown.tilt))
    label_panel(tilt, "tilt", "tilt [°]")
    about = shown.moment_B[:, row.place]
    moment.plot(time, about, color=PALETTE.ours)
    widen(moment, about)
    label_panel(moment, f"torque of the rotors about body {'xy'[row.place]}", "torque [N·m]")
    draw_rotor_use(rotors, time, shown)
    legend(rotors)
    rotors.set_xlim(-SHOWN_BEFORE_EDGE_S, time[-1])
    _write_metrics(tilt, metrics, row.unit)
    return figure


def _write_metrics(axes: Axes, metrics: StepMetrics, unit: str) -> None:
    """Write the numbers of a step beside a panel."""
    _write_beside(
        axes,
        f"rise time  {number_or_dash(metrics.rise_time, '.3f')} s",
        f"settling time  {number_or_dash(metrics.settling_time, '.3f')} s",
        f"overshoot  {number_or_dash(metrics.overshoot, '.2f')} %",
        f"undershoot  {number_or_dash(metrics.undershoot, '.2f')} %",
        f"steady state  {number_or_dash(metrics.steady_state_value, '.4g')} {unit}",
        f"error  {number_or_dash(metrics.steady_state_error, '.2f')} %",
        f"peak rotor use  {100.0 * metrics.peak_rotor_use:.0f} %",
        *textwrap.wrap(metrics.withheld, _NOTE_WIDTH_CHARS),
    )


def _draw_settling(axes: Axes, steady: float, band: float, settling_time: float, name: str) -> None:
    """Draw the settling band and the settling time."""
    axes.axhspan(steady - band, steady + band, color=PALETTE.window, lw=0, zorder=0, label=name)
    if np.isfinite(settling_time):
        axes.axvline(settling_time, color=PALETTE.mean, ls=":", label="settled")


def _write_beside(axes: Axes, *lines: str) -> None:
    """Write lines to the right of a panel."""
    look: dict[str, Any] = {"va": "top", "linespacing": 1.5, "size": 8.5}
    note(axes, "\n".join(lines), (1.0, 1.0), (8.0, 0.0), within="axes fraction", **look)


@styled
def plot_load(flown: LoadResponse) -> Figure:
    """Return the figure of a step of a load, with its settling band."""
    load, metrics = find_load(flown.load), flown.metrics
    end = float(flown.time[-1])
    shown = flown.recording.between(STEP_EDGE_S - SHOWN_BEFORE_EDGE_S, STEP_EDGE_S + end)
    time = shown.time - STEP_EDGE_S
    figure, panels = stacked(
        f"{shown.vehicle.name}: {load.label}, a step of {flown.amplitude:.4g} {load.unit}", 4
    )
    pushed, response, tilt, rotors = panels
    acting = np.where(time >= 0.0, flown.amplitude, 0.0)
    pushed.plot(time, acting, color=PALETTE.command, drawstyle="steps-post", label="load")
    widen(pushed, acting)
    label_panel(pushed, f"load: {load.label}", f"{load.name.partition('_')[0]} [{load.unit}]")
    deviation = response_to_load(load, shown)
    response.plot(time, deviation, color=PALETTE.ours, label="response")
    widen(response, deviation)
    label_panel(response, f"response: {load.response}", f"deviation [{load.response_unit}]")
    if np.isfinite(metrics.settling_time):
        name, band = "steady state ± 5 % of the peak", LOAD_SETTLING_BAND * metrics.peak
        _draw_settling(response, float(deviation[-1]), band, metrics.settling_time, name)
    legend(response)
    tilt.plot(time, np.degrees(shown.tilt), color=PALETTE.ours)
    widen(tilt, np.degrees(shown.tilt))
    label_panel(tilt, "tilt", "tilt [°]")
    draw_rotor_use(rotors, time, shown)
    legend(rotors)
    rotors.set_xlim(-SHOWN_BEFORE_EDGE_S, time[-1])
    _write_beside(
        pushed,
        f"peak  {number_or_dash(metrics.peak, '.4g')} {load.response_unit}",
        f"peak time  {number_or_dash(metrics.peak_time, '.3f')} s",
        f"settling time  {number_or_dash(metrics.settling_time, '.3f')} s",
        f"steady error  {number_or_dash(metrics.steady_state_error, '.1f')} % of the peak",
        f"peak rotor use  {100.0 * flown.peak_rotor_use:.0f} %",
        *textwrap.wrap(metrics.withheld, _NOTE_WIDTH_CHARS),
    )
    return figure


def shown_part(flight: StepResponse) -> Recording:
    """Return the part of a step that a figure shows: the motion, and some time at rest after it.

    Its times are those from the edge on.
    """
    flown = float(flight.time[-1])
    settled = flight.metrics.settling_time
    end = min(flown, max(2.0, 2.0 * settled)) if np.isfinite(settled) else flown
    part = flight.recording.between(flight.edge - SHOWN_BEFORE_EDGE_S, flight.edge + end)
    return replace(part, time=part.time - flight.edge)


def draw_response(axes: Axes, shown: Recording, axis: str) -> None:
    """Draw command and response."""
    what = "yaw rate" if axis == "yaw" else f"velocity along {axis}"
    command, response = axis_command(shown, axis), axis_velocity(shown, axis)
    draw_command(axes, shown.time, command, lw=1.2)
    axes.plot(shown.time, response, color=PALETTE.ours, label="response")
    widen(axes, command, response)
    label_panel(
        axes, f"{what}: command and response", f"{what.split(' along')[0]} [{find_axis(axis).unit}]"
    )


def draw_force(axes: Axes, shown: Recording, axis: str) -> None:
    """Draw the force or torque that drives an axis."""
    titles = {"z": "total rotor thrust", "yaw": "torque of the rotors about body z"}
    title = titles.get(axis, f"force of the rotors along {axis}")
    force = axis_force(shown, axis)
    axes.plot(shown.time, force, color=PALETTE.ours, label="flown here")
    widen(axes, force)
    label_panel(
        axes, title, f"{'torque' if axis == 'yaw' else 'force'} [{find_axis(axis).force_unit}]"
    )


def draw_acceleration(axes: Axes, shown: Recording, axis: str) -> None:
    """Draw the acceleration along an axis, or about it."""
    title = "angular acceleration about z" if axis == "yaw" else f"acceleration along {axis}"
    acceleration = axis_acceleration(shown, axis)
    axes.plot(shown.time, acceleration, color=PALETTE.ours, label="flown here")
    widen(axes, acceleration)
    label_panel(axes, title, f"acceleration [{find_axis(axis).acceleration_unit}]")


def draw_rotor_use(axes: Axes, time: np.ndarray, shown: Recording) -> None:
    """Draw the speed of every rotor as a share of its limit."""
    limits = np.array([rotor.max_rot_velocity for rotor in shown.vehicle.rotors])
    for index, use in enumerate((100.0 * shown.rotor_speeds / limits).T):
        axes.plot(time, use, label=f"rotor {index + 1}", **series_look(index))
    axes.axhline(100.0, color=PALETTE.limit, lw=1.0, label="limit")
    axes.set_ylim(0.0, 105.0)
    label_panel(axes, "rotor speeds", "share of limit [%]")


@styled
def plot_hover(report: HoverReport) -> Figure:
    """Return the figure of a hover check."""
    vehicle = report.hover.vehicle
    figure = titled(f"{vehicle.name}: ten seconds of hover, and a step on every axis", 12.5, 8.4)
    panels = figure.subplots(3, 2)
    time = report.hover.time
    _draw_hover(panels[0, 0], time, 1000.0 * report.drift, 1000.0 * MAX_HOVER_DRIFT_M)
    label_panel(panels[0, 0], "distance from where it began", "distance [mm]")
    _draw_hover(panels[0, 1], time, np.degrees(report.tilt), float(np.degrees(MAX_HOVER_TILT_RAD)))
    label_panel(panels[0, 1], "tilt away from where it began", "angle [deg]")
    legend(panels[0, 1])
    for axes, step in zip(panels[1:].flat, report.steps, strict=True):
        _draw_demanded_step(axes, step)
    for axes in panels[1:, 1]:
        legend(axes)
    figure.align_ylabels()
    return figure


def _draw_hover(axes: Axes, time: np.ndarray, values: np.ndarray, limit: float) -> None:
    """Draw the drift and tilt of a hover, with their limits."""
    axes.plot(time, values, color=PALETTE.ours, label="flown")
    axes.axhline(limit, color=PALETTE.limit, lw=1.0, label="limit")
    axes.set_xlim(time[0], time[-1])
    widen(axes, values, 0.0, limit)
    axes.set_xlabel("time [s]")


def _draw_demanded_step(axes: Axes, step: StepResponse) -> None:
    """Draw command and response with the limit of the overshoot."""
    shown = shown_part(step)
    draw_response(axes, shown, step.axis)
    steady = step.metrics.steady_state_value
    most = step.before + (1.0 + MAX_CHECK_OVERSHOOT_PCT / 100.0) * (
        step.amplitude if math.isnan(steady) else steady
    )
    axes.axhline(
        most, color=PALETTE.limit, lw=1.0, label=f"overshoot of {MAX_CHECK_OVERSHOOT_PCT:g} %"
    )
    widen(axes, axis_velocity(shown, step.axis), axis_command(shown, step.axis), most)
    over = number_or_dash(step.metrics.overshoot, ".1f")
    axes.set_title(f"{axes.get_title(loc='left')}, overshoot {over} %")
    axes.set_xlim(-SHOWN_BEFORE_EDGE_S, shown.time[-1])
    axes.set_xlabel("time since the command's edge [s]")


@styled
def plot_reproduced(row: ReproducedRow) -> Figure:
    """Return the figure of a step, with the same panels as in the paper."""
    axis, paper = row.paper.axis, row.paper
    shown = shown_part(row.flight)
    figure, panels = stacked(
        f"{shown.vehicle.name} beside the paper's figure {paper.number}: "
        f"{axis} step of {paper.command:g} {find_axis(axis).unit}",
        3,
    )
    response, drive, acceleration = panels
    draw_response(response, shown, axis)
    draw_force(drive, shown, axis)
    _draw_means(
        drive,
        axis_force(shown, axis),
        row.t90,
        row.mean_force,
        paper.mean_force,
        find_axis(axis).force_unit,
    )
    draw_acceleration(acceleration, shown, axis)
    _draw_means(
        acceleration,
        axis_acceleration(shown, axis),
        row.t90,
        row.mean_acceleration,
        paper.mean_acceleration,
        find_axis(axis).acceleration_unit,
    )
    for axes, letter in zip(panels, "abc", strict=True):
        axes.set_title(f"({letter}) {axes.get_title(loc='left')}")
        if np.isfinite(row.t90):
            axes.axvspan(0.0, row.t90, color=PALETTE.window, lw=0, zorder=0, label="window")
        legend(axes)
    panels[-1].set_xlim(-SHOWN_BEFORE_EDGE_S, shown.time[-1])
    return figure


def _draw_means(
    axes: Axes, values: np.ndarray, t90: float, mean: float, paper: float, unit: str
) -> None:
    """Draw the mean of a curve over the window, and that of the paper."""
    if np.isfinite(t90):
        axes.plot(
            [0.0, t90],
            [mean, mean],
            color=PALETTE.mean,
            lw=2.2,
            solid_capstyle="butt",
            label=f"mean in window {mean:.3g} {unit}",
        )
    name = f"paper's mean {paper:g} {unit}"
    if abs(paper) <= _FAR_MEAN_SPANS * float(np.abs(values).max()):
        axes.axhline(paper, color=PALETTE.paper, ls="--", lw=1.3, label=name)
        widen(axes, values, paper)
    else:
        axes.plot(
            [], [], color=PALETTE.paper, ls="--", lw=1.3, label=f"{name}\n(far off this scale)"
        )
