"""The control law: velocity PD, attitude PD and yaw rate, as pure functions of scalars.

Written in components, with plain arithmetic, powers and comparisons only, so that one source
runs with floats, converts to AutoDiffXd for exact linear models, and compiles with numba
(`register_jitable` leaves the functions as they are for Python, and lets numba call them). Gains
are normalised by mass and inertia (they are 1/s or 1/s², not newtons), so that a set of gains
carries from one vehicle to another.

A vector is a sequence of three scalars, a rotation nine scalars row by row; the named tuples name
the places of longer ones, and any sequence of that order will do. Frames as in `plant`.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from numba.extending import register_jitable

from workbench.control.loop_points import (
    FORCE_X,
    FORCE_Y,
    FORCE_Z,
    PITCH,
    PITCH_ACCELERATION,
    POSITION_X,
    POSITION_Y,
    POSITION_Z,
    ROLL,
    ROLL_ACCELERATION,
    VELOCITY_X,
    VELOCITY_Y,
    VELOCITY_Z,
    YAW_ACCELERATION,
    YAW_RATE,
    passed,
)
from workbench.control.obstacle_brake import braked
from workbench.plant.gravity import GRAVITY

Scalar = Any
"""float, AutoDiffXd, or what numba makes of it."""
Vector = Any
"""A sequence of scalars: a list or tuple in Python, an array in compiled code."""

CEILING_RATE = 1.0
"""Below the largest height a drone climbs no faster than this times the way left [1/s]."""
NO_DRAG = (0.0, 0.0, 0.0)
BRAKING_SHARE = 0.5
"""From afar a wall is neared only as fast as this share of the largest level acceleration stops."""
LEAST_LIFT = 0.3 * GRAVITY
"""The wanted specific force never points below this much upwards [m/s²]: no flying on its back."""


class Gains(NamedTuple):
    """Gains and limits of the law; `workbench params` lists meaning, unit and range of each."""

    kp_position_xy: Scalar
    kp_position_z: Scalar
    kp_velocity_x: Scalar
    kp_velocity_y: Scalar
    kp_velocity_z: Scalar
    kd_velocity_x: Scalar
    kd_velocity_y: Scalar
    kd_velocity_z: Scalar
    kp_roll: Scalar
    kp_pitch: Scalar
    kd_roll: Scalar
    kd_pitch: Scalar
    kp_yaw_rate: Scalar
    max_speed: Scalar
    max_climb_rate: Scalar
    max_height: Scalar
    max_tilt: Scalar
    max_yaw_rate: Scalar
    spin_up_feedforward: Scalar = 0.0


LIMITS = Gains._fields.index("max_speed")
MAX_TILT = Gains._fields.index("max_tilt")
SPIN_UP = Gains._fields.index("spin_up_feedforward")


class Reference(NamedTuple):
    """What the pilot or a path asks for, in W [m/s, rad/s, m]; `follow` 1 means go to p."""

    v_x: Scalar
    v_y: Scalar
    v_z: Scalar
    yaw_rate: Scalar
    p_x: Scalar
    p_y: Scalar
    p_z: Scalar
    follow: Scalar


class Guidance(NamedTuple):
    """What the flight mode allows and adds; weights are 0 or 1.

    `motors` 0 stops the rotors; `lift` 0 lets them idle; `authority` 0 takes no reference;
    `climb` is the mode's own vertical velocity [m/s]; `hold_xy` and `hold_z` keep the point p [m]
    while the reference asks for nothing.

    `brake` [1/s] and the three walls limit the speed towards obstacles, see `obstacle_brake`; a
    brake of 0 sets no limit.
    """

    motors: Scalar
    lift: Scalar
    authority: Scalar
    climb: Scalar
    hold_xy: Scalar
    hold_z: Scalar
    p_x: Scalar
    p_y: Scalar
    p_z: Scalar
    brake: Scalar = 0.0
    first_x: Scalar = 0.0
    first_y: Scalar = 0.0
    first_z: Scalar = 0.0
    first_place: Scalar = 0.0
    second_x: Scalar = 0.0
    second_y: Scalar = 0.0
    second_z: Scalar = 0.0
    second_place: Scalar = 0.0
    third_x: Scalar = 0.0
    third_y: Scalar = 0.0
    third_z: Scalar = 0.0
    third_place: Scalar = 0.0


BRAKE = Guidance._fields.index("brake")
FIRST_WALL = BRAKE + 1


@register_jitable(forceinline=True)
def wanted_velocity(
    p_WB: Vector, reference: Vector, guidance: Vector, gains: Vector, loops: Vector
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return velocity (x, y, z) in W and yaw rate: the reference or the hold, within limits.

    Args:
        p_WB: position [m].
        reference: see `Reference`.
        guidance: see `Guidance`.
        gains: see `Gains`.
        loops: see `loop_points`.
    """
    x, y, z = p_WB
    v_x, v_y, v_z, yaw_rate, p_x, p_y, p_z, follow = reference
    _, _, authority, climb, hold_xy, hold_z, hold_x, hold_y, hold_height = guidance[0:BRAKE]
    kp_xy, kp_z = gains[0:2]
    v_max, climb_max, height_max, tilt, yaw_max = gains[LIMITS:SPIN_UP]
    if authority * (v_x * v_x + v_y * v_y + v_z * v_z + follow) > 0.0:
        # a pilot who steers is not pulled back while the mode has yet to notice
        hold_xy = 0.0
        hold_z = 0.0
    follow = authority * follow
    e_x = passed(follow * (p_x - x) + hold_xy * (hold_x - x), POSITION_X, loops)
    e_y = passed(follow * (p_y - y) + hold_xy * (hold_y - y), POSITION_Y, loops)
    e_z = passed(follow * (p_z - z) + hold_z * (hold_height - z), POSITION_Z, loops)
    v_x = authority * v_x + kp_xy * e_x
    v_y = authority * v_y + kp_xy * e_y
    v_z = authority * v_z + kp_z * e_z + climb
    yaw_rate = authority * yaw_rate

    speed_squared = v_x * v_x + v_y * v_y
    if speed_squared > v_max * v_max:
        shrink = v_max / speed_squared**0.5
        v_x = v_x * shrink
        v_y = v_y * shrink
    ceiling = CEILING_RATE * (height_max - z)
    if v_z > ceiling:
        v_z = ceiling
    if v_z > climb_max:
        v_z = climb_max
    if v_z < -climb_max:
        v_z = -climb_max
    if yaw_rate > yaw_max:
        yaw_rate = yaw_max
    if yaw_rate < -yaw_max:
        yaw_rate = -yaw_max
    if guidance[BRAKE] > 0.0:
        slowing = BRAKING_SHARE * GRAVITY * tangent(tilt)
        walls = guidance[FIRST_WALL:]
        v_x, v_y, v_z = braked(v_x, v_y, v_z, p_WB, guidance[BRAKE], walls, slowing)
    return v_x, v_y, v_z, yaw_rate


