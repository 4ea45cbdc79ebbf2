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
