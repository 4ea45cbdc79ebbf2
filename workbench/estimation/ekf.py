"""An error-state extended Kalman filter on IMU, GPS, barometer, magnetometer and range finder.

The nominal state x is the attitude q_WB, place p and velocity v of the IMU in W, and the biases b_g
and b_a of gyro and accelerometer. The error dx (15) is d_theta in B, with R_true = R exp(d_theta),
and the differences of p, v, b_g and b_a. With w = w_IMU - b_g and f = f_IMU - b_a, means of a
period dt, and R_m the attitude in its middle:

    q+ = q exp(w dt)      a = R_m f - g e_z
    v+ = v + a dt         p+ = p + v dt + a dt² / 2

    P+ = F P F' + Q       F = d(dx+) / d(dx), exact to the fifth power of w dt

A measurement y = h(x) + noise of variance r is a row H: with s = H P H' + r and K = P H' / s,

    dx = dx + K (y - h(x) - H dx)      P = P - K s K'

one number after the other, which is the same as all at once where their noises are independent.
One whose innovation is beyond the gate is left out. A sample of the GPS that is T old is held
against the motion T ago: that of the same equations, with the last means of the IMU, over -T.

Source: J. Solà, Quaternion kinematics for the error-state Kalman filter, arXiv:1711.02508, 2017:
sections 5.3 (local error), 5.4.3 and 6.1.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.dynamics.rigid_body import into_body, rotation
from workbench.estimation.samples import BAROMETER, GPS, IMU, MAGNETOMETER, RANGE_FINDER
from workbench.plant.gravity import GRAVITY

Scalar = Any
Signal = Any
"""A sequence of scalars: a list in Python, an array in compiled code."""
Three = tuple[Scalar, ...]
Block = tuple[Scalar, ...]
Error = tuple[Scalar, ...]
"""A vector (3), a matrix of 3 x 3 row by row (9), errors (15)."""
NONE, EAST, NORTH, UP = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
EXACT = (0.0,) * 15

ERRORS, NOMINAL, CHANNELS = 15, 16, 10
"""Sizes of the error and of the nominal state, and numbers that are measured: place and velocity
of the antenna (6), height, heading, distance, and one place to spare."""
NAMES = (
    "gps_x",
    "gps_y",
    "gps_z",
    "gps_v_x",
    "gps_v_y",
    "gps_v_z",
    "barometer",
    "magnetometer",
    "range_finder",
)
"""Of the numbers that are measured."""
HEIGHT, HEADING, DISTANCE = 6, 7, 8
"""Places of those behind the GPS's."""
COVARIANCE = NOMINAL
INNOVATIONS = COVARIANCE + ERRORS * ERRORS
SIZE = INNOVATIONS + 2 * CHANNELS
"""Places in the memory: x (16), P row by row (225), and of each number that was measured in this
update the innovation and its variance, NaN where there was none; and its size."""
LEAST_LOOK = 0.5
"""A range finder whose beam is farther from straight down than this cosine measures no height."""


class InitialDeviations(NamedTuple):
    """How far the estimate may be off at the start: standard deviations of its errors.

    The defaults are what the shipped drone's sensors settle to within a minute.
    """

    attitude: float = 0.001
    position: float = 0.05
    velocity: float = 0.01
    gyro_bias: float = 1e-4
    accel_bias: float = 0.005


@register_jitable(forceinline=True)
def turned_by(q: Signal, turn: Signal) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the unit quaternion q exp(turn), for a turn in B (3) [rad] of less than a few."""
    w, x, y, z = q
    t_x, t_y, t_z = turn
    s = 0.25 * (t_x * t_x + t_y * t_y + t_z * t_z)
    c = 1.0 - s * (0.5 - s * (1.0 / 24.0 - s / 720.0))
    h = 0.5 * (1.0 - s * (1.0 / 6.0 - s * (1.0 / 120.0 - s / 5040.0)))
    e_x, e_y, e_z = h * t_x, h * t_y, h * t_z
    a = w * c - x * e_x - y * e_y - z * e_z
    b = w * e_x + x * c + y * e_z - z * e_y
    d = w * e_y - x * e_z + y * c + z * e_x
    e = w * e_z + x * e_y - y * e_x + z * c
    shrink = 1.0 / (a * a + b * b + d * d + e * e) ** 0.5
    return a * shrink, b * shrink, d * shrink, e * shrink


@register_jitable(forceinline=True)
def crossed(a: Signal, b: Signal) -> tuple[Scalar, Scalar, Scalar]:
    """Return the cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@register_jitable(forceinline=True)
