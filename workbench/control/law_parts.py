"""Functions that control laws share: tilt limit, attitude error, rigid-body moment, integrals.

They use only arithmetic, powers and comparisons, so the same source runs with floats, with
AutoDiffXd for exact linear models, and compiled by numba (`register_jitable` leaves functions
unchanged for Python, and lets numba call them). A vector is a sequence of three scalars.
"""

import math

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.control.guidance import Gains, tangent
from workbench.plant.gravity import GRAVITY

PI = math.pi
MIN_LIFT_ACCELERATION = 0.3 * GRAVITY
"""Smallest upward part of the specific force [m/s²]: no inverted flight."""


@register_jitable(forceinline=True)
def tilted(f_x: float, f_y: float, f_z: float, g: Gains) -> Vector3:
    """Return a specific force in W [m/s²] that points up, tilted by at most `g.max_tilt`."""
    if f_z < MIN_LIFT_ACCELERATION:
        f_z = MIN_LIFT_ACCELERATION
    level_squared = f_x * f_x + f_y * f_y
    level_max = tangent(g.max_tilt) * f_z
    if level_squared > level_max * level_max:
        shrink = level_max / level_squared**0.5
        f_x = f_x * shrink
        f_y = f_y * shrink
    return f_x, f_y, f_z


@register_jitable(forceinline=True)
def attitude_error(f: Vector3, w: Vector3, w_sp: Vector3) -> Vector3:
    """Return the errors of tilt [2 sin(angle / 2)] about x and y, and of the yaw rate [rad/s].

    The tilt error is the shortest rotation from z of T to f.

    Args:
        f: specific force, never zero, in T [m/s²].
        w: angular velocity in T [rad/s].
        w_sp: the one wanted [rad/s].
    """
    f_x, f_y, f_z = f
    length = (f_x * f_x + f_y * f_y + f_z * f_z) ** 0.5
    upright = 1.0 + f_z / length  # 2 when z points along the force, 0 when against it
    if upright < 1e-6:  # exactly upside down all tilt axes are equivalent: use roll
        e_x = 2.0
        e_y = 0.0
    else:
        scale = (2.0 / upright) ** 0.5 / length
        e_x = -scale * f_y
        e_y = scale * f_x
    return e_x, e_y, w_sp[2] - w[2]


@register_jitable(forceinline=True)
def arctan2(y: float, x: float) -> float:
    """Return the angle of the vector (x, y), -pi .. pi [rad]; 0 if both are 0.

    The angle is halved three times by tan(a / 2) = t / (1 + (1 + t²)^0.5). Twelve terms of the
    arctangent's series are then exact to rounding.
    """
    across = x if x > 0.0 else -x
    length = (x * x + y * y) ** 0.5
    if length == 0.0:
        return 0.0 * length
    t = y / (length + across)
    t = t / (1.0 + (1.0 + t * t) ** 0.5)
    t = t / (1.0 + (1.0 + t * t) ** 0.5)
    s = -t * t
    series = 1.0 / 23.0
    for place in range(10, -1, -1):
        series = 1.0 / (2 * place + 1) + s * series
    found = 8.0 * t * series
    if x < 0.0:
        found = (PI if y >= 0.0 else -PI) - found
    return found


@register_jitable(forceinline=True)
def cosine_sine(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle within ±2 pi [rad].

    Series at a sixteenth of the angle, then four doublings: exact to 1e-12.
    """
    a = angle / 16.0
    s = -a * a
    cos = 1.0 + s / 2.0 * (1.0 + s / 12.0 * (1.0 + s / 30.0 * (1.0 + s / 56.0 * (1.0 + s / 90.0))))
    sin = 1.0 + s / 6.0 * (1.0 + s / 20.0 * (1.0 + s / 42.0 * (1.0 + s / 72.0 * (1.0 + s / 110.0))))
    sin = a * sin
    for _ in range(4):
        cos, sin = cos * cos - sin * sin, 2.0 * sin * cos
    return cos, sin


@register_jitable(forceinline=True)
def clipped(x: float, most: float) -> float:
    """Return a number limited to -most .. most."""
    if x > most:
        return most
    if x < -most:
        return -most
    return x


@register_jitable(forceinline=True)
def between(x: float, least: float, most: float) -> float:
    """Return a number limited to least .. most."""
    if x < least:
        return least + 0.0 * x
    if x > most:
        return most + 0.0 * x
    return x


@register_jitable(forceinline=True)
def moment(alpha: Vector3, w: Vector3, inertia: Numbers) -> Vector3:
    """Return the moment I α + ω x I ω [N·m]."""
    xx, xy, xz, yy, yz, zz = inertia
    a_x, a_y, a_z = alpha
    w_x, w_y, w_z = w
    h_x = xx * w_x + xy * w_y + xz * w_z
    h_y = xy * w_x + yy * w_y + yz * w_z
    h_z = xz * w_x + yz * w_y + zz * w_z
    return (
        xx * a_x + xy * a_y + xz * a_z + w_y * h_z - w_z * h_y,
        xy * a_x + yy * a_y + yz * a_z + w_z * h_x - w_x * h_z,
        xz * a_x + yz * a_y + zz * a_z + w_x * h_y - w_y * h_x,
    )


@register_jitable(forceinline=True)
def difference(a: Vector3, b: Vector3) -> Vector3:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@register_jitable(forceinline=True)
def integrated(integral: float, slope: float, missing: float, tolerance: float, dt: float) -> float:
    """Return an integral after an update; it stops where growth would increase saturation.

    This is conditional integration: Åström and Hägglund, Advanced PID Control, 2006, section 3.5.

    Args:
        integral: its previous value.
        slope: its rate of change.
        missing: command minus what the vehicle did, with the sign of the integral.
        tolerance: of `missing` without saturation.
        dt: time since the previous update [s].
    """
    if (missing > tolerance and slope > 0.0) or (missing < -tolerance and slope < 0.0):
        return integral
    return integral + dt * slope
