"""Where a ray is inside a shape, in closed form: the times at which it enters and leaves.

All shapes here are convex, so that is one interval. Each function takes the shape's size, the ray's
origin and its unit direction in the shape's own frame, and returns distances along the ray [m],
negative behind its origin; `OUTSIDE` where it passes by. Plain arithmetic that numba compiles.

None of them subtracts squares of large numbers: how far a ray passes from a centre or an axis comes
from its nearest point to it or from a cross product, so that a ray that nearly touches a small,
distant shape is judged as well as one through its middle.
"""

import math

from workbench.common.jitable import register_jitable

BOX, SPHERE, CYLINDER, CAPSULE, ELLIPSOID, HALF_SPACE = range(6)
"""Kinds of shapes, as numbers for compiled code.

Their sizes, three numbers each: half the edges of a box; radius of a sphere; radius and half the
length of a cylinder and of a capsule's cylinder, along z; semi-axes of an ellipsoid; nothing for a
half-space, which lies below z = 0.
"""

Interval = tuple[float, float]
OUTSIDE: Interval = (math.inf, -math.inf)


@register_jitable
def interval(
    kind: int,
    s_x: float,
    s_y: float,
    s_z: float,
    o_x: float,
    o_y: float,
    o_z: float,
    d_x: float,
    d_y: float,
    d_z: float,
) -> Interval:
    """Return where the ray from o along d is inside a shape of this kind and size."""
    if kind == BOX:
        return in_box(s_x, s_y, s_z, o_x, o_y, o_z, d_x, d_y, d_z)
    if kind == SPHERE:
        return in_ball(s_x, o_x, o_y, o_z, d_x, d_y, d_z)
    if kind == CYLINDER:
        return in_cylinder(s_x, s_y, o_x, o_y, o_z, d_x, d_y, d_z)
    if kind == CAPSULE:
        return in_capsule(s_x, s_y, o_x, o_y, o_z, d_x, d_y, d_z)
    if kind == ELLIPSOID:
        return in_ellipsoid(s_x, s_y, s_z, o_x, o_y, o_z, d_x, d_y, d_z)
    return in_half_space(o_z, d_z)


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
def in_box(
    s_x: float,
    s_y: float,
    s_z: float,
    o_x: float,
    o_y: float,
    o_z: float,
    d_x: float,
    d_y: float,
    d_z: float,
) -> Interval:
    """Return the interval in a box: what the three pairs of planes have in common."""
    x_in, x_out = in_slab(s_x, o_x, d_x)
    y_in, y_out = in_slab(s_y, o_y, d_y)
    z_in, z_out = in_slab(s_z, o_z, d_z)
    enters, leaves = max(x_in, y_in, z_in), min(x_out, y_out, z_out)
    return (enters, leaves) if enters <= leaves else OUTSIDE


@register_jitable
def in_ball(
    radius: float, o_x: float, o_y: float, o_z: float, d_x: float, d_y: float, d_z: float
) -> Interval:
    """Return the interval in a sphere, by the ray's nearest point to the centre."""
    along = -(o_x * d_x + o_y * d_y + o_z * d_z)
    n_x, n_y, n_z = o_x + along * d_x, o_y + along * d_y, o_z + along * d_z
    rest = radius * radius - (n_x * n_x + n_y * n_y + n_z * n_z)
    if rest < 0.0:
        return OUTSIDE
    half = math.sqrt(rest)
    return along - half, along + half


@register_jitable
def in_tube(radius: float, o_x: float, o_y: float, d_x: float, d_y: float) -> Interval:
    """Return the interval in an endless cylinder about z."""
    level = d_x * d_x + d_y * d_y
    if level == 0.0:
        if o_x * o_x + o_y * o_y <= radius * radius:
            return -math.inf, math.inf
        return OUTSIDE
    cross = o_x * d_y - o_y * d_x
    rest = radius * radius - cross * cross / level
    if rest < 0.0:
        return OUTSIDE
    along = -(o_x * d_x + o_y * d_y) / level
    half = math.sqrt(rest / level)
    return along - half, along + half


@register_jitable
def in_cylinder(
    radius: float,
    half: float,
    o_x: float,
    o_y: float,
    o_z: float,
    d_x: float,
    d_y: float,
    d_z: float,
) -> Interval:
    """Return the interval in a cylinder with flat ends."""
    tube_in, tube_out = in_tube(radius, o_x, o_y, d_x, d_y)
    z_in, z_out = in_slab(half, o_z, d_z)
    enters, leaves = max(tube_in, z_in), min(tube_out, z_out)
    return (enters, leaves) if enters <= leaves else OUTSIDE


@register_jitable
def in_capsule(
    radius: float,
    half: float,
    o_x: float,
    o_y: float,
    o_z: float,
    d_x: float,
    d_y: float,
    d_z: float,
) -> Interval:
    """Return the interval in a capsule: from first to last of its cylinder and its two balls."""
    enters, leaves = in_cylinder(radius, half, o_x, o_y, o_z, d_x, d_y, d_z)
    low_in, low_out = in_ball(radius, o_x, o_y, o_z + half, d_x, d_y, d_z)
    high_in, high_out = in_ball(radius, o_x, o_y, o_z - half, d_x, d_y, d_z)
    return min(enters, low_in, high_in), max(leaves, low_out, high_out)


@register_jitable
def in_ellipsoid(
    s_x: float,
    s_y: float,
    s_z: float,
    o_x: float,
    o_y: float,
    o_z: float,
    d_x: float,
    d_y: float,
    d_z: float,
) -> Interval:
    """Return the interval in an ellipsoid, which is a unit ball once its axes are scaled."""
    d_x, d_y, d_z = d_x / s_x, d_y / s_y, d_z / s_z
    length = math.sqrt(d_x * d_x + d_y * d_y + d_z * d_z)
    enters, leaves = in_ball(
        1.0, o_x / s_x, o_y / s_y, o_z / s_z, d_x / length, d_y / length, d_z / length
    )
    return enters / length, leaves / length


@register_jitable
def in_half_space(o_z: float, d_z: float) -> Interval:
    """Return the interval below z = 0."""
    if d_z < 0.0:
        return -o_z / d_z, math.inf
    if d_z > 0.0:
        return -math.inf, -o_z / d_z
    return (-math.inf, math.inf) if o_z <= 0.0 else OUTSIDE
