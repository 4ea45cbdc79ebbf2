"""A world as records: obstacles that stand, obstacles that move, and where on the earth it lies."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

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
from pydrake.geometry.optimization import VPolytope
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import unknown_name
from workbench.plant.home import Home
from workbench.plant.remarks import Remark
from workbench.plant.worlds.outline import Course, Outline

GROUND = "ground"
"""The name of the half space below z = 0, which no obstacle may have."""
ROUND = 32
"""Corners of a circle, which lie on it."""
_ANGLES = np.arange(ROUND) * (2.0 * math.pi / ROUND)
_CIRCLE = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros(ROUND)])


@dataclass(frozen=True)
class Obstacle:
    """A rigid thing O that stands still.

    Attributes:
        name: unique in its world; `model::link` where it is a model's.
        X_WO: where it stands.
        collisions: geometries to bump into, named `OBSTACLE::SHAPE`, with poses in O.
        visuals: geometries that are drawn and that sensors see, likewise.
    """

    name: str
    X_WO: RigidTransform
    collisions: tuple[GeometryInstance, ...]
    visuals: tuple[GeometryInstance, ...]


@dataclass(frozen=True)
class MovingObstacle:
    """A shape O that follows a path whatever it meets; it stays upright.

    Attributes:
        name: unique in its world.
        geometry: touchable for signed distances, drawn, and seen by sensors; centred on O.
        course: along which it moves.
    """

    name: str
    geometry: GeometryInstance
    course: Course

    def pose(self, time: float) -> RigidTransform:
        """Return X_WO at a time of the flight [s]."""
        x, y, z, yaw = self.course.at(time)
        return RigidTransform(RollPitchYaw(0.0, 0.0, yaw), np.array([x, y, z]))


@dataclass(frozen=True)
class World:
    """What is around the drone, with flat ground at z = 0 unless it says otherwise.

    Attributes:
        source: the file that was read.
        name: the file's, without its ending.
        title: what people call it.
        ground: whether there is ground.
        obstacles: those that stand still.
        moving: those that move.
        home: where on the earth its origin lies, None where it does not say.
        remarks: what was assumed, missing or left unused.
    """

    source: Path
    name: str
    title: str = ""
    ground: bool = True
    obstacles: tuple[Obstacle, ...] = ()
    moving: tuple[MovingObstacle, ...] = ()
    home: Home | None = None
    remarks: tuple[Remark, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all obstacles; the first are those that stand."""
        return (*(each.name for each in self.obstacles), *(each.name for each in self.moving))

    def pose(self, name: str, time: float) -> RigidTransform:
        """Return X_WO of an obstacle at a time of the flight [s].

        Raises:
            WorkbenchError: if there is none of the name.
        """
        for obstacle in self.obstacles:
            if obstacle.name == name:
                return obstacle.X_WO
        for moving in self.moving:
            if moving.name == name:
                return moving.pose(time)
        raise unknown_name("obstacle", name, self.names)


EMPTY = World(source=Path("empty"), name="empty")
"""Nothing but the ground."""


def obstacle_of(geometry: str) -> str:
    """Return the obstacle that a geometry's name in the scene graph belongs to, or `GROUND`."""
    return geometry.rpartition("::")[0] or geometry


def first_twice(names: Iterable[str]) -> str | None:
    """Return the first name that came before, if one did."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


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
        _outline(each.name, RigidTransform(), each.geometry, each.course) for each in world.moving
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
    # Drake's hull is loaded already; loading scipy's takes 0.2 s
    hull = VPolytope(points[:, :2].T).GetMinimalRepresentation().vertices().T
    if len(hull) < 3:  # flat from above, as a pane that stands upright
        return None
    corners = tuple((float(x), float(y)) for x, y in hull[::-1])  # Drake goes clockwise
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