def into_world(R_WB: Signal, a_B: Signal) -> tuple[Scalar, Scalar, Scalar]:
    """Return a vector of B in W."""
    x, y, z = a_B
    return (
        R_WB[0] * x + R_WB[1] * y + R_WB[2] * z,
        R_WB[3] * x + R_WB[4] * y + R_WB[5] * z,
        R_WB[6] * x + R_WB[7] * y + R_WB[8] * z,
    )


@register_jitable
def propagated(x: Signal, imu: Signal, dt: Scalar) -> tuple[Scalar, ...]:
    """Return the nominal state (16) after a period.

    Args:
        x: before it (16).
        imu: mean angular velocity and specific force in B (6).
        dt: the period [s].
    """
    w = (imu[0] - x[10], imu[1] - x[11], imu[2] - x[12])
    f = (imu[3] - x[13], imu[4] - x[14], imu[5] - x[15])
    half = 0.5 * dt
    q = (x[0], x[1], x[2], x[3])
    R = rotation(turned_by(q, (half * w[0], half * w[1], half * w[2])))
    a_x, a_y, a_z = into_world(R, f)
    a_z = a_z - GRAVITY
    q_w, q_x, q_y, q_z = turned_by(q, (dt * w[0], dt * w[1], dt * w[2]))
    return (
        q_w,
        q_x,
        q_y,
        q_z,
        x[4] + dt * (x[7] + half * a_x),
        x[5] + dt * (x[8] + half * a_y),
        x[6] + dt * (x[9] + half * a_z),
        x[7] + dt * a_x,
        x[8] + dt * a_y,
        x[9] + dt * a_z,
        x[10],
        x[11],
        x[12],
        x[13],
        x[14],
        x[15],
    )


@register_jitable
def corrected(x: Signal, error: Signal) -> tuple[Scalar, ...]:
    """Return the nominal state (16) with an error (15) taken into it."""
    q_w, q_x, q_y, q_z = turned_by((x[0], x[1], x[2], x[3]), (error[0], error[1], error[2]))
    return (
        q_w,
        q_x,
        q_y,
        q_z,
        x[4] + error[3],
        x[5] + error[4],
        x[6] + error[5],
        x[7] + error[6],
        x[8] + error[7],
        x[9] + error[8],
        x[10] + error[9],
        x[11] + error[10],
        x[12] + error[11],
        x[13] + error[12],
        x[14] + error[13],
        x[15] + error[14],
    )


@register_jitable
def estimate(x: Signal, imu: Signal, p_BI: Signal) -> tuple[Scalar, ...]:
    """Return the motion of the base origin (13): q_WB, p_WB, w_WB_B [rad/s], v_WB_W.

    Args:
        x: nominal state (16).
        imu: angular velocity in B, first of it (3).
        p_BI: of the IMU (3) [m].
    """
    R = rotation((x[0], x[1], x[2], x[3]))
    w = (imu[0] - x[10], imu[1] - x[11], imu[2] - x[12])
    l_x, l_y, l_z = into_world(R, p_BI)
    u_x, u_y, u_z = into_world(R, crossed(w, p_BI))
    return (
        x[0],
        x[1],
        x[2],
        x[3],
        x[4] - l_x,
        x[5] - l_y,
        x[6] - l_z,
        w[0],
        w[1],
        w[2],
        x[7] - u_x,
        x[8] - u_y,
        x[9] - u_z,
    )


class Transition(NamedTuple):
    """F in blocks of 3 x 3, row by row (9): errors after a period by those before it.

    The rows of the place follow from these: p+ = p + dt / 2 (v + v+), as v grows steadily. An error
    of attitude, place, velocity, gyro and accelerometer is t, p, v, g and a; the biases stay.
    """

    tt: Block
    tg: Block
    vt: Block
    vg: Block
    va: Block


class Covariance(NamedTuple):
    """P in blocks of 3 x 3, row by row (9), named as in `Transition`: the upper ones."""

    tt: Block
    tp: Block
    tv: Block
    tg: Block
    ta: Block
    pp: Block
    pv: Block
    pg: Block
    pa: Block
    vv: Block
    vg: Block
    va: Block
    gg: Block
    ga: Block
    aa: Block


