"""The obstacles of a world in closed form: the pose of each, and what a ray hits first.

This is what a perfect lidar measures. The code is independent of the code that casts the rays of
the lidar, so that one can verify the other. A ray passes through a convex solid in one stretch,
from entry to exit. It first hits the entry, or from inside the exit.
"""

from collections.abc import Callable, Iterable
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
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.design.ray_solid import (
    RaySolid,
    box,
    capsule,
    cylinder,
    ellipsoid,
    half_space,
    sphere,
    surface_of,
)
from workbench.plant.worlds.world import GROUND_NAME, World

ObstaclePart = tuple[RaySolid, RigidTransform]
"""One solid G of an obstacle, with its pose X_OG in the obstacle's frame."""


@dataclass(frozen=True)
class RayObstacle:
    """Something that rays can hit.

    Attributes:
        name: as the world calls it.
        parts: its solids.
        pose: X_WO at a time [s].
        moves: whether the pose changes.
    """

    name: str
    parts: tuple[ObstaclePart, ...]
    pose: Callable[[float], RigidTransform]
    moves: bool = False

    def first(
        self, time: float, X_WS: RigidTransform, d_S: np.ndarray, farthest: float
    ) -> np.ndarray:
        """Return the lengths of rays from one point to the obstacle (n) [m], inf at a miss.

        Args:
            time: when [s].
            X_WS: pose of the sensor; the rays begin at the origin of S.
            d_S: their directions in S (n, 3), unit vectors.
            farthest: parts wholly beyond this may be ignored [m].
        """
        found = np.full(len(d_S), np.inf)
        for solid, X_OG in self.parts:
            X_GS = (self.pose(time) @ X_OG).inverse() @ X_WS
            p_GS, R_GS = X_GS.translation(), X_GS.rotation().matrix()
            some = _towards(p_GS, d_S @ (R_GS.T @ p_GS), solid.reach, farthest)
            if len(some):
                starts = np.tile(p_GS, (len(some), 1))
                met = solid.first(starts, d_S[some] @ R_GS.T)
                found[some] = np.minimum(found[some], met)
        return found

    def distance(self, time: float, p_W: np.ndarray) -> float:
        """Return the distance of a point (3) from the obstacle [m]; 0 inside."""
        return min(
            float(solid.distance((self.pose(time) @ X_OG).inverse().multiply(p_W)[None, :])[0])
            for solid, X_OG in self.parts
        )

    def outline(self, time: float) -> np.ndarray:
        """Return points in W (n, 3) with about the convex hull of the obstacle [m]."""
        X_WO = self.pose(time)
        return np.vstack([(X_WO @ X_OG).multiply(solid.outline.T).T for solid, X_OG in self.parts])


def first_hits(
    obstacles: Iterable[RayObstacle],
    time: float,
    X_WS: RigidTransform,
    d_S: np.ndarray,
    farthest: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return what rays from one point hit first, see `RayObstacle.first`.

    Returns:
        Lengths (n) [m], inf without a hit, and the index of the obstacle (n), or -1.
    """
    length, which = np.full(len(d_S), np.inf), np.full(len(d_S), -1)
    for index, obstacle in enumerate(obstacles):
        found = obstacle.first(time, X_WS, d_S, farthest)
        nearer = found < length
        length[nearer], which[nearer] = found[nearer], index
    return length, which


def world_obstacles(world: World) -> tuple[RayObstacle, ...]:
    """Return all obstacles in a world that sensors see.

    They come from the world file and not from the scene that the rays are cast against, so that a
    misplaced obstacle in the scene also shows as an error of the lidar.
    """
    found = [
        RayObstacle(each.name, tuple(map(_obstacle_part, each.visuals)), _standing(each.X_WO))
        for each in world.obstacles
    ]
    found += [
        RayObstacle(each.name, (_obstacle_part(each.geometry),), each.pose, moves=True)
        for each in world.moving
    ]
    if world.ground:
        ground = (half_space(), RigidTransform())
        found.append(RayObstacle(GROUND_NAME, (ground,), _standing(RigidTransform())))
    return tuple(obstacle for obstacle in found if obstacle.parts)


def _standing(X_WO: RigidTransform) -> Callable[[float], RigidTransform]:
    """Return the constant pose over time of what does not move."""
    return lambda time: X_WO


def _obstacle_part(geometry: GeometryInstance) -> ObstaclePart:
    """Return the closed form of a geometry with its pose in its obstacle."""
    return solid_of(geometry.shape()), geometry.pose()


def _towards(p_GS: np.ndarray, against: np.ndarray, reach: float, farthest: float) -> np.ndarray:
    """Return which rays from p_GS hit the sphere of radius `reach` about the origin of G.

    `against` (n) is the dot product of each ray's direction with p_GS.
    """
    away = float(np.linalg.norm(p_GS))
    if away <= reach:
        return np.arange(len(against))
    if away - reach > farthest:
        return np.zeros(0, dtype=int)
    touching = np.sqrt(away**2 - reach**2)
    return np.flatnonzero(-against >= touching - 1e-9 * away)


def solid_of(shape: Shape) -> RaySolid:
    """Return the closed form of one of Drake's shapes.

    Raises:
        WorkbenchError: if there is none.
    """
    match shape:
        case Box():
            return box(0.5 * np.array(shape.size()))
        case Sphere():
            return sphere(shape.radius())
        case Cylinder():
            return cylinder(shape.radius(), shape.length())
        case Capsule():
            return capsule(shape.radius(), shape.length())
        case Ellipsoid():
            return ellipsoid((shape.a(), shape.b(), shape.c()))
        case HalfSpace():
            return half_space()
        case Mesh() | Convex():
            path = Path(shape.source().path())
            return surface_of(path, np.array(shape.scale3()), hull=isinstance(shape, Convex))
    raise WorkbenchError(
        f"the lidar trial has no closed form for a {type(shape).__name__}: leave it out of the "
        "world"
    )
