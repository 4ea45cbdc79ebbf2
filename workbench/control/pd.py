"""PD cascade: the law that the workbench flies, as pure functions of scalars.

With errors of the position p, the velocity v of the centre of mass, and the tilt, and gains by
name (x, y, z or roll, pitch, yaw by component):

    v_sp = kp_position (p_sp - p) + v_ref                    within limits, see `guidance`
    f    = kp_velocity (v_sp - v) - kd_velocity a + d + g    specific force in W [m/s²], within tilt
    α    = kp_tilt e_tilt + kd_tilt (ω_sp - ω)               roll and pitch [rad/s²]
    α_z  = kp_yaw_rate (ω_sp - ω) + drag_yaw ω               yaw
    m    = I α + ω x I ω                                     moment about the centre of mass [N·m]
    F    = mass f · z                                        force along the rotors' axis [N]

a is the estimated acceleration, d what drag of still air takes, ω_sp the yaw rate wanted about
world z, and e_tilt the shortest rotation from z to f, as its axis times 2 sin(angle / 2): it grows
up to half a turn, so the law holds at any attitude. Gains are normalised by mass and inertia (1/s
or 1/s², not newtons), so that a set of gains carries from one vehicle to another.

Plain arithmetic, powers and comparisons only, so that one source runs with floats, converts to
AutoDiffXd for exact linear models, and compiles with numba (`register_jitable` leaves functions as
they are for Python, and lets numba call them). A vector is a sequence of three scalars. Body here
means the frame T in which the rotors lift along z, see `plant.thrust_frame`.
"""

from typing import Any, NamedTuple

from numba.extending import register_jitable

from workbench.control.flight_state import attitude_matrix
from workbench.control.guidance import position_error, tangent, velocity_setpoint
from workbench.control.loop_points import (
    ACCELERATION,
    ANGULAR_ACCELERATION,
    ATTITUDE,
    POSITION,
    VELOCITY,
    probe,
)
from workbench.dynamics.rigid_body import into_body
from workbench.plant.gravity import GRAVITY

Scalar = Any
"""float, AutoDiffXd, or what numba makes of it."""
Vector = Any
"""A sequence of scalars: a list or tuple in Python, an array in compiled code."""

LEAST_LIFT = 0.3 * GRAVITY
"""The specific force never points below this much upwards [m/s²]: no flying on its back."""


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


class Body(NamedTuple):
    """What the law knows of the body: mass [kg], inertia xx, xy, xz, yy, yz, zz [kg·m²], in T.

    And what drag takes of the turn about z, as an angular acceleration over its rate [1/s].
    """

    mass: float
    inertia: Any
    yaw_drag: float