@register_jitable(forceinline=True)
def _plus(A: Block, B: Block) -> Block:
    """Return A + B."""
    return (
        A[0] + B[0],
        A[1] + B[1],
        A[2] + B[2],
        A[3] + B[3],
        A[4] + B[4],
        A[5] + B[5],
        A[6] + B[6],
        A[7] + B[7],
        A[8] + B[8],
    )


@register_jitable(forceinline=True)
def _scaled(s: Scalar, A: Block) -> Block:
    """Return s A."""
    return (
        s * A[0],
        s * A[1],
        s * A[2],
        s * A[3],
        s * A[4],
        s * A[5],
        s * A[6],
        s * A[7],
        s * A[8],
    )


@register_jitable(forceinline=True)
def _turned(A: Block) -> Block:
    """Return A'."""
    return A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]


@register_jitable(forceinline=True)
def _even(A: Block) -> Block:
    """Return the symmetric block with A's upper triangle: halves would differ more and more."""
    return A[0], A[1], A[2], A[1], A[4], A[5], A[2], A[5], A[8]


@register_jitable(forceinline=True)
def _times(A: Block, B: Block) -> Block:
    """Return A B."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


@register_jitable(forceinline=True)
def _outer(a: Three, b: Three, s: Scalar) -> Block:
    """Return s a b'."""
    x, y, z = s * a[0], s * a[1], s * a[2]
    return (
        x * b[0],
        x * b[1],
        x * b[2],
        y * b[0],
        y * b[1],
        y * b[2],
        z * b[0],
        z * b[1],
        z * b[2],
    )


@register_jitable(forceinline=True)
def _with(A: Block, d: Scalar) -> Block:
    """Return A + d I."""
    return A[0] + d, A[1], A[2], A[3], A[4] + d, A[5], A[6], A[7], A[8] + d


@register_jitable(forceinline=True)
def transition(x: Signal, imu: Signal, dt: Scalar) -> Transition:
    """Return the errors of attitude and velocity after a period by all before it.

    Args:
        x: nominal state before it (16).
        imu: mean angular velocity and specific force in B (6).
        dt: the period [s].
    """
    w = (imu[0] - x[10], imu[1] - x[11], imu[2] - x[12])
    f = (imu[3] - x[13], imu[4] - x[14], imu[5] - x[15])
    whole = (dt * w[0], dt * w[1], dt * w[2])
    half = (0.5 * whole[0], 0.5 * whole[1], 0.5 * whole[2])
    one = (1.0, 0.0, 0.0, 0.0)
    R = rotation(turned_by((x[0], x[1], x[2], x[3]), half))
    # - R_m [f x], row by row
    pull = (
        crossed(f, (R[0], R[1], R[2]))
        + crossed(f, (R[3], R[4], R[5]))
        + crossed(f, (R[6], R[7], R[8]))
    )
    by_angle = _times(pull, _turned(rotation(turned_by(one, half))))
    by_bias = _times(pull, _right_jacobian(half))
    return Transition(
        tt=_turned(rotation(turned_by(one, whole))),
        tg=_scaled(-dt, _right_jacobian(whole)),
        vt=_scaled(dt, by_angle),
        vg=_scaled(-0.5 * dt * dt, by_bias),
        va=_scaled(-dt, R),
    )


@register_jitable(forceinline=True)
def _right_jacobian(turn: Three) -> Block:
    """Return J_r(turn), the error at the end of a turn by that of the turn; Solà, equation 183."""
    x, y, z = turn
    s = x * x + y * y + z * z
    a = 0.5 - s * (1.0 / 24.0 - s / 720.0)
    b = 1.0 / 6.0 - s * (1.0 / 120.0 - s / 5040.0)
    return (
        1.0 + b * (x * x - s),
        a * z + b * x * y,
        -a * y + b * x * z,
        -a * z + b * x * y,
        1.0 + b * (y * y - s),
        a * x + b * y * z,
        a * y + b * x * z,
        -a * x + b * y * z,
        1.0 + b * (z * z - s),
    )


