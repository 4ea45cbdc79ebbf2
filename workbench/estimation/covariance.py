"""The covariance of an error-state filter in blocks of 3 x 3, and its updates.

With F of a period and the noise Q of that period,

    P+ = F P F' + Q

and with a measured number y = h(x) + noise of variance r, of which H is a row: s = H P H' + r,
K = P H' / s,

    dx = dx + K (y - h(x) - H dx)      P = P - K s K'

In blocks the zeros and ones of F cost nothing. Everything is sums of products, which work with
floats, AutoDiff and machine code, also for many filters side by side.

Source: J. Solà, Quaternion kinematics for the error-state Kalman filter, arXiv:1711.02508, 2017:
sections 5.3 and 6.1.
"""

from typing import NamedTuple

import numpy as np

from workbench.common.jitable import Scalar, Vector, register_jitable
from workbench.dynamics.rigid_body import into_body, into_world

Three = tuple[Scalar, ...]
Block = tuple[Scalar, ...]
Error = tuple[Scalar, ...]
"""A vector (3), a matrix of 3 x 3 row by row (9), errors (15)."""
ERRORS = 15


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
def plus(A: Block, B: Block) -> Block:
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
def scaled(s: Scalar, A: Block) -> Block:
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
def transposed(A: Block) -> Block:
    """Return A'."""
    return A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]


@register_jitable(forceinline=True)
def _even(A: Block) -> Block:
    """Return the symmetric block with A's upper triangle, so that rounding errors do not grow."""
    return A[0], A[1], A[2], A[1], A[4], A[5], A[2], A[5], A[8]


@register_jitable(forceinline=True)
def times(A: Block, B: Block) -> Block:
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
def spread(P: Covariance, F: Transition, settings: Vector, dt: Scalar) -> Covariance:
    """Return F P F' + Q, with T = F P.

    Args:
        P: covariance of the errors.
        F: of the period.
        settings: see `settings.EkfSettings`.
        dt: the period [s].
    """
    h = 0.5 * dt
    T_tt = plus(times(F.tt, P.tt), times(F.tg, transposed(P.tg)))
    T_tp = plus(times(F.tt, P.tp), times(F.tg, transposed(P.pg)))
    T_tv = plus(times(F.tt, P.tv), times(F.tg, transposed(P.vg)))
    T_tg = plus(times(F.tt, P.tg), times(F.tg, P.gg))
    T_ta = plus(times(F.tt, P.ta), times(F.tg, P.ga))
    T_vt = _gone(F, P.tt, transposed(P.tv), transposed(P.tg), transposed(P.ta))
    T_vp = _gone(F, P.tp, transposed(P.pv), transposed(P.pg), transposed(P.pa))
    T_vv = _gone(F, P.tv, P.vv, transposed(P.vg), transposed(P.va))
    T_vg = _gone(F, P.tg, P.vg, P.gg, transposed(P.ga))
    T_va = _gone(F, P.ta, P.va, P.ga, P.aa)
    T_pt = plus(transposed(P.tp), scaled(h, plus(transposed(P.tv), T_vt)))
    T_pp = plus(P.pp, scaled(h, plus(transposed(P.pv), T_vp)))
    T_pv = plus(P.pv, scaled(h, plus(P.vv, T_vv)))
    T_pg = plus(P.pg, scaled(h, plus(P.vg, T_vg)))
    T_pa = plus(P.pa, scaled(h, plus(P.va, T_va)))
    tt = plus(times(T_tt, transposed(F.tt)), times(T_tg, transposed(F.tg)))
    tv = _back(F, T_tt, T_tv, T_tg, T_ta)
    vv = _back(F, T_vt, T_vv, T_vg, T_va)
    pv = _back(F, T_pt, T_pv, T_pg, T_pa)
    gyro, accel = settings[0] * settings[0] * dt, settings[1] * settings[1] * dt
    return Covariance(
        tt=_with(_even(tt), gyro),
        tp=plus(T_tp, scaled(h, plus(T_tv, tv))),
        tv=tv,
        tg=T_tg,
        ta=T_ta,
        pp=_with(_even(plus(T_pp, scaled(h, plus(T_pv, pv)))), accel * dt * dt / 3.0),
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
    T = plus(times(F.vt, P_t), P_v)
    return plus(T, plus(times(F.vg, P_g), times(F.va, P_a)))


@register_jitable(forceinline=True)
def _back(F: Transition, T_t: Block, T_v: Block, T_g: Block, T_a: Block) -> Block:
    """Return a row of T times the column of F' of the velocity."""
    P = plus(times(T_t, transposed(F.vt)), T_v)
    return plus(P, plus(times(T_g, transposed(F.vg)), times(T_a, transposed(F.va))))


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


@register_jitable(forceinline=True)
def carried(m: Measured, F: Transition, dt: Scalar) -> Measured:
    """Return H F: the measurement as a function of the present errors.

    Args:
        m: as a function of the errors at the time of the measurement.
        F: from now to that time.
        dt: that time from now, negative for an old sample [s].
    """
    h = 0.5 * dt
    pulled = moved(m.v, m.p, h)
    return Measured(
        t=moved(into_body(F.tt, m.t), into_body(F.vt, pulled), 1.0),
        p=m.p,
        v=moved(m.v, m.p, dt),
        g=moved(moved(m.g, into_body(F.tg, m.t), 1.0), into_body(F.vg, pulled), 1.0),
        a=moved(m.a, into_body(F.va, pulled), 1.0),
        gap=m.gap,
        variance=m.variance,
    )


class Fused(NamedTuple):
    """The state after a measurement.

    Attributes:
        P: covariance.
        error: including this measurement (15).
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
    """Update with a measured number; a number beyond the gate, or NaN, has no effect.

    Args:
        P: covariance.
        error: so far (15).
        m: the number.
        gate: limit of the innovation in standard deviations.
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
        tt=plus(P.tt, _outer(k_t, k_t, share)),
        tp=plus(P.tp, _outer(k_t, k_p, share)),
        tv=plus(P.tv, _outer(k_t, k_v, share)),
        tg=plus(P.tg, _outer(k_t, k_g, share)),
        ta=plus(P.ta, _outer(k_t, k_a, share)),
        pp=plus(P.pp, _outer(k_p, k_p, share)),
        pv=plus(P.pv, _outer(k_p, k_v, share)),
        pg=plus(P.pg, _outer(k_p, k_g, share)),
        pa=plus(P.pa, _outer(k_p, k_a, share)),
        vv=plus(P.vv, _outer(k_v, k_v, share)),
        vg=plus(P.vg, _outer(k_v, k_g, share)),
        va=plus(P.va, _outer(k_v, k_a, share)),
        gg=plus(P.gg, _outer(k_g, k_g, share)),
        ga=plus(P.ga, _outer(k_g, k_a, share)),
        aa=plus(P.aa, _outer(k_a, k_a, share)),
    )
    after = (
        moved(e_t, k_t, step)
        + moved(e_p, k_p, step)
        + moved(e_v, k_v, step)
        + moved(e_g, k_g, step)
        + moved(e_a, k_a, step)
    )
    return Fused(known, after, innovation, s)


@register_jitable(forceinline=True)
def moved(e: Three, k: Three, step: Scalar) -> Three:
    """Return e + step k."""
    return e[0] + step * k[0], e[1] + step * k[1], e[2] + step * k[2]


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
