"""The bounding sphere of a drone with its turning rotors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pydrake.geometry
from pydrake.math import RigidTransform

from workbench.plant.model import Joint, Link, Model
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    GeometryShape,
    Mesh,
    Sphere,
    box_corners,
    prism_corners,
)

_POLYGON_CORNERS = 64
"""Number of corners of the polygon around a cylinder; it is 0.12 % wider than the circle."""


@dataclass(frozen=True)
class ReachSphere:
    """A sphere about C, a point fixed to the body, that contains the drone with turning rotors.

    Attributes:
        p_BC: its centre in the body frame, that of the bounding box of the drone [m].
        radius: its radius [m].
    """

    p_BC: tuple[float, float, float]
    radius: float


def reach_sphere(model: Model, base_link: str, rotors: Sequence[Rotor]) -> ReachSphere:
    """Return the smallest sphere about the middle of the drone that contains its shapes.

    All visual and collision shapes count: most descriptions draw their propellers, but few give
    them a collision shape. If propellers have no shape at all, only their hubs count, as
    descriptions do not state the size of a propeller otherwise. The sphere is exact except for
    cylinders (0.12 % of their radius too wide), ellipsoids (replaced by the sphere around them),
    and what hangs on joints that move (as if stretched out).

    Args:
        model: with meshes that Drake can draw.
        base_link: its frame is the body frame.
        rotors: their links turn about their axes.
    """
    base = model.link(base_link)
    assert base
    balls = [_balls(base.X_ML.inverse() @ link.X_ML, link) for link in model.links]
    hubs = np.array([rotor.p_BR for rotor in rotors]).reshape(-1, 3)
    centres = np.concatenate([hubs, *(centre for centre, _ in balls)])
    radii = np.concatenate([np.zeros(len(hubs)), *(radius for _, radius in balls)])
    low = np.min(centres - radii[:, None], axis=0)
    high = np.max(centres + radii[:, None], axis=0)
    p_BC = 0.5 * (low + high)
    turning = {rotor.link: rotor for rotor in rotors if rotor.link != base_link}
    farthest = float(np.max(_distances_from(hubs, p_BC), initial=0.0))
    for link, (centre, radius) in zip(model.links, balls, strict=True):
        if len(centre):
            rotor, joints = turning.get(link.name), model.moving_joints_above(link.name)
            ways = [p_BC, *(base.X_ML.InvertAndCompose(each.X_MJ).translation() for each in joints)]
            distance = _swept(centre, p_BC, rotor) if rotor else _distances_from(centre, ways[-1])
            distance = distance + sum(float(np.linalg.norm(b - a)) for a, b in pairwise(ways))
            distance = distance + sum(map(_travel, joints))
            farthest = max(farthest, float(np.max(distance + radius)))
    x, y, z = p_BC.tolist()
    return ReachSphere((x, y, z), farthest)


def _travel(joint: Joint) -> float:
    """Return how far a joint moves along its axes at most, as far as that is stated [m]."""
    ends = [
        end
        for each in joint.freedoms
        if each.kind == "prismatic"
        for end in (abs(each.lower), abs(each.upper))
        if math.isfinite(end)
    ]
    return max(ends, default=0.0)


def _distances_from(points: np.ndarray, p_BC: np.ndarray) -> np.ndarray:
    """Return the distances of points (n, 3) from C, (n) [m]."""
    return np.asarray(np.linalg.norm(points - p_BC, axis=1))


def _swept(points: np.ndarray, p_BC: np.ndarray, rotor: Rotor) -> np.ndarray:
    """Return the largest distances of points (n, 3) from C as they turn with a rotor, (n) [m]."""
    axis, hub = np.array(rotor.axis_B), np.array(rotor.p_BR)
    along, from_axis = _axial_and_radial(points - hub, axis)
    along_C, from_axis_C = _axial_and_radial((p_BC - hub)[None], axis)
    return np.asarray(np.hypot(from_axis + from_axis_C, along - along_C))


def _axial_and_radial(points: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions along an axis through the origin, and distances from it, (n) each [m]."""
    along = points @ axis
    return along, np.linalg.norm(points - along[:, None] * axis, axis=1)


def _balls(X_BL: RigidTransform, link: Link) -> tuple[np.ndarray, np.ndarray]:
    """Return centres (n, 3) in B and radii (n) of spheres that enclose a link's shapes [m]."""
    centres, radii = [np.zeros((0, 3))], [np.zeros(0)]  # a link may have none
    for each in link.shapes:
        points, radius = _enclosing_points(each.shape)
        X_BG = X_BL @ each.X_LS
        centres.append(points @ X_BG.rotation().matrix().T + X_BG.translation())
        radii.append(np.full(len(points), radius))
    return np.concatenate(centres), np.concatenate(radii)


def _enclosing_points(shape: GeometryShape) -> tuple[np.ndarray, float]:
    """Return points (n, 3) in a shape's frame, and the radius of the spheres about them [m]."""
    match shape:
        case Box(size):
            return box_corners(0.5 * np.array(size)), 0.0
        case Sphere(radius):
            return np.zeros((1, 3)), radius
        case Capsule(radius, length):
            return np.array([[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]]), radius
        case Ellipsoid(radii):
            return np.zeros((1, 3)), max(radii)
        case Cylinder(radius, length):
            around = radius / math.cos(math.pi / _POLYGON_CORNERS)
            return prism_corners(around, 0.5 * length, _POLYGON_CORNERS), 0.0
        case Mesh(path=None):
            return np.zeros((0, 3)), 0.0
        case Mesh():
            hull = pydrake.geometry.Mesh(str(shape.path)).GetConvexHull()
            return np.array([hull.vertex(i) for i in range(hull.num_vertices())]), 0.0
