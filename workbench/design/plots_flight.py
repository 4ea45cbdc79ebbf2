"""The overview of a flight: path from above, and height, mode, velocities, rotors over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial import ConvexHull, QhullError

from workbench.control.guidance import Reference
from workbench.control.mode import FlightMode
from workbench.design.obstacles import RayObstacle, world_obstacles
from workbench.design.plots import PALETTE, draw_command, label_panel, legend, styled, titled, widen
from workbench.design.plots_step import draw_rotor_use
from workbench.plant.worlds.world import EMPTY_WORLD, GROUND_NAME, World
from workbench.session.recording import Recording

_FOLLOW_FLAG_INDEX = Reference._fields.index("follow")
"""Index in a reference of the flag for a valid position; the position is in the three before."""
_MAX_PATH_MARKERS = 20
_OBSTACLE_TIMES = 8
"""Number of times at which a moving obstacle is drawn."""
_MIN_FLIGHT_SPAN_S = 0.1
"""Smallest span of the time axis [s]."""
_MIN_PATH_SPAN_M = 1.0
"""Smallest span of the panel of the path [m], so that hover shows as a point."""


@styled
def plot_flight(recording: Recording, title: str, world: World = EMPTY_WORLD) -> Figure:
    """Return the overview of a flight in a world."""
    figure = titled(title, 12.5, 8.4)
    grid = figure.add_gridspec(4, 2, width_ratios=(1.0, 1.35), height_ratios=(1, 1.2, 1, 1))
    _draw_path_from_above(figure.add_subplot(grid[:3, 0]), recording, world)
    height = figure.add_subplot(grid[0, 1])
    velocity, yaw, rotors = (figure.add_subplot(grid[row, 1], sharex=height) for row in (1, 2, 3))
    mode = figure.add_subplot(grid[3, 0], sharex=height)
    _draw_height(height, recording)
    _draw_velocities(velocity, recording)
    _draw_yaw_rate(yaw, recording)
    draw_rotor_use(rotors, recording.time, recording)
    _draw_mode(mode, recording)
    for axes in (velocity, yaw, rotors):
        legend(axes)
    for axes in (height, velocity, yaw):
        axes.tick_params(labelbottom=False)
    for axes in (rotors, mode):
        axes.set_xlabel("time [s]")
    begin = recording.time[0]
    height.set_xlim(begin, max(recording.time[-1], begin + _MIN_FLIGHT_SPAN_S))
    figure.align_ylabels([height, velocity, yaw, rotors])
    return figure


def _draw_path_from_above(axes: Axes, recording: Recording, world: World) -> None:
    """Draw the path from above, to scale, with the obstacles near it."""
    x, y, _ = recording.p_WB.T
    for obstacle in world_obstacles(world):
        if obstacle.name != GROUND_NAME:
            for time in obstacle_times(recording, obstacle):
                draw_silhouette(axes, obstacle.outline(time)[:, :2], obstacle)
    _draw_requested_path(axes, recording)
    axes.plot(x, y, color=PALETTE.ours, label="flown")
    axes.plot(x[0], y[0], "o", color=PALETTE.series[2], ms=8, label="start")
    axes.plot(x[-1], y[-1], "s", color=PALETTE.mean, ms=5, label="end")
    half = 0.55 * max(np.ptp(x), np.ptp(y), _MIN_PATH_SPAN_M)
    middle_x, middle_y = 0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())
    axes.set_xlim(middle_x - half, middle_x + half)
    axes.set_ylim(middle_y - half, middle_y + half)
    axes.set_aspect("equal", adjustable="box")
    axes.set_anchor("N")
    label_panel(axes, "path from above", "y, north [m]", "x, east [m]")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=4, borderaxespad=0.0)


def _draw_requested_path(axes: Axes, recording: Recording) -> None:
    """Draw the positions requested by the pilot or a path: a few points, or a line."""
    follows = recording.reference[:, _FOLLOW_FLAG_INDEX] == 1.0
    asked = recording.reference[follows, _FOLLOW_FLAG_INDEX - 3 : _FOLLOW_FLAG_INDEX - 1]
    points = np.unique(asked, axis=0)
    if len(points) > _MAX_PATH_MARKERS:
        axes.plot(*asked.T, color=PALETTE.command, lw=0.9, label="asked for")
    elif len(points):
        axes.plot(*points.T, "x", color=PALETTE.command, ms=9, label="asked for")


def _draw_height(axes: Axes, recording: Recording) -> None:
    """Draw the height of the base link, and the ground where it is near."""
    z = recording.p_WB[:, 2]
    axes.plot(recording.time, z, color=PALETTE.ours)
    widen(axes, z, 0.0, least=0.5)
    label_panel(axes, "height of the base link", "z [m]")


def _draw_velocities(axes: Axes, recording: Recording) -> None:
    """Draw velocities in W and their commands."""
    commanded = np.isfinite(recording.reference).any()
    for index, axis in enumerate("xyz"):
        color = PALETTE.series[index]
        # Thinner from axis to axis, so that equal curves show below each other.
        axes.plot(
            recording.time,
            recording.v_WB[:, index],
            color=color,
            lw=2.6 - 0.8 * index,
            label=f"along {axis}",
        )
        command = recording.reference[:, index]
        if commanded:
            draw_command(axes, recording.time, command, color=color, label=f"{axis} command")
    widen(axes, recording.v_WB, recording.reference[:, :3], least=0.2)
    label_panel(axes, "velocity and command" if commanded else "velocity", "velocity [m/s]")


def _draw_yaw_rate(axes: Axes, recording: Recording) -> None:
    """Draw the yaw rate and its command."""
    rate, command = recording.w_WB[:, 2], recording.reference[:, 3]
    axes.plot(recording.time, rate, color=PALETTE.ours, label="yaw rate")
    commanded = np.isfinite(command).any()
    if commanded:
        draw_command(axes, recording.time, command)
    widen(axes, rate, command, least=0.1)
    label_panel(axes, "yaw rate and command" if commanded else "yaw rate", "yaw rate [rad/s]")


def _draw_mode(axes: Axes, recording: Recording) -> None:
    """Draw the flight mode over time, by name."""
    known = recording.mode[np.isfinite(recording.mode)].astype(int)
    names = [FlightMode(mode).label for mode in sorted(set(known))]
    places = np.searchsorted(sorted(set(known)), known)
    if names:
        axes.plot(recording.time, places, color=PALETTE.ours, drawstyle="steps-post", lw=2.0)
    else:
        axes.text(0.5, 0.5, "open loop", transform=axes.transAxes, ha="center", va="center")
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(-0.5, max(len(names), 1) - 0.5)
    label_panel(axes, "flight mode", "")


def obstacle_times(recording: Recording, obstacle: RayObstacle) -> list[float]:
    """Return the times at which to draw an obstacle [s]: one, or several if it moves."""
    time = recording.time
    return (
        np.linspace(time[0], time[-1], _OBSTACLE_TIMES).tolist()
        if obstacle.moves
        else [float(time[0])]
    )


def draw_silhouette(axes: Axes, points: np.ndarray, obstacle: RayObstacle) -> None:
    """Draw the outline of the convex hull of points in the picture (n, 2)."""
    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:  # seen from this direction it is a line
        corners = points
    style = "--" if obstacle.moves else "-"
    axes.fill(*corners.T, fill=False, ec="0.1", lw=0.8, ls=style, zorder=3)
