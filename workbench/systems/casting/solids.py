"""Rays against shapes with a closed form: where a ray is inside a shape, and what it meets first.

All these shapes are convex, so a ray is inside one in one interval. The functions of a shape take
its size, the ray's origin and its unit direction in the shape's own frame. They return distances
along the ray [m], negative behind its origin; `OUTSIDE` if it passes by. numba compiles them: all
rays against all shapes are one call of compiled code.

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

Three = tuple[float, float, float]
Interval = tuple[float, float]
OUTSIDE: Interval = (math.inf, -math.inf)


@register_jitable
def interval(kind: int, size: Three, o: Three, d: Three) -> Interval:
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
    return OUTSIDE


@register_jitable
def in_box(size: Three, o: Three, d: Three) -> Interval:
    """Return the interval in a box: what the three pairs of planes have in common."""
    x_in, x_out = in_slab(size[0], o[0], d[0])
    y_in, y_out = in_slab(size[1], o[1], d[1])
    z_in, z_out = in_slab(size[2], o[2], d[2])
    enters, leaves = max(x_in, y_in, z_in), min(x_out, y_out, z_out)
    return (enters, leaves) if enters <= leaves else OUTSIDE


@register_jitable
def in_ball(radius: float, o: Three, d: Three) -> Interval:
    """Return the interval in a sphere, by the ray's nearest point to the centre."""
    along = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2])
    n_x, n_y, n_z = o[0] + along * d[0], o[1] + along * d[1], o[2] + along * d[2]
    rest = radius * radius - (n_x * n_x + n_y * n_y + n_z * n_z)
    if rest < 0.0:
        return OUTSIDE
    half = math.sqrt(rest)
    return along - half, along + half


@register_jitable
def in_tube(radius: float, o: Three, d: Three) -> Interval:
    """Return the interval in an endless cylinder about z."""
    level = d[0] * d[0] + d[1] * d[1]
    if level == 0.0:
        if o[0] * o[0] + o[1] * o[1] <= radius * radius:
            return -math.inf, math.inf
        return OUTSIDE
    cross = o[0] * d[1] - o[1] * d[0]
    rest = radius * radius - cross * cross / level
    if rest < 0.0:
        return OUTSIDE
    along = -(o[0] * d[0] + o[1] * d[1]) / level
    half = math.sqrt(rest / level)
    return along - half, along + half


@register_jitable
def in_cylinder(radius: float, half: float, o: Three, d: Three) -> Interval:
    """Return the interval in a cylinder with flat ends."""
    tube_in, tube_out = in_tube(radius, o, d)
    z_in, z_out = in_slab(half, o[2], d[2])
    enters, leaves = max(tube_in, z_in), min(tube_out, z_out)
    return (enters, leaves) if enters <= leaves else OUTSIDE


@register_jitable
def in_capsule(radius: float, half: float, o: Three, d: Three) -> Interval:
    """Return the interval in a capsule: from first to last of its cylinder and its two balls."""
    enters, leaves = in_cylinder(radius, half, o, d)
    low_in, low_out = in_ball(radius, (o[0], o[1], o[2] + half), d)
    high_in, high_out = in_ball(radius, (o[0], o[1], o[2] - half), d)
    return min(enters, low_in, high_in), max(leaves, low_out, high_out)


@register_jitable
def in_ellipsoid(size: Three, o: Three, d: Three) -> Interval:
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
    return (-math.inf, math.inf) if o_z <= 0.0 else OUTSIDE


BUNDLE = 32
"""So many neighbouring rays are taken together when shapes far from them are ruled out."""
MARGIN = 1e-12
"""By which a cosine may be wrong where something is ruled out."""


class Solids(NamedTuple):
    """Shapes with a closed form as arrays, a row each.

    Attributes:
        kinds: `BOX` and so on.
        sizes: (n, 3) [m].
        reach: radius of the ball about the shape's origin that it fits in [m].
        frames: numbers of the frames that they are fixed to.
        R_FG: their orientations (n, 3, 3).
        p_FG: their places (n, 3) [m].
        numbers: which geometry of the scene each is.
    """

    kinds: np.ndarray
    sizes: np.ndarray
    reach: np.ndarray
    frames: np.ndarray
    R_FG: np.ndarray
    p_FG: np.ndarray
    numbers: np.ndarray


