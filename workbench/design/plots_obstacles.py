"""Obstacles in plots: their outlines, seen from above or from anywhere."""

import numpy as np
from matplotlib.axes import Axes
from scipy.spatial import ConvexHull, QhullError

from workbench.design.lidar_trial_world import Obstacle
from workbench.session.recording import Recording

_TIMES = 8
"""So often is drawn what moves."""


def obstacle_times(recording: Recording, obstacle: Obstacle) -> list[float]:
    """Return when to draw an obstacle [s]: once, or several times if it moves."""
    time = recording.time
    return np.linspace(time[0], time[-1], _TIMES).tolist() if obstacle.moves else [float(time[0])]


def outline_W(obstacle: Obstacle, time: float) -> np.ndarray:
    """Return points (n, 3) whose convex hull is about that of an obstacle [m]."""
    X_WO = obstacle.pose(time)
    return np.vstack(
        [(X_WO @ part.X_OG).multiply(part.solid.outline().T).T for part in obstacle.parts]
    )


def draw_silhouette(axes: Axes, points: np.ndarray, obstacle: Obstacle) -> None:
    """Draw the outline of the convex hull of points in the picture (n, 2)."""
    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:  # seen from here it is a line
        corners = points
    style = "--" if obstacle.moves else "-"
    axes.fill(*corners.T, fill=False, ec="0.1", lw=0.8, ls=style, zorder=3)