@register_jitable(forceinline=True)
def spread(P: Covariance, F: Transition, settings: Signal, dt: Scalar) -> Covariance:
    """Return F P F' + Q, by T = F P.

    Args:
        P: covariance of the errors.
        F: of the period.
        settings: see `settings.EkfSettings`.
        dt: the period [s].
    """
    h = 0.5 * dt
    T_tt = _plus(_times(F.tt, P.tt), _times(F.tg, _turned(P.tg)))
    T_tp = _plus(_times(F.tt, P.tp), _times(F.tg, _turned(P.pg)))
    T_tv = _plus(_times(F.tt, P.tv), _times(F.tg, _turned(P.vg)))
    T_tg = _plus(_times(F.tt, P.tg), _times(F.tg, P.gg))
    T_ta = _plus(_times(F.tt, P.ta), _times(F.tg, P.ga))
    T_vt = _gone(F, P.tt, _turned(P.tv), _turned(P.tg), _turned(P.ta))
    T_vp = _gone(F, P.tp, _turned(P.pv), _turned(P.pg), _turned(P.pa))
    T_vv = _gone(F, P.tv, P.vv, _turned(P.vg), _turned(P.va))
    T_vg = _gone(F, P.tg, P.vg, P.gg, _turned(P.ga))
    T_va = _gone(F, P.ta, P.va, P.ga, P.aa)
    T_pt = _plus(_turned(P.tp), _scaled(h, _plus(_turned(P.tv), T_vt)))
    T_pp = _plus(P.pp, _scaled(h, _plus(_turned(P.pv), T_vp)))
    T_pv = _plus(P.pv, _scaled(h, _plus(P.vv, T_vv)))
    T_pg = _plus(P.pg, _scaled(h, _plus(P.vg, T_vg)))
    T_pa = _plus(P.pa, _scaled(h, _plus(P.va, T_va)))
    tt = _plus(_times(T_tt, _turned(F.tt)), _times(T_tg, _turned(F.tg)))
    tv = _back(F, T_tt, T_tv, T_tg, T_ta)
    vv = _back(F, T_vt, T_vv, T_vg, T_va)
    pv = _back(F, T_pt, T_pv, T_pg, T_pa)
    gyro, accel = settings[0] * settings[0] * dt, settings[1] * settings[1] * dt
    return Covariance(
        tt=_with(_even(tt), gyro),
        tp=_plus(T_tp, _scaled(h, _plus(T_tv, tv))),
        tv=tv,
        tg=T_tg,
        ta=T_ta,
        pp=_with(_even(_plus(T_pp, _scaled(h, _plus(T_pv, pv)))), accel * dt * dt / 3.0),
        pv=_with(pv, 0.5 * accel * dt),
        pg=T_pg,
        pa=T_pa,
        vv=_with(_even(vv), accel),
        vg=T_vg,
        va=T_va,
        gg=_with(P.gg, settings[2] * settings[2] * dt),
        ga=P.ga,
        aa=_with(P.aa, settings[3] * settings[3] * dt),
    )


@register_jitable(forceinline=True)
def _gone(F: Transition, P_t: Block, P_v: Block, P_g: Block, P_a: Block) -> Block:
    """Return a block of F's row of the velocity times a column of P."""
    T = _plus(_times(F.vt, P_t), P_v)
    return _plus(T, _plus(_times(F.vg, P_g), _times(F.va, P_a)))


@register_jitable(forceinline=True)
def _back(F: Transition, T_t: Block, T_v: Block, T_g: Block, T_a: Block) -> Block:
    """Return a row of T times the column of F' of the velocity."""
    P = _plus(_times(T_t, _turned(F.vt)), T_v)
    return _plus(P, _plus(_times(T_g, _turned(F.vg)), _times(T_a, _turned(F.va))))


class Measured(NamedTuple):
    """A measured number y = h(x) + noise.

    Attributes:
        t, p, v, g, a: H (3 each), the derivative of h by each error.
        gap: y - h(x), NaN of what was not measured.
        variance: of the noise.
    """

    t: Three
    p: Three
    v: Three
    g: Three
    a: Three
    gap: Scalar
    variance: Scalar


class Fused(NamedTuple):
    """What is known once a number was taken in.

    Attributes:
        P: covariance.
        error: so far (15).
        innovation: y - h(x) - H dx before it.
        s: its variance.
    """

    P: Covariance
    error: Error
    innovation: Scalar
    s: Scalar


