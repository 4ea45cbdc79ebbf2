"""What a world's obstacles look like from above."""

import math
from collections.abc import Iterable

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    Mesh,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from scipy.spatial import ConvexHull, QhullError

from workbench.plant.worlds.outline import Course, Outline
from workbench.plant.worlds.world import World

ROUND = 32
"""Corners of a circle, which lie on it."""
_ANGLES = np.arange(ROUND) * (2.0 * math.pi / ROUND)
_CIRCLE = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(ROUND)])


def outlines(world: World) -> tuple[Outline, ...]:
    """Return the outlines of all that can be bumped into, a convex part each, but the ground's.

    Parts without an area from above, and without an end, have none.
    """
    standing = (
        _outline(obstacle.name, obstacle.X_WO, geometry)
        for obstacle in world.obstacles
        for geometry in obstacle.collisions
    )
    moving = (
        _outline(
            each.name,
            RigidTransform(),
            each.geometry,
            Course(each.times, each.corners, each.repeat),
        )
        for each in world.moving
    )
    return tuple(each for each in (*standing, *moving) if each is not None)


def _outline(
    name: str, X_WO: RigidTransform, geometry: GeometryInstance, course: Course | None = None
) -> Outline | None:
    X_WG = X_WO @ geometry.pose()
    points = _points(geometry.shape(), X_WG.rotation().matrix())
    if not len(points):
        return None
    points = points + X_WG.translation()
    try:
        hull = ConvexHull(points[:, :2])
    except QhullError:  # flat from above, as a pane that stands upright
        return None
    corners = tuple((float(x), float(y)) for x, y in points[hull.vertices, :2])
    low, high = points[:, 2].min(), points[:, 2].max()
    return Outline(name, corners, float(low), float(high), course)


def _points(shape: Shape, R: np.ndarray) -> np.ndarray:
    """Return points about the middle of a turned shape (N, 3) [m] whose shadow is its own.

    None of what has no end, or no hull.
    """
    match shape:
        case Box():
            signs = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T
            return (signs * shape.size()) @ R.T
        case Sphere():
            return _ball(shape.radius() ** 2 * np.eye(3))
        case Ellipsoid():
            halves = np.array([shape.a(), shape.b(), shape.c()])
            return _ball(R @ np.diag(halves**2) @ R.T)
        case Cylinder():
            end = np.array([0.0, 0.0, 0.5 * shape.length()])
            rim = shape.radius() * _CIRCLE
            return np.vstack([rim + end, rim - end]) @ R.T
        case Capsule():
            end = 0.5 * shape.length() * R[:, 2]
            ball = _ball(shape.radius() ** 2 * np.eye(3))
            return np.vstack([ball + end, ball - end])
        case Mesh() | Convex():
            return np.array(list(_corners(shape))).reshape(-1, 3) @ R.T
        case _:
            return np.empty((0, 3))


def _ball(M: np.ndarray) -> np.ndarray:
    """Return the rim from above, the highest and the lowest point of an ellipsoid p·M⁻¹p = 1."""
    root = np.linalg.cholesky(M[:2, :2])
    rim = np.zeros((ROUND, 3))
    rim[:, :2] = _CIRCLE[:, :2] @ root.T
    top = M[:, 2] / math.sqrt(M[2, 2])
    return np.vstack([rim, top, -top])


def _corners(shape: Mesh | Convex) -> Iterable[np.ndarray]:
    """Return the corners of a mesh's convex hull; none of a kind of file that Drake has none of."""
    try:
        hull = shape.GetConvexHull()
    except RuntimeError:
        return ()
    return (hull.vertex(index) for index in range(hull.num_vertices()))
