"""Rays against shapes with a closed form: where a ray is inside a shape, and what it meets first.

All these shapes are convex, so a ray is inside one in one interval. The functions of a shape take
its size, the ray's origin and its unit direction in the shape's own frame. They return distances
along the ray [m], negative behind its origin; `EMPTY_INTERVAL` if it passes by. numba compiles
them: all rays against all shapes are one call of compiled code.

No function subtracts squares of large numbers. The distance at which a ray passes a centre or an
axis comes from the ray's nearest point or from a cross product. So a ray that nearly touches a
small, distant shape is as accurate as one through its middle.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Shape, Sphere

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable
from workbench.systems.casting.scene import CastGeometry

BOX = 0
SPHERE = 1
CYLINDER = 2
CAPSULE = 3
ELLIPSOID = 4
HALF_SPACE = 5
"""Kinds of shapes, as numbers for compiled code.

Their sizes, three numbers each: half the edges of a box; radius of a sphere; radius and half the
length of a cylinder and of a capsule's cylinder, along z; semi-axes of an ellipsoid; nothing for a
half-space, which lies below z = 0.
"""

RayVector = tuple[float, float, float]
Interval = tuple[float, float]
EMPTY_INTERVAL: Interval = (math.inf, -math.inf)


@register_jitable
def interval(kind: int, size: RayVector, o: RayVector, d: RayVector) -> Interval:
    """Return where the ray from o along d is inside a shape of this kind and size."""
    if kind == BOX:
        return in_box(size, o, d)
    if kind == SPHERE:
        return in_ball(size[0], o, d)
    if kind == CYLINDER:
        return in_cylinder(size[0], size[1], o, d)
    if kind == CAPSULE:
        return in_capsule(size[0], size[1], o, d)
    if kind == ELLIPSOID:
        return in_ellipsoid(size, o, d)
    return in_half_space(o[2], d[2])


@register_jitable
def in_slab(half: float, o: float, d: float) -> Interval:
    """Return the interval between two planes at ±half, for one coordinate of the ray."""
    if d > 0.0:
        return (-half - o) / d, (half - o) / d
    if d < 0.0:
        return (half - o) / d, (-half - o) / d
    if -half <= o <= half:
        return -math.inf, math.inf
    return EMPTY_INTERVAL


@register_jitable
def in_box(size: RayVector, o: RayVector, d: RayVector) -> Interval:
    """Return the interval in a box: what the three pairs of planes have in common."""
    x_in, x_out = in_slab(size[0], o[0], d[0])
    y_in, y_out = in_slab(size[1], o[1], d[1])
    z_in, z_out = in_slab(size[2], o[2], d[2])
    enters, leaves = max(x_in, y_in, z_in), min(x_out, y_out, z_out)
    return (enters, leaves) if enters <= leaves else EMPTY_INTERVAL


@register_jitable
def in_ball(radius: float, o: RayVector, d: RayVector) -> Interval:
    """Return the interval in a sphere, by the ray's nearest point to the centre."""
    along = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2])
    n_x, n_y, n_z = o[0] + along * d[0], o[1] + along * d[1], o[2] + along * d[2]
    rest = radius * radius - (n_x * n_x + n_y * n_y + n_z * n_z)
    if rest < 0.0:
        return EMPTY_INTERVAL
    half = math.sqrt(rest)
    return along - half, along + half


@register_jitable
def in_tube(radius: float, o: RayVector, d: RayVector) -> Interval:
    """Return the interval in an endless cylinder about z."""
    level = d[0] * d[0] + d[1] * d[1]
    if level == 0.0:
        if o[0] * o[0] + o[1] * o[1] <= radius * radius:
            return -math.inf, math.inf
        return EMPTY_INTERVAL
    cross = o[0] * d[1] - o[1] * d[0]
    rest = radius * radius - cross * cross / level
    if rest < 0.0:
        return EMPTY_INTERVAL
    along = -(o[0] * d[0] + o[1] * d[1]) / level
    half = math.sqrt(rest / level)
    return along - half, along + half


@register_jitable
def in_cylinder(radius: float, half: float, o: RayVector, d: RayVector) -> Interval:
    """Return the interval in a cylinder with flat ends."""
    tube_in, tube_out = in_tube(radius, o, d)
    z_in, z_out = in_slab(half, o[2], d[2])
    enters, leaves = max(tube_in, z_in), min(tube_out, z_out)
    return (enters, leaves) if enters <= leaves else EMPTY_INTERVAL


@register_jitable
def in_capsule(radius: float, half: float, o: RayVector, d: RayVector) -> Interval:
    """Return the interval in a capsule: from first to last of its cylinder and its two balls."""
    enters, leaves = in_cylinder(radius, half, o, d)
    low_in, low_out = in_ball(radius, (o[0], o[1], o[2] + half), d)
    high_in, high_out = in_ball(radius, (o[0], o[1], o[2] - half), d)
    return min(enters, low_in, high_in), max(leaves, low_out, high_out)


@register_jitable
def in_ellipsoid(size: RayVector, o: RayVector, d: RayVector) -> Interval:
    """Return the interval in an ellipsoid, which is a unit ball once its axes are scaled."""
    d_x, d_y, d_z = d[0] / size[0], d[1] / size[1], d[2] / size[2]
    length = math.sqrt(d_x * d_x + d_y * d_y + d_z * d_z)
    origin = (o[0] / size[0], o[1] / size[1], o[2] / size[2])
    enters, leaves = in_ball(1.0, origin, (d_x / length, d_y / length, d_z / length))
    return enters / length, leaves / length


