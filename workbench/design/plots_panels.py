"""The panels that figures of steps are made of; each is a recording's curve over time."""

import numpy as np
from matplotlib.axes import Axes

from workbench.design.plots import PALETTE, label, widen
from workbench.design.step_response import (
    EDGE,
    StepResponse,
    axis_acceleration,
    axis_command,
    axis_force,
    axis_velocity,
)
from workbench.scenario.axes import find_axis
from workbench.session.recording import Recording

BEFORE = 0.5
"""Shown before the command's edge [s]."""


def shown_part(flight: StepResponse) -> Recording:
    """Return the part of a step that a figure shows: all that moves, and some rest after it."""
    flown = float(flight.time[-1])
    settled = flight.metrics.settling_time
    end = min(flown, max(2.0, 2.0 * settled)) if np.isfinite(settled) else flown
    return flight.recording.between(EDGE - BEFORE, EDGE + end)


def draw_response(axes: Axes, shown: Recording, axis: str) -> None:
    """Draw command and response."""
    what = "yaw rate" if axis == "yaw" else f"velocity along {axis}"
    time, command, response = (
        shown.time - EDGE,
        axis_command(shown, axis),
        axis_velocity(shown, axis),
    )
    axes.plot(
        time, command, "--", color=PALETTE.command, lw=1.2, drawstyle="steps-post", label="command"
    )
    axes.plot(time, response, color=PALETTE.ours, label="response")
    widen(axes, command, response)
    label(
        axes, f"{what}: command and response", f"{what.split(' along')[0]} [{find_axis(axis).unit}]"
    )


def draw_force(axes: Axes, shown: Recording, axis: str) -> None:
    """Draw the force or torque that drives an axis."""
    titles = {"z": "total rotor thrust", "yaw": "torque of the rotors about body z"}
    title = titles.get(axis, f"force of the rotors along {axis}")
    force = axis_force(shown, axis)
    axes.plot(shown.time - EDGE, force, color=PALETTE.ours, label="flown here")
    widen(axes, force)
    label(axes, title, f"{'torque' if axis == 'yaw' else 'force'} [{find_axis(axis).force_unit}]")


def draw_acceleration(axes: Axes, shown: Recording, axis: str) -> None:
    """Draw the acceleration along an axis, or about it."""
    title = "angular acceleration about z" if axis == "yaw" else f"acceleration along {axis}"
    acceleration = axis_acceleration(shown, axis)
    axes.plot(shown.time - EDGE, acceleration, color=PALETTE.ours, label="flown here")
    widen(axes, acceleration)
    label(axes, title, f"acceleration [{find_axis(axis).acceleration_unit}]")


def draw_rotor_use(axes: Axes, time: np.ndarray, shown: Recording) -> None:
    """Draw every rotor's speed as a share of its limit."""
    limits = np.array([rotor.max_rot_velocity for rotor in shown.vehicle.rotors])
    for index, use in enumerate((100.0 * shown.rotor_speeds / limits).T):
        axes.plot(
            time,
            use,
            color=PALETTE.series[index % len(PALETTE.series)],
            ls=("-", "--", "-.", ":")[index % 4],
            label=f"rotor {index + 1}",
        )
    axes.axhline(100.0, color=PALETTE.limit, lw=1.0, label="limit")
    axes.set_ylim(0.0, 105.0)
    label(axes, "rotor speeds", "share of limit [%]")