class Solid(NamedTuple):
    """Kind, size and reach of one shape."""

    kind: int
    size: tuple[float, float, float]
    reach: float


def as_solid(shape: Shape) -> Solid | None:
    """Return the closed form of a shape, None if it has none."""
    match shape:
        case Box():
            x, y, z = 0.5 * shape.size()
            return Solid(BOX, (x, y, z), math.hypot(x, y, z))
        case Sphere():
            return Solid(SPHERE, (shape.radius(), 0.0, 0.0), shape.radius())
        case Cylinder():
            radius, half = shape.radius(), 0.5 * shape.length()
            return Solid(CYLINDER, (radius, half, 0.0), math.hypot(radius, half))
        case Capsule():
            radius, half = shape.radius(), 0.5 * shape.length()
            return Solid(CAPSULE, (radius, half, 0.0), radius + half)
        case Ellipsoid():
            axes = (shape.a(), shape.b(), shape.c())
            return Solid(ELLIPSOID, axes, max(axes))
        case HalfSpace():
            return Solid(HALF_SPACE, (0.0, 0.0, 0.0), math.inf)
    return None


def pack_solids(geometries: Sequence[CastGeometry]) -> Solids:
    """Return those of the geometries that have a closed form."""
    found = [
        (number, geometry, solid)
        for number, geometry in enumerate(geometries)
        if (solid := as_solid(geometry.shape)) is not None
    ]
    return Solids(
        kinds=np.array([solid.kind for _, _, solid in found], dtype=np.int64),
        sizes=np.array([solid.size for _, _, solid in found], dtype=float).reshape(-1, 3),
        reach=np.array([solid.reach for _, _, solid in found], dtype=float),
        frames=np.array([geometry.frame for _, geometry, _ in found], dtype=np.int64),
        R_FG=np.array([g.X_FG.rotation().matrix() for _, g, _ in found]).reshape(-1, 3, 3),
        p_FG=np.array([g.X_FG.translation() for _, g, _ in found]).reshape(-1, 3),
        numbers=np.array([number for number, _, _ in found], dtype=np.int64),
    )


class Placed(NamedTuple):
    """Positions of the solids relative to the rays' origin S.

    Attributes:
        R_WG: their orientations (n, 3, 3).
        p_SG_W: from S to them (n, 3) [m].
        p_GS: from them to S, in their own axes (n, 3) [m].
        distance: of their origins (n) [m].
        near: how far at the least their surfaces are (n) [m], negative inside their balls.
    """

    R_WG: np.ndarray
    p_SG_W: np.ndarray
    p_GS: np.ndarray
    distance: np.ndarray
    near: np.ndarray


@register_jitable
def place(p_WS: np.ndarray, solids: Solids, X_WF: np.ndarray) -> Placed:
    """Return where the solids are when their frames have the poses X_WF (m, 3, 4)."""
    count = len(solids.kinds)
    placed = Placed(
        np.zeros((count, 3, 3)),
        np.zeros((count, 3)),
        np.zeros((count, 3)),
        np.zeros(count),
        np.zeros(count),
    )
    for k in range(count):
        X = X_WF[solids.frames[k]]
        R_WG, p_SG_W, p_GS = placed.R_WG[k], placed.p_SG_W[k], placed.p_GS[k]
        for i in range(3):
            p_SG_W[i] = X[i, 3] - p_WS[i]
            for j in range(3):
                p_SG_W[i] += X[i, j] * solids.p_FG[k, j]
                for m in range(3):
                    R_WG[i, j] += X[i, m] * solids.R_FG[k, m, j]
        for i in range(3):
            for j in range(3):
                p_GS[j] -= R_WG[i, j] * p_SG_W[i]
        placed.distance[k] = math.sqrt(p_SG_W[0] ** 2 + p_SG_W[1] ** 2 + p_SG_W[2] ** 2)
        if solids.kinds[k] == HALF_SPACE:
            placed.near[k] = abs(p_GS[2])
        else:
            placed.near[k] = placed.distance[k] - solids.reach[k]
    return placed


