"""A world as records: static and moving obstacles, and its position on the earth."""

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
from workbench.plant.remarks import DescriptionRemark
from workbench.plant.worlds.outline import ObstaclePath, Outline

GROUND_NAME = "ground"
"""Reserved name of the half space below z = 0."""
CIRCLE_CORNERS = 32
"""Number of corners of the polygon for a circle; they are on the circle."""
_CIRCLE_ANGLES_RAD = np.arange(CIRCLE_CORNERS) * (2.0 * math.pi / CIRCLE_CORNERS)
_CIRCLE_POINTS = np.column_stack(
    [np.cos(_CIRCLE_ANGLES_RAD), np.sin(_CIRCLE_ANGLES_RAD), np.zeros(CIRCLE_CORNERS)]
)


@dataclass(frozen=True)
class StaticObstacle:
    """A static rigid obstacle O.

    Attributes:
        name: unique in its world; `model::link` for a link of a model.
        X_WO: its pose.
        collisions: geometries for contact, named `OBSTACLE::SHAPE`, with poses in O.
        visuals: geometries for drawing and sensors, with such names and poses.
    """

    name: str
    X_WO: RigidTransform
    collisions: tuple[GeometryInstance, ...]
    visuals: tuple[GeometryInstance, ...]


@dataclass(frozen=True)
class MovingObstacle:
    """An upright shape O that follows a path, regardless of contact.

    Attributes:
        name: unique in its world.
        geometry: for signed distances, drawing and sensors; centred on O.
        course: its path.
    """

    name: str
    geometry: GeometryInstance
    course: ObstaclePath

    def pose(self, time: float) -> RigidTransform:
        """Return X_WO at a flight time [s]."""
        x, y, z, yaw = self.course.at(time)
        return RigidTransform(RollPitchYaw(0.0, 0.0, yaw), np.array([x, y, z]))


@dataclass(frozen=True)
class World:
    """The surroundings of the drone, by default with flat ground at z = 0.

    Attributes:
        source: the file that was read.
        name: of the file without its ending.
        title: for people.
        ground: whether there is ground.
        obstacles: static ones.
        moving: moving ones.
        home: position of its origin on the earth, None if not stated.
        remarks: on what was assumed, missing or not used.
    """

    source: Path
    name: str
    title: str = ""
    ground: bool = True
    obstacles: tuple[StaticObstacle, ...] = ()
    moving: tuple[MovingObstacle, ...] = ()
    home: Home | None = None
    remarks: tuple[DescriptionRemark, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all obstacles, static ones first."""
        return (*(each.name for each in self.obstacles), *(each.name for each in self.moving))

    def pose(self, name: str, time: float) -> RigidTransform:
        """Return X_WO of an obstacle at a flight time [s].

        Raises:
            WorkbenchError: if the name is unknown.
        """
        for obstacle in self.obstacles:
            if obstacle.name == name:
                return obstacle.X_WO
        for moving in self.moving:
            if moving.name == name:
                return moving.pose(time)
        raise unknown_name("obstacle", name, self.names)


EMPTY_WORLD = World(source=Path("empty"), name="empty")
"""The world with only the ground."""


def obstacle_of(geometry: str) -> str:
    """Return the obstacle of a geometry by its name in the scene graph, or `GROUND_NAME`."""
    return geometry.rpartition("::")[0] or geometry


def first_duplicate(names: Iterable[str]) -> str | None:
    """Return the first name that occurs twice, or None."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


def outlines(world: World) -> tuple[Outline, ...]:
    """Return the outlines of all obstacles with contact, without the ground, for each convex part.

    Infinite parts, and parts without an area seen from above, have no outline.
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
    name: str, X_WO: RigidTransform, geometry: GeometryInstance, course: ObstaclePath | None = None
) -> Outline | None:
    X_WG = X_WO @ geometry.pose()
    points = _shadow_points(geometry.shape(), X_WG.rotation().matrix())
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


def _shadow_points(shape: Shape, R: np.ndarray) -> np.ndarray:
    """Return points (N, 3) [m] around the centre of a rotated shape with the same shadow as it.

    Infinite shapes, and shapes without a hull, have no points.
    """
    match shape:
        case Box():
            signs = np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, -1).T
            return (signs * shape.size()) @ R.T
        case Sphere():
            return _ellipsoid_extremes(shape.radius() ** 2 * np.eye(3))
        case Ellipsoid():
            halves = np.array([shape.a(), shape.b(), shape.c()])
            return _ellipsoid_extremes(R @ np.diag(halves**2) @ R.T)
        case Cylinder():
            end = np.array([0.0, 0.0, 0.5 * shape.length()])
            rim = shape.radius() * _CIRCLE_POINTS
            return np.vstack([rim + end, rim - end]) @ R.T
        case Capsule():
            end = 0.5 * shape.length() * R[:, 2]
            ball = _ellipsoid_extremes(shape.radius() ** 2 * np.eye(3))
            return np.vstack([ball + end, ball - end])
        case Mesh() | Convex():
            return np.array(list(_mesh_corners(shape))).reshape(-1, 3) @ R.T
        case _:
            return np.empty((0, 3))


def _ellipsoid_extremes(M: np.ndarray) -> np.ndarray:
    """Return the rim from above, the highest and the lowest point of an ellipsoid p·M⁻¹p = 1."""
    root = np.linalg.cholesky(M[:2, :2])
    rim = np.zeros((CIRCLE_CORNERS, 3))
    rim[:, :2] = _CIRCLE_POINTS[:, :2] @ root.T
    top = M[:, 2] / math.sqrt(M[2, 2])
    return np.vstack([rim, top, -top])


def _mesh_corners(shape: Mesh | Convex) -> Iterable[np.ndarray]:
    """Return the corners of the convex hull of a mesh; none for an unsupported file format."""
    try:
        hull = shape.GetConvexHull()
    except RuntimeError:
        return ()
    return (hull.vertex(index) for index in range(hull.num_vertices()))
