"""A log in 3-D as one HTML page, with the drone, its path, and the commanded path."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, Rgba
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.design.flight_page import quiet_meshcat
from workbench.logs.logged_signal import SETPOINT_SIGNALS, component_names
from workbench.logs.readers.rotations import QUATERNION_NAMES
from workbench.plant.description import Description
from workbench.plant.multibody import add_shapes

FILM_FRAME_PERIOD_S = 1.0 / 32.0
"""Period between pictures [s]."""
MAX_FILM_S = 3600.0
"""Longest film [s]."""
_FLOWN_PATH_RGBA, _SETPOINT_PATH_RGBA = Rgba(0.12, 0.47, 0.71, 1.0), Rgba(1.0, 0.5, 0.05, 1.0)
_CAMERA_OFFSET = np.array([-1.2, -1.2, 0.8])
"""Position of the camera from the middle of the flown path, in sizes of the path."""


def film_flight(
    flight: Flight,
    description: Description,
    page: Path,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Write the film of a log; the drone is hidden where its position or attitude is unknown.

    Args:
        flight: the log; motion capture takes precedence over the estimate of the flight computer.
        description: of the drone to draw.
        page: the HTML file to write.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if the log has no attitude.
    """
    topic = "attitude" if "attitude.q_w" in flight else "estimate"
    turn = component_names(f"{topic}.", QUATERNION_NAMES)
    if not flight.has(turn):
        raise WorkbenchError(f"{flight.source}: has no attitude: there is nothing to draw in 3-D")
    where = "position_data" if "position_data.x" in flight else "estimate"
    place = component_names(f"{where}.")
    still = not flight.has(place)
    names = turn if still else [*turn, *place]
    grid = flight.resample(names, FILM_FRAME_PERIOD_S, bridge=0.1)
    if grid.time[-1] - grid.time[0] > MAX_FILM_S:
        raise WorkbenchError(
            f"{flight.source}: is longer than {MAX_FILM_S:g} s: too long for a page"
        )
    if not grid.whole.any():
        raise WorkbenchError(f"{flight.source}: place and attitude are never known together")
    states = np.zeros((len(grid.time), 13))
    states[:, 0:4] = grid.values[:, 0:4]
    states[:, 4:7] = [0.0, 0.0, 1.0] if still else grid.values[:, 4:7]
    meshcat = quiet_meshcat()
    path = states[grid.whole, 4:7]
    middle, size = path.mean(axis=0), max(float(np.ptp(path, axis=0).max()), 1.0)
    meshcat.SetCameraPose(middle + size * _CAMERA_OFFSET, middle)
    if not still:
        _draw_path(meshcat, "flown", path, _FLOWN_PATH_RGBA)
        if flight.has(SETPOINT_SIGNALS):
            asked = flight.resample(SETPOINT_SIGNALS, FILM_FRAME_PERIOD_S, bridge=1.0)
            _draw_path(meshcat, "setpoint", asked.values[asked.whole], _SETPOINT_PATH_RGBA)
    _play(meshcat, description, grid.time, states, grid.whole, progress)
    page.write_text(meshcat.StaticHtml(), encoding="utf-8")


def _draw_path(meshcat: Meshcat, name: str, points: np.ndarray, color: Rgba) -> None:
    if len(points) > 1:
        meshcat.SetLine(name, points.T, 2.0, color)


def _play(
    meshcat: Meshcat,
    description: Description,
    time: np.ndarray,
    states: np.ndarray,
    known: np.ndarray,
    progress: Callable[[float], None] | None,
) -> None:
    """Add the drone to the film, at each state (n, 13) and time (n) [s]."""
    builder = DiagramBuilder()
    scene_graph, state = add_shapes(builder, description)
    builder.ExportInput(state, "state")
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    meshcat.StartRecording()
    seen = True
    for index in range(len(time)):
        now = float(time[index] - time[0])
        if known[index]:
            q = states[index, 0:4]
            diagram.get_input_port(0).FixValue(
                context, np.concatenate([q / np.linalg.norm(q), states[index, 4:]])
            )
            context.SetTime(now)
            diagram.ForcedPublish(context)
        if seen != known[index]:
            seen = bool(known[index])
            meshcat.SetProperty("visualizer", "visible", seen, now)
        if progress:
            progress((index + 1) / len(time))
    meshcat.StopRecording()
    meshcat.PublishRecording()