@register_jitable
def cone_around(directions: np.ndarray) -> tuple[float, float, float, float]:
    """Return the axis of a cone around unit vectors (n, 3) and the cosine of half its angle."""
    x = y = z = 0.0
    for d_x, d_y, d_z in directions:
        x, y, z = x + d_x, y + d_y, z + d_z
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 1.0, 0.0, 0.0, -1.0
    x, y, z = x / length, y / length, z / length
    cosine = 1.0
    for d_x, d_y, d_z in directions:
        cosine = min(cosine, x * d_x + y * d_y + z * d_z)
    return x, y, z, cosine


def nearest_solids(
    p_WS: np.ndarray,
    directions: np.ndarray,
    solids: Solids,
    X_WF: np.ndarray,
    ranges: np.ndarray,
    hits: np.ndarray,
) -> None:
    """Shorten `ranges` to the nearest solid that each ray meets, and say in `hits` which.

    All rays begin at one point, so a bundle of neighbours lies in a narrow cone. A shape whose ball
    the cone does not meet is skipped for the whole bundle. Shapes follow from near to far, until
    they begin beyond everything that the bundle has met.

    Args:
        p_WS: where the rays begin (3) [m].
        directions: unit vectors in W (n, 3).
        solids: what they may meet.
        X_WF: poses of the frames (m, 3, 4), the world first.
        ranges: how far each ray has come (n) [m]; written where something nearer is met.
        hits: numbers of the geometries met (n); written with it.
    """
    placed = place(p_WS, solids, X_WF)
    order = np.argsort(placed.near)
    for first in range(0, len(directions), BUNDLE):
        last = min(first + BUNDLE, len(directions))
        a_x, a_y, a_z, cos_bundle = cone_around(directions[first:last])
        sin_bundle = math.sqrt(max(0.0, 1.0 - cos_bundle * cos_bundle))
        farthest = ranges[first:last].max()
        for k in order:
            if placed.near[k] >= farthest:
                break
            p_x, p_y, p_z = placed.p_SG_W[k]
            reach, away = solids.reach[k], placed.distance[k]
            if cos_bundle > 0.0 and away > reach:
                sin_ball = reach / away
                cos_ball = math.sqrt(1.0 - sin_ball * sin_ball)
                cos_between = (a_x * p_x + a_y * p_y + a_z * p_z) / away
                if cos_between < cos_bundle * cos_ball - sin_bundle * sin_ball - MARGIN:
                    continue
            size = (solids.sizes[k, 0], solids.sizes[k, 1], solids.sizes[k, 2])
            kind, number = solids.kinds[k], solids.numbers[k]
            origin = (placed.p_GS[k, 0], placed.p_GS[k, 1], placed.p_GS[k, 2])
            R = placed.R_WG[k]
            # Rays closer to a right angle with p than this pass by the ball.
            clear = away * away * (1.0 - MARGIN) - reach * reach
            farthest = 0.0
            for ray in range(first, last):
                d_x, d_y, d_z = directions[ray]
                along = d_x * p_x + d_y * p_y + d_z * p_z
                if along * along >= clear:
                    direction = (
                        R[0, 0] * d_x + R[1, 0] * d_y + R[2, 0] * d_z,
                        R[0, 1] * d_x + R[1, 1] * d_y + R[2, 1] * d_z,
                        R[0, 2] * d_x + R[1, 2] * d_y + R[2, 2] * d_z,
                    )
                    enters, leaves = interval(kind, size, origin, direction)
                    # A ray that begins inside meets the surface from within, where it leaves.
                    met = enters if enters >= 0.0 else leaves
                    if 0.0 <= met < ranges[ray]:
                        ranges[ray] = met
                        hits[ray] = number
                farthest = max(farthest, ranges[ray])


SOURCES = ("systems/casting",)
compiled_nearest_solids = compile_cached(nearest_solids, SOURCES, "rays against shapes", parts=40)