@register_jitable(forceinline=True)
def wanted_specific_force(
    v_WB: Vector,
    a_WB: Vector,
    wanted: Vector,
    gains: Vector,
    loops: Vector,
    drag: Vector = NO_DRAG,
) -> tuple[Scalar, Scalar, Scalar]:
    """Return force over mass [m/s²] in W, tilted no more than allowed.

    It is velocity PD plus gravity, and plus what drag takes, so that gains mean the same for a
    vehicle with much drag and for one without.

    Args:
        v_WB: velocity [m/s].
        a_WB: acceleration estimate for the derivative terms [m/s²].
        wanted: velocity [m/s] and yaw rate from `wanted_velocity`.
        gains: see `Gains`.
        loops: see `loop_points`.
        drag: what the air is thought to take, over mass, in W [m/s²].
    """
    v_x, v_y, v_z = v_WB
    a_x, a_y, a_z = a_WB
    wanted_x, wanted_y, wanted_z, _ = wanted
    kp_x, kp_y, kp_z, kd_x, kd_y, kd_z = gains[2:8]
    max_tilt = gains[MAX_TILT]
    e_x = passed(wanted_x - v_x, VELOCITY_X, loops)
    e_y = passed(wanted_y - v_y, VELOCITY_Y, loops)
    e_z = passed(wanted_z - v_z, VELOCITY_Z, loops)
    f_x = passed(kp_x * e_x - kd_x * a_x + drag[0], FORCE_X, loops)
    f_y = passed(kp_y * e_y - kd_y * a_y + drag[1], FORCE_Y, loops)
    f_z = passed(kp_z * e_z - kd_z * a_z + drag[2], FORCE_Z, loops) + GRAVITY
    if f_z < LEAST_LIFT:
        f_z = LEAST_LIFT
    level_squared = f_x * f_x + f_y * f_y
    level_max = tangent(max_tilt) * f_z
    if level_squared > level_max * level_max:
        shrink = level_max / level_squared**0.5
        f_x = f_x * shrink
        f_y = f_y * shrink
    return f_x, f_y, f_z


