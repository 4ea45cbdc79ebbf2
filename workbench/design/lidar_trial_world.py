"""The obstacles of a lidar trial as closed forms: where each is, and what a ray meets first."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import Box as DrakeBox
from pydrake.geometry import Capsule as DrakeCapsule
from pydrake.geometry import Convex as DrakeConvex
from pydrake.geometry import Cylinder as DrakeCylinder
from pydrake.geometry import Ellipsoid as DrakeEllipsoid
from pydrake.geometry import GeometryInstance, Shape
from pydrake.geometry import HalfSpace as DrakeHalfSpace
from pydrake.geometry import Mesh as DrakeMesh
from pydrake.geometry import Sphere as DrakeSphere
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.design.lidar_truth import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Solid,
    Sphere,
    TriangleMesh,
)
from workbench.plant.worlds.world import GROUND, World


@dataclass(frozen=True)
class Part:
    """One solid G of an obstacle, with its pose in the obstacle's frame."""

    solid: Solid
    X_OG: RigidTransform


@dataclass(frozen=True)
class Obstacle:
    """Something that rays meet.

    Attributes:
        name: as the world calls it.
        parts: what it is made of.
        pose: X_WO at a time [s].
        moves: whether that changes.
    """

    name: str
    parts: tuple[Part, ...]
    pose: Callable[[float], RigidTransform]
    moves: bool = False

    def first(
        self, time: float, X_WS: RigidTransform, d_S: np.ndarray, farthest: float
    ) -> np.ndarray:
        """Return how far rays from one place go until they meet it (n) [m], inf at a miss.

        Args:
            time: when [s].
            X_WS: they begin at the origin of S.
            d_S: their directions in S (n, 3), unit vectors.
            farthest: parts that lie wholly beyond need not be found [m].
        """
        found = np.full(len(d_S), np.inf)
        for part in self.parts:
            X_GS = (self.pose(time) @ part.X_OG).inverse() @ X_WS
            p_GS, R_GS = X_GS.translation(), X_GS.rotation().matrix()
            some = _towards(p_GS, d_S @ (R_GS.T @ p_GS), part.solid.reach, farthest)
            if len(some):
                starts = np.tile(p_GS, (len(some), 1))
                met = part.solid.first(starts, d_S[some] @ R_GS.T)
                found[some] = np.minimum(found[some], met)
        return found

    def distance(self, time: float, p_W: np.ndarray) -> float:
        """Return how far a point (3) is from it [m]; 0 inside."""
        return min(
            float(part.solid.distance(X_GW.multiply(p_W)[None, :])[0])
            for part in self.parts
            for X_GW in [(self.pose(time) @ part.X_OG).inverse()]
        )


@dataclass(frozen=True)
class Hits:
    """What rays meet first: lengths (n) [m], inf without a hit, and which obstacle (n), or -1."""

    length: np.ndarray
    obstacle: np.ndarray


def first_hits(
    obstacles: Iterable[Obstacle],
    time: float,
    X_WS: RigidTransform,
    d_S: np.ndarray,
    farthest: float,
) -> Hits:
    """Return what rays from one place meet first, see `Obstacle.first`."""
    length, which = np.full(len(d_S), np.inf), np.full(len(d_S), -1)
    for index, obstacle in enumerate(obstacles):
        found = obstacle.first(time, X_WS, d_S, farthest)
        nearer = found < length
        length[nearer], which[nearer] = found[nearer], index
    return Hits(length, which)


def world_obstacles(world: World) -> tuple[Obstacle, ...]:
    """Return everything in a world that sensors see.

    It is taken from the world's file and not from the scene that the rays are cast against, so
    that an obstacle put in a wrong place is an error of the lidar too.
    """
    found = [
        Obstacle(each.name, tuple(map(_part, each.visuals)), _standing(each.X_WO))
        for each in world.obstacles
    ]
    found += [
        Obstacle(each.name, (_part(each.geometry),), each.pose, moves=True) for each in world.moving
    ]
    if world.ground:
        ground = Part(HalfSpace(), RigidTransform())
        found.append(Obstacle(GROUND, (ground,), _standing(RigidTransform())))
    return tuple(obstacle for obstacle in found if obstacle.parts)


def _standing(X_WO: RigidTransform) -> Callable[[float], RigidTransform]:
    """Return the pose over time of what does not move."""
    return lambda time: X_WO


def _part(geometry: GeometryInstance) -> Part:
    """Return the closed form of a geometry, whose pose is that in its obstacle."""
    return Part(solid_of(geometry.shape()), geometry.pose())


def _towards(p_GS: np.ndarray, against: np.ndarray, reach: float, farthest: float) -> np.ndarray:
    """Return which rays from p_GS meet the ball of radius `reach` about the origin of G.

    `against` (n) is the product of each ray's direction with p_GS.
    """
    away = float(np.linalg.norm(p_GS))
    if away <= reach:
        return np.arange(len(against))
    if away - reach > farthest:
        return np.zeros(0, dtype=int)
    touching = np.sqrt(away**2 - reach**2)
    return np.flatnonzero(-against >= touching - 1e-9 * away)


def solid_of(shape: Shape) -> Solid:
    """Return the closed form of one of Drake's shapes.

    Raises:
        WorkbenchError: if there is none.
    """
    match shape:
        case DrakeBox():
            half = 0.5 * np.array(shape.size())
            return Box((float(half[0]), float(half[1]), float(half[2])))
        case DrakeSphere():
            return Sphere(shape.radius())
        case DrakeCylinder():
            return Cylinder(shape.radius(), shape.length())
        case DrakeCapsule():
            return Capsule(shape.radius(), shape.length())
        case DrakeEllipsoid():
            return Ellipsoid((shape.a(), shape.b(), shape.c()))
        case DrakeHalfSpace():
            return HalfSpace()
        case DrakeMesh() | DrakeConvex():
            path = Path(shape.source().path())
            hull = isinstance(shape, DrakeConvex)
            return TriangleMesh.from_file(path, np.array(shape.scale3()), hull=hull)
    raise WorkbenchError(
        f"the lidar trial has no closed form for a {type(shape).__name__}: leave it out of the "
        "world"
    )