@register_jitable(forceinline=True)
def specific_force(
    p_WB: Vector,
    v_WBcm: Vector,
    a_WB: Vector,
    drag: Vector,
    reference: Vector,
    guidance: Vector,
    g: Gains,
    loops: Vector,
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return force over mass in W [m/s²], and the yaw rate [rad/s]: the outer loops.

    Args:
        p_WB: position in W [m].
        v_WBcm: velocity of the centre of mass in W [m/s].
        a_WB: its acceleration, estimated, in W [m/s²].
        drag: what the air is thought to take, over mass, in W [m/s²].
        reference: see `guidance.Reference`.
        guidance: see `guidance.Guidance`.
        g: gains.
        loops: where loops can be opened, see `loop_points`.
    """
    e = probe(position_error(p_WB, reference, guidance), POSITION, loops)
    v_x, v_y, v_z, yaw_rate = velocity_setpoint(position_p(e, g), p_WB, reference, guidance, g)
    e = probe(difference((v_x, v_y, v_z), v_WBcm), VELOCITY, loops)
    f_x, f_y, f_z = probe(velocity_pd(e, a_WB, drag, g), ACCELERATION, loops)
    f_x, f_y, f_z = tilted(f_x, f_y, f_z + GRAVITY, g)
    return f_x, f_y, f_z, yaw_rate


@register_jitable(forceinline=True)
def wrench(
    f_W: Vector,
    yaw_rate: Scalar,
    q_WT: Vector,
    w_WB: Vector,
    g: Gains,
    body: Body,
    loops: Vector,
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the force along z [N] and the moment about the centre of mass in T [N·m].

    Args:
        f_W: force over mass that is wanted, in W, never zero [m/s²].
        yaw_rate: wanted turn about world z [rad/s].
        q_WT: attitude, a quaternion w, x, y, z of any length but zero.
        w_WB: angular velocity in W [rad/s].
        g: gains.
        body: mass and inertia.
        loops: where loops can be opened, see `loop_points`.
    """
    R_WT = attitude_matrix(q_WT)
    f, w = into_body(R_WT, f_W), into_body(R_WT, w_WB)
    w_sp = (R_WT[6] * yaw_rate, R_WT[7] * yaw_rate, R_WT[8] * yaw_rate)
    e = probe(attitude_error(f, w, w_sp), ATTITUDE, loops)
    alpha = probe(attitude_pd(e, w, w_sp, body, g), ANGULAR_ACCELERATION, loops)
    m_x, m_y, m_z = moment(alpha, w, body.inertia)
    return body.mass * f[2], m_x, m_y, m_z


@register_jitable(forceinline=True)
def position_p(e: Vector, g: Gains) -> tuple[Scalar, Scalar, Scalar]:
    """Return the velocity that corrects an error of position e [m], in W [m/s]."""
    return g.kp_position_xy * e[0], g.kp_position_xy * e[1], g.kp_position_z * e[2]


@register_jitable(forceinline=True)
def velocity_pd(e: Vector, a: Vector, drag: Vector, g: Gains) -> tuple[Scalar, Scalar, Scalar]:
    """Return specific force without gravity, in W [m/s²], for an error of velocity e [m/s].

    What drag takes is added, so that gains mean the same for a vehicle with much drag and for one
    without.
    """
    return (
        g.kp_velocity_x * e[0] - g.kd_velocity_x * a[0] + drag[0],
        g.kp_velocity_y * e[1] - g.kd_velocity_y * a[1] + drag[1],
        g.kp_velocity_z * e[2] - g.kd_velocity_z * a[2] + drag[2],
    )


@register_jitable(forceinline=True)
def tilted(f_x: Scalar, f_y: Scalar, f_z: Scalar, g: Gains) -> tuple[Scalar, Scalar, Scalar]:
    """Return a specific force in W [m/s²] that points up, tilted no more than allowed."""
    if f_z < LEAST_LIFT:
        f_z = LEAST_LIFT
    level_squared = f_x * f_x + f_y * f_y
    level_max = tangent(g.max_tilt) * f_z
    if level_squared > level_max * level_max:
        shrink = level_max / level_squared**0.5
        f_x = f_x * shrink
        f_y = f_y * shrink
    return f_x, f_y, f_z


@register_jitable(forceinline=True)
def attitude_error(f: Vector, w: Vector, w_sp: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return the errors of tilt [2 sin(angle / 2)] about x and y, and of the yaw rate [rad/s].

    Args:
        f: specific force, never zero, in T [m/s²].
        w: angular velocity in T [rad/s].
        w_sp: the one wanted [rad/s].
    """
    f_x, f_y, f_z = f
    length = (f_x * f_x + f_y * f_y + f_z * f_z) ** 0.5
    upright = 1.0 + f_z / length  # 2 when z points along the force, 0 when against it
    if upright < 1e-6:  # exactly upside down every tilt axis is as short: take roll
        e_x = 2.0
        e_y = 0.0
    else:
        scale = (2.0 / upright) ** 0.5 / length
        e_x = -scale * f_y
        e_y = scale * f_x
    return e_x, e_y, w_sp[2] - w[2]


@register_jitable(forceinline=True)
def attitude_pd(
    e: Vector, w: Vector, w_sp: Vector, body: Body, g: Gains
) -> tuple[Scalar, Scalar, Scalar]:
    """Return angular acceleration in T [rad/s²] for errors e of roll, pitch and yaw rate."""
    return (
        g.kp_roll * e[0] + g.kd_roll * (w_sp[0] - w[0]),
        g.kp_pitch * e[1] + g.kd_pitch * (w_sp[1] - w[1]),
        g.kp_yaw_rate * e[2] + body.yaw_drag * w[2],
    )


@register_jitable(forceinline=True)
def moment(alpha: Vector, w: Vector, inertia: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return I α + ω x I ω [N·m]."""
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
def difference(a: Vector, b: Vector) -> tuple[Scalar, Scalar, Scalar]:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