@register_jitable
def in_half_space(o_z: float, d_z: float) -> Interval:
    """Return the interval below z = 0."""
    if d_z < 0.0:
        return -o_z / d_z, math.inf
    if d_z > 0.0:
        return -math.inf, -o_z / d_z
    return (-math.inf, math.inf) if o_z <= 0.0 else EMPTY_INTERVAL


COSINE_TOLERANCE = 1e-12
"""Share by which the square of a distance may be wrong where a ray is ruled out."""


class CastSolids(NamedTuple):
    """Shapes with a closed form as arrays, a row each.

    Attributes:
        kinds: `BOX` and so on.
        sizes: (n, 3) [m].
        reach: radius of the ball about the shape's origin that it fits in [m].
        frames: numbers of the frames that they are fixed to.
        X_FG: their poses there (n, 4, 4).
    """

    kinds: np.ndarray
    sizes: np.ndarray
    reach: np.ndarray
    frames: np.ndarray
    X_FG: np.ndarray


def as_solid(shape: Shape) -> tuple[int, RayVector, float] | None:
    """Return kind, size and reach of a shape with a closed form, None if it has none."""
    match shape:
        case Box():
            x, y, z = 0.5 * shape.size()
            return BOX, (x, y, z), math.hypot(x, y, z)
        case Sphere():
            return SPHERE, (shape.radius(), 0.0, 0.0), shape.radius()
        case Cylinder():
            radius, half = shape.radius(), 0.5 * shape.length()
            return CYLINDER, (radius, half, 0.0), math.hypot(radius, half)
        case Capsule():
            radius, half = shape.radius(), 0.5 * shape.length()
            return CAPSULE, (radius, half, 0.0), radius + half
        case Ellipsoid():
            axes = (shape.a(), shape.b(), shape.c())
            return ELLIPSOID, axes, max(axes)
        case HalfSpace():
            return HALF_SPACE, (0.0, 0.0, 0.0), math.inf
    return None


def pack_solids(geometries: Sequence[CastGeometry]) -> CastSolids:
    """Return those of the geometries that have a closed form."""
    found = [(g, *solid) for g in geometries if (solid := as_solid(g.shape)) is not None]
    return CastSolids(
        kinds=np.array([kind for _, kind, _, _ in found], dtype=np.int64),
        sizes=np.array([size for _, _, size, _ in found], dtype=float).reshape(-1, 3),
        reach=np.array([reach for *_, reach in found], dtype=float),
        frames=np.array([g.frame for g, *_ in found], dtype=np.int64),
        X_FG=np.array([g.X_FG.GetAsMatrix4() for g, *_ in found]).reshape(-1, 4, 4),
    )


@register_jitable
def turned_back(X: np.ndarray, x: float, y: float, z: float) -> RayVector:
    """Return a vector of W in the axes of a frame with the pose X (3 or 4, 4) in W."""
    return (
        X[0, 0] * x + X[1, 0] * y + X[2, 0] * z,
        X[0, 1] * x + X[1, 1] * y + X[2, 1] * z,
        X[0, 2] * x + X[1, 2] * y + X[2, 2] * z,
    )


def nearest_solids(
    p_WS: np.ndarray,
    directions: np.ndarray,
    solids: CastSolids,
    X_WG: np.ndarray,
    ranges: np.ndarray,
) -> None:
    """Shorten `ranges` to the nearest solid that each ray meets.

    Most rays pass by the ball around a shape, or have met something before it; both are ruled out
    first, without the shape's own equations.

    Args:
        p_WS: where the rays begin (3) [m].
        directions: unit vectors in W (n, 3).
        solids: what they may meet.
        X_WG: their poses in W (m, 4, 4).
        ranges: how far each ray has come (n) [m]; written where something nearer is met.
    """
    for k in range(len(solids.kinds)):
        X, reach = X_WG[k], solids.reach[k]
        kind, size = solids.kinds[k], (solids.sizes[k, 0], solids.sizes[k, 1], solids.sizes[k, 2])
        p_x, p_y, p_z = X[0, 3] - p_WS[0], X[1, 3] - p_WS[1], X[2, 3] - p_WS[2]
        origin = turned_back(X, -p_x, -p_y, -p_z)
        square = p_x * p_x + p_y * p_y + p_z * p_z
        near = math.sqrt(square) - reach
        # rays closer to a right angle with p than this pass by the ball
        clear = square * (1.0 - COSINE_TOLERANCE) - reach * reach
        for ray in range(len(directions)):
            d_x, d_y, d_z = directions[ray]
            along = d_x * p_x + d_y * p_y + d_z * p_z
            if along * along < clear or ranges[ray] <= near:
                continue
            enters, leaves = interval(kind, size, origin, turned_back(X, d_x, d_y, d_z))
            # a ray that begins inside meets the surface from within, where it leaves
            met = enters if enters >= 0.0 else leaves
            if 0.0 <= met < ranges[ray]:
                ranges[ray] = met


CASTING_SOURCES = ("systems/casting",)
compiled_nearest_solids = compile_cached(nearest_solids, CASTING_SOURCES, "rays against shapes")