@register_jitable(forceinline=True)
def _along(a: Three, b: Three) -> Scalar:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@register_jitable(forceinline=True)
def _sum(a: Three, b: Three, c: Three, d: Three, e: Three) -> Three:
    """Return the sum of five vectors."""
    return (
        a[0] + b[0] + c[0] + d[0] + e[0],
        a[1] + b[1] + c[1] + d[1] + e[1],
        a[2] + b[2] + c[2] + d[2] + e[2],
    )


@register_jitable(forceinline=True)
def fused(P: Covariance, error: Error, m: Measured, gate: Scalar) -> Fused:
    """Take a measured number in; what is beyond the gate, or none, changes nothing.

    Args:
        P: covariance.
        error: so far (15).
        m: the number.
        gate: it is left out beyond so many deviations.
    """
    t, p, v, g, a = m.t, m.p, m.v, m.g, m.a
    k_t = _sum(
        into_world(P.tt, t),
        into_world(P.tp, p),
        into_world(P.tv, v),
        into_world(P.tg, g),
        into_world(P.ta, a),
    )
    k_p = _sum(
        into_body(P.tp, t),
        into_world(P.pp, p),
        into_world(P.pv, v),
        into_world(P.pg, g),
        into_world(P.pa, a),
    )
    k_v = _sum(
        into_body(P.tv, t),
        into_body(P.pv, p),
        into_world(P.vv, v),
        into_world(P.vg, g),
        into_world(P.va, a),
    )
    k_g = _sum(
        into_body(P.tg, t),
        into_body(P.pg, p),
        into_body(P.vg, v),
        into_world(P.gg, g),
        into_world(P.ga, a),
    )
    k_a = _sum(
        into_body(P.ta, t),
        into_body(P.pa, p),
        into_body(P.va, v),
        into_body(P.ga, g),
        into_world(P.aa, a),
    )
    s = _along(t, k_t) + _along(p, k_p) + _along(v, k_v) + _along(g, k_g) + _along(a, k_a)
    s = s + m.variance
    e_t, e_p, e_v = error[0:3], error[3:6], error[6:9]
    e_g, e_a = error[9:12], error[12:15]
    told = _along(t, e_t) + _along(p, e_p) + _along(v, e_v) + _along(g, e_g) + _along(a, e_a)
    innovation = m.gap - told
    counts = innovation * innovation <= gate * gate * s  # false of NaN
    share = -1.0 / s if counts else 0.0
    step = innovation / s if counts else 0.0
    known = Covariance(
        tt=_plus(P.tt, _outer(k_t, k_t, share)),
        tp=_plus(P.tp, _outer(k_t, k_p, share)),
        tv=_plus(P.tv, _outer(k_t, k_v, share)),
        tg=_plus(P.tg, _outer(k_t, k_g, share)),
        ta=_plus(P.ta, _outer(k_t, k_a, share)),
        pp=_plus(P.pp, _outer(k_p, k_p, share)),
        pv=_plus(P.pv, _outer(k_p, k_v, share)),
        pg=_plus(P.pg, _outer(k_p, k_g, share)),
        pa=_plus(P.pa, _outer(k_p, k_a, share)),
        vv=_plus(P.vv, _outer(k_v, k_v, share)),
        vg=_plus(P.vg, _outer(k_v, k_g, share)),
        va=_plus(P.va, _outer(k_v, k_a, share)),
        gg=_plus(P.gg, _outer(k_g, k_g, share)),
        ga=_plus(P.ga, _outer(k_g, k_a, share)),
        aa=_plus(P.aa, _outer(k_a, k_a, share)),
    )
    after = (
        _moved(e_t, k_t, step)
        + _moved(e_p, k_p, step)
        + _moved(e_v, k_v, step)
        + _moved(e_g, k_g, step)
        + _moved(e_a, k_a, step)
    )
    return Fused(known, after, innovation, s)


@register_jitable(forceinline=True)
def _moved(e: Three, k: Three, step: Scalar) -> Three:
    return e[0] + step * k[0], e[1] + step * k[1], e[2] + step * k[2]


@register_jitable(forceinline=True)
def _lever(p: Signal, p_BI: Signal) -> Three:
    return p[0] - p_BI[0], p[1] - p_BI[1], p[2] - p_BI[2]


