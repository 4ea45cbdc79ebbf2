"""Unit quaternions w, x, y, z, in the plain arithmetic of control laws."""

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Quaternion, Vector3
from workbench.control.law_parts import arctan2

OPPOSITE_COSINE = 1e-5
"""Two directions with a smaller cosine of half their angle count as opposite."""
ALIGNED_SINE_SQUARED = 1e-16
"""A squared sine below this counts as no angle: no axis is needed."""


@register_jitable(forceinline=True)
def product(p: Quaternion, q: Quaternion) -> Quaternion:
    """Return the product of two quaternions, w first."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@register_jitable(forceinline=True)
def inverse(q: Quaternion) -> Quaternion:
    """Return the inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@register_jitable(forceinline=True)
def canonical(q: Quaternion) -> Quaternion:
    """Return the quaternion of the same turn whose w is not negative."""
    return (-q[0], -q[1], -q[2], -q[3]) if q[0] < 0.0 else q


@register_jitable(forceinline=True)
def normalized(q: Quaternion) -> Quaternion:
    """Return a quaternion of any length but zero, normalised."""
    size = q[0] * q[0] + q[1] * q[1]
    size = size + q[2] * q[2] + q[3] * q[3]
    scale = 1.0 / size**0.5
    return scale * q[0], scale * q[1], scale * q[2], scale * q[3]


@register_jitable(forceinline=True)
def shortest_turn(a: Vector3, b: Vector3) -> Quaternion:
    """Return the quaternion of the shortest turn from one unit vector to another."""
    dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    squared = 0.5 * (1.0 + dot)  # by rounding, it may be negative
    if squared < OPPOSITE_COSINE * OPPOSITE_COSINE:  # upside down, all turns are as short
        return 0.0 * dot, 1.0 + 0.0 * dot, 0.0 * dot, 0.0 * dot
    w = squared**0.5
    return (
        w,
        0.5 * (a[1] * b[2] - a[2] * b[1]) / w,
        0.5 * (a[2] * b[0] - a[0] * b[2]) / w,
        0.5 * (a[0] * b[1] - a[1] * b[0]) / w,
    )


@register_jitable(forceinline=True)
def upright(q: Quaternion) -> Vector3:
    """Return the z axis of a unit quaternion."""
    return (
        2.0 * (q[1] * q[3] + q[0] * q[2]),
        2.0 * (q[2] * q[3] - q[0] * q[1]),
        1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]),
    )


@register_jitable(forceinline=True)
def tilt_vector(n: Vector3) -> Vector3:
    """Return the turn from z to a unit vector: x and y of its axis times the angle, and the angle.

    Args:
        n: the vector.
    """
    squared = n[0] * n[0] + n[1] * n[1]
    if squared < ALIGNED_SINE_SQUARED and n[2] > 0.0:
        return -n[1], 1.0 * n[0], 0.0 * squared
    sine = (squared + 1e-30) ** 0.5
    angle = arctan2(sine, n[2])
    return -n[1] * angle / sine, n[0] * angle / sine, angle


@register_jitable(forceinline=True)
def small_turn(x: float, y: float, z: float) -> Quaternion:
    """Return the quaternion of a turn by a rotation vector of less than 1 rad."""
    s = 0.25 * (x * x + y * y + z * z)  # square of half the angle
    w = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0)))
    k = 0.5 * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0))))
    return w, k * x, k * y, k * z


@register_jitable(forceinline=True)
def rotated(q: Quaternion, v: Vector3) -> Vector3:
    """Return a vector turned by a unit quaternion."""
    w, x, y, z = q
    t_x = 2.0 * (y * v[2] - z * v[1])
    t_y = 2.0 * (z * v[0] - x * v[2])
    t_z = 2.0 * (x * v[1] - y * v[0])
    return (
        v[0] + w * t_x + y * t_z - z * t_y,
        v[1] + w * t_y + z * t_x - x * t_z,
        v[2] + w * t_z + x * t_y - y * t_x,
    )