@register_jitable(forceinline=True)
def wanted_wrench(
    q_WB: Vector,
    w_WB_W: Vector,
    f_W: Vector,
    yaw_rate: Scalar,
    mass: float,
    inertia: Sequence[float],
    gains: Vector,
    loops: Vector,
    yaw_drag: Scalar = 0.0,
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the force along body z [N] and the moment about the centre of mass in B [N·m].

    The tilt error is the shortest rotation from body z to the wanted force, as axis times twice
    the sine of half its angle: it grows up to half a turn, so the law holds at any attitude.

    Args:
        q_WB: orientation, a quaternion w, x, y, z of any length but zero.
        w_WB_W: angular velocity in W [rad/s].
        f_W: wanted specific force in W [m/s²], never zero.
        yaw_rate: wanted turn about world z [rad/s].
        mass: all-up mass [kg].
        inertia: I_BBcm_B as xx, xy, xz, yy, yz, zz [kg·m²].
        gains: see `Gains`.
        loops: see `loop_points`.
        yaw_drag: angular acceleration that drag takes over the rate about body z [1/s].
    """
    w, x, y, z = q_WB
    s = 2.0 / (w * w + x * x + y * y + z * z)  # Drake's quaternions need not have unit length
    r00 = 1.0 - s * (y * y + z * z)
    r01 = s * (x * y - w * z)
    r02 = s * (x * z + w * y)
    r10 = s * (x * y + w * z)
    r11 = 1.0 - s * (x * x + z * z)
    r12 = s * (y * z - w * x)
    r20 = s * (x * z - w * y)
    r21 = s * (y * z + w * x)
    r22 = 1.0 - s * (x * x + y * y)
    w_Wx, w_Wy, w_Wz = w_WB_W
    w_x = r00 * w_Wx + r10 * w_Wy + r20 * w_Wz
    w_y = r01 * w_Wx + r11 * w_Wy + r21 * w_Wz
    w_z = r02 * w_Wx + r12 * w_Wy + r22 * w_Wz
    f_Wx, f_Wy, f_Wz = f_W
    f_x = r00 * f_Wx + r10 * f_Wy + r20 * f_Wz
    f_y = r01 * f_Wx + r11 * f_Wy + r21 * f_Wz
    f_z = r02 * f_Wx + r12 * f_Wy + r22 * f_Wz
    length = (f_x * f_x + f_y * f_y + f_z * f_z) ** 0.5

    upright = 1.0 + f_z / length  # 2 when body z points along the force, 0 when against it
    if upright < 1e-6:  # exactly upside down every tilt axis is as short: take roll
        e_x = 2.0
        e_y = 0.0
    else:
        scale = (2.0 / upright) ** 0.5 / length
        e_x = -scale * f_y
        e_y = scale * f_x

    kp_roll, kp_pitch, kd_roll, kd_pitch, kp_yaw = gains[8:LIMITS]
    e_x = passed(e_x, ROLL, loops)
    e_y = passed(e_y, PITCH, loops)
    e_z = passed(r22 * yaw_rate - w_z, YAW_RATE, loops)
    a_x = passed(kp_roll * e_x + kd_roll * (r20 * yaw_rate - w_x), ROLL_ACCELERATION, loops)
    a_y = passed(kp_pitch * e_y + kd_pitch * (r21 * yaw_rate - w_y), PITCH_ACCELERATION, loops)
    a_z = passed(kp_yaw * e_z + yaw_drag * w_z, YAW_ACCELERATION, loops)

    xx, xy, xz, yy, yz, zz = inertia
    h_x = xx * w_x + xy * w_y + xz * w_z
    h_y = xy * w_x + yy * w_y + yz * w_z
    h_z = xz * w_x + yz * w_y + zz * w_z
    m_x = xx * a_x + xy * a_y + xz * a_z + w_y * h_z - w_z * h_y
    m_y = xy * a_x + yy * a_y + yz * a_z + w_z * h_x - w_x * h_z
    m_z = xz * a_x + yz * a_y + zz * a_z + w_x * h_y - w_y * h_x
    return mass * f_z, m_x, m_y, m_z


@register_jitable(forceinline=True)
def tangent(angle: Scalar) -> Scalar:
    """Return tan(angle) within 1e-8 for |angle| <= 1.2 rad, by Lambert's continued fraction."""
    s = angle * angle
    return angle / (1.0 - s / (3.0 - s / (5.0 - s / (7.0 - s / (9.0 - s / (11.0 - s / 13.0))))))