@register_jitable(forceinline=True)
def measured_height(x: Signal, z: Signal, mounting: Signal, settings: Signal) -> Measured:
    """Return what the barometer measures.

    Args:
        x: nominal state (16).
        z: see `samples`.
        mounting: see `samples.Mounting.packed`.
        settings: see `settings.EkfSettings`.
    """
    R = rotation((x[0], x[1], x[2], x[3]))
    arm = _lever(mounting[6:9], mounting[0:3])
    return Measured(
        t=crossed(arm, (R[6], R[7], R[8])),
        p=UP,
        v=NONE,
        g=NONE,
        a=NONE,
        gap=z[BAROMETER + 1] - (x[6] + into_world(R, arm)[2]),
        variance=settings[7] * settings[7],
    )


@register_jitable(forceinline=True)
def measured_heading(x: Signal, z: Signal, mounting: Signal, settings: Signal) -> Measured:
    """Return what the magnetometer measures; the arguments are those of `measured_height`."""
    R = rotation((x[0], x[1], x[2], x[3]))
    m_x, m_y, m_z = mounting[15], mounting[16], mounting[17]
    level = m_x * m_x + m_y * m_y
    k = (z[MAGNETOMETER + 1], z[MAGNETOMETER + 2], z[MAGNETOMETER + 3])
    n_x, n_y, _ = into_world(R, k)
    # a wrong tilt turns the horizontal part of a field that dips; taken of the known field, as
    # the measured one's noise would come into H, and seem to tell of the tilt
    about = into_body(R, (-m_z * m_x / level, -m_z * m_y / level, 1.0))
    return Measured(
        t=about,
        p=NONE,
        v=NONE,
        g=NONE,
        a=NONE,
        gap=math.atan2(n_x * m_y - n_y * m_x, n_x * m_x + n_y * m_y),
        variance=settings[8] * settings[8] / level,
    )


@register_jitable(forceinline=True)
def measured_distance(x: Signal, z: Signal, mounting: Signal, settings: Signal) -> Measured:
    """Return what the range finder measures; the arguments are those of `measured_height`."""
    R = rotation((x[0], x[1], x[2], x[3]))
    up = (R[6], R[7], R[8])
    arm = _lever(mounting[9:12], mounting[0:3])
    n = (mounting[12], mounting[13], mounting[14])
    down = -into_world(R, n)[2]
    height = x[6] + into_world(R, arm)[2]
    by_place, by_view = crossed(arm, up), crossed(n, up)
    tilt = height / (down * down)
    return Measured(
        t=(
            by_place[0] / down + tilt * by_view[0],
            by_place[1] / down + tilt * by_view[1],
            by_place[2] / down + tilt * by_view[2],
        ),
        p=(0.0, 0.0, 1.0 / down),
        v=NONE,
        g=NONE,
        a=NONE,
        gap=z[RANGE_FINDER + 1] - height / down if down > LEAST_LOOK else math.nan,
        variance=settings[9] * settings[9],
    )


@register_jitable(forceinline=True)
def measured_motion(
    x: Signal, z: Signal, mounting: Signal, settings: Signal
) -> tuple[Measured, Measured, Measured, Measured, Measured, Measured]:
    """Return the place and velocity that the GPS measures; the arguments are those before.

    A sample is held against the motion at its own time: x, carried back over its age.
    """
    back = -z[GPS + 1]
    imu = (z[0], z[1], z[2], z[3], z[4], z[5])
    F = transition(x, imu, back)
    then = propagated(x, imu, back)
    R = rotation((then[0], then[1], then[2], then[3]))
    arm = _lever(mounting[3:6], mounting[0:3])
    turn = crossed((z[0] - x[10], z[1] - x[11], z[2] - x[12]), arm)
    y, v = into_world(R, arm), into_world(R, turn)
    east, north, up = (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
    level, height, speed = settings[4], settings[5], settings[6]
    return (
        _placed(
            F,
            F.vt[0:3],
            F.vg[0:3],
            F.va[0:3],
            east,
            arm,
            EAST,
            back,
            z[GPS + 2] - then[4] - y[0],
            level,
        ),
        _placed(
            F,
            F.vt[3:6],
            F.vg[3:6],
            F.va[3:6],
            north,
            arm,
            NORTH,
            back,
            z[GPS + 3] - then[5] - y[1],
            level,
        ),
        _placed(
            F,
            F.vt[6:9],
            F.vg[6:9],
            F.va[6:9],
            up,
            arm,
            UP,
            back,
            z[GPS + 4] - then[6] - y[2],
            height,
        ),
        _driven(
            F,
            F.vt[0:3],
            F.vg[0:3],
            F.va[0:3],
            east,
            arm,
            turn,
            EAST,
            z[GPS + 5] - then[7] - v[0],
            speed,
        ),
        _driven(
            F,
            F.vt[3:6],
            F.vg[3:6],
            F.va[3:6],
            north,
            arm,
            turn,
            NORTH,
            z[GPS + 6] - then[8] - v[1],
            speed,
        ),
        _driven(
            F,
            F.vt[6:9],
            F.vg[6:9],
            F.va[6:9],
            up,
            arm,
            turn,
            UP,
            z[GPS + 7] - then[9] - v[2],
            speed,
        ),
    )


@register_jitable(forceinline=True)
def _placed(
    F: Transition,
    vt: Three,
    vg: Three,
    va: Three,
    r: Three,
    arm: Three,
    axis: Three,
    back: Scalar,
    gap: Scalar,
    deviation: Scalar,
) -> Measured:
    """Return a coordinate of the antenna's place, along a row r of its R_WB."""
    by_turn = crossed(arm, r)
    h = 0.5 * back
    return Measured(
        t=_moved(into_body(F.tt, by_turn), vt, h),
        p=axis,
        v=(back * axis[0], back * axis[1], back * axis[2]),
        g=_moved(into_body(F.tg, by_turn), vg, h),
        a=(h * va[0], h * va[1], h * va[2]),
        gap=gap,
        variance=deviation * deviation,
    )


@register_jitable(forceinline=True)
def _driven(
    F: Transition,
    vt: Three,
    vg: Three,
    va: Three,
    r: Three,
    arm: Three,
    turn: Three,
    axis: Three,
    gap: Scalar,
    deviation: Scalar,
) -> Measured:
    """Return a coordinate of the antenna's velocity, along a row r of its R_WB."""
    by_turn = crossed(turn, r)
    return Measured(
        t=_moved(into_body(F.tt, by_turn), vt, 1.0),
        p=NONE,
        v=axis,
        g=_moved(_moved(into_body(F.tg, by_turn), vg, 1.0), crossed(r, arm), 1.0),
        a=va,
        gap=gap,
        variance=deviation * deviation,
    )


def rows_of(
    x: Signal, z: Signal, mounting: Signal, settings: Signal, rows: np.ndarray, gaps: np.ndarray
) -> None:
    """Write H (10, 15) of every number that a new sample measures, its y - h(x) and its variance.

    Args:
        x: nominal state (16).
        z: see `samples`.
        mounting: see `samples.Mounting.packed`.
        settings: see `settings.EkfSettings`.
        rows: places for H; zero where there is no new sample.
        gaps: places for y - h(x) and variance (10, 2); NaN where there is no new sample.
    """
    rows[:, :] = 0.0
    gaps[:, :] = math.nan
    found: list[tuple[int, Measured]] = []
    if z[GPS] > 0.0:
        found += enumerate(measured_motion(x, z, mounting, settings))
    if z[BAROMETER] > 0.0:
        found.append((HEIGHT, measured_height(x, z, mounting, settings)))
    if z[MAGNETOMETER] > 0.0:
        found.append((HEADING, measured_heading(x, z, mounting, settings)))
    if z[RANGE_FINDER] > 0.0:
        found.append((DISTANCE, measured_distance(x, z, mounting, settings)))
    for channel, m in found:
        if not math.isnan(m.gap):
            rows[channel] = m.t + m.p + m.v + m.g + m.a
            gaps[channel] = m.gap, m.variance


def transition_rows(F: Transition, dt: float) -> np.ndarray:
    """Return errors of attitude, place and velocity after a period by all before it (9, 15)."""
    found, one = np.zeros((9, ERRORS)), np.eye(3)
    tt, tg, vt, vg, va = (np.reshape(block, (3, 3)) for block in F)
    found[0:3, 0:3], found[0:3, 9:12] = tt, tg
    found[6:9, 0:3], found[6:9, 6:9], found[6:9, 9:12], found[6:9, 12:15] = vt, one, vg, va
    found[3:6] = 0.5 * dt * found[6:9]
    found[3:6, 3:6], found[3:6, 6:9] = one, dt * one
    return found


@register_jitable
def _block(P: np.ndarray, row: int, column: int) -> Block:
    """Return a block of a matrix, from a row and a column on."""
    return (
        P[row, column],
        P[row, column + 1],
        P[row, column + 2],
        P[row + 1, column],
        P[row + 1, column + 1],
        P[row + 1, column + 2],
        P[row + 2, column],
        P[row + 2, column + 1],
        P[row + 2, column + 2],
    )


@register_jitable
def blocks_of(P: np.ndarray) -> Covariance:
    """Return a covariance (15, 15) in blocks."""
    return Covariance(
        _block(P, 0, 0),
        _block(P, 0, 3),
        _block(P, 0, 6),
        _block(P, 0, 9),
        _block(P, 0, 12),
        _block(P, 3, 3),
        _block(P, 3, 6),
        _block(P, 3, 9),
        _block(P, 3, 12),
        _block(P, 6, 6),
        _block(P, 6, 9),
        _block(P, 6, 12),
        _block(P, 9, 9),
        _block(P, 9, 12),
        _block(P, 12, 12),
    )


@register_jitable
def write_blocks(blocks: Covariance, P: np.ndarray) -> None:
    """Write a covariance in blocks into a matrix (15, 15)."""
    number = 0
    for row in range(0, ERRORS, 3):
        for column in range(row, ERRORS, 3):
            block = blocks[number]
            number += 1
            for i in range(3):
                for j in range(3):
                    P[row + i, column + j] = block[3 * i + j]
                    P[column + j, row + i] = block[3 * i + j]


@register_jitable
def update(
    memory: np.ndarray, z: np.ndarray, settings: Signal, mounting: np.ndarray, dt: float
) -> None:
    """Do an update in place: a period of the IMU, then what other sensors measured.

    Args:
        memory: see `SIZE`.
        z: see `samples`.
        settings: see `settings.EkfSettings`.
        mounting: see `samples.Mounting.packed`.
        dt: since the update before [s]; 0 at the first, which only measures.
    """
    x = memory[:NOMINAL]
    matrix = memory[COVARIANCE:INNOVATIONS].reshape(ERRORS, ERRORS)
    P = blocks_of(matrix)
    if dt > 0.0:
        F = transition(x, z[IMU:GPS], dt)
        after = propagated(x, z[IMU:GPS], dt)
        for i in range(NOMINAL):
            x[i] = after[i]
        P = spread(P, F, settings, dt)
    told = memory[INNOVATIONS:SIZE].reshape(CHANNELS, 2)
    told[:, :] = math.nan
    error = EXACT
    if z[GPS] > 0.0:
        motion = measured_motion(x, z, mounting, settings)
        for channel in range(len(motion)):
            P, error = _take_in(P, error, motion[channel], settings, told[channel])
    if z[BAROMETER] > 0.0:
        height = measured_height(x, z, mounting, settings)
        P, error = _take_in(P, error, height, settings, told[HEIGHT])
    if z[MAGNETOMETER] > 0.0:
        heading = measured_heading(x, z, mounting, settings)
        P, error = _take_in(P, error, heading, settings, told[HEADING])
    if z[RANGE_FINDER] > 0.0:
        distance = measured_distance(x, z, mounting, settings)
        P, error = _take_in(P, error, distance, settings, told[DISTANCE])
    write_blocks(P, matrix)
    found = corrected(x, error)
    for i in range(NOMINAL):
        x[i] = found[i]


@register_jitable
def _take_in(
    P: Covariance, error: Error, m: Measured, settings: Signal, told: np.ndarray
) -> tuple[Covariance, Error]:
    """Take a number in, and write its innovation and its variance."""
    if math.isnan(m.gap):
        return P, error
    found = fused(P, error, m, settings[10])
    told[0], told[1] = found.innovation, found.s
    return found.P, found.error


def initial(state: Signal, p_BI: Signal, deviations: InitialDeviations) -> np.ndarray:
    """Return the memory of a filter that begins at a known motion.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
        deviations: of its errors.
    """
    R = rotation(state[0:4])
    w_B = into_body(R, state[7:10])
    memory = np.full(SIZE, math.nan)
    memory[0:4] = np.asarray(state[0:4]) / np.linalg.norm(state[0:4])
    memory[4:7] = np.asarray(state[4:7]) + into_world(R, p_BI)
    memory[7:10] = np.asarray(state[10:13]) + into_world(R, crossed(w_B, p_BI))
    memory[10:16] = 0.0
    memory[COVARIANCE:INNOVATIONS] = np.diag(np.repeat(np.square(deviations), 3)).ravel()
    return memory
