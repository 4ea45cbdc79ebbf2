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


@register_jitable
def transition(x: Signal, imu: Signal, dt: float, F: np.ndarray) -> None:
    """Write F (9, 15): errors of attitude, place and velocity after a period by all before it."""
    w = (imu[0] - x[10], imu[1] - x[11], imu[2] - x[12])
    f = (imu[3] - x[13], imu[4] - x[14], imu[5] - x[15])
    whole = (dt * w[0], dt * w[1], dt * w[2])
    half = (0.5 * whole[0], 0.5 * whole[1], 0.5 * whole[2])
    one = (1.0, 0.0, 0.0, 0.0)
    middle = rotation(turned_by(one, half))
    after = rotation(turned_by(one, whole))
    R = rotation(turned_by((x[0], x[1], x[2], x[3]), half))
    J, J_half = np.empty((3, 3)), np.empty((3, 3))
    _right_jacobian(whole, J)
    _right_jacobian(half, J_half)
    F[:, :] = 0.0
    for i in range(3):
        F[3 + i, 3 + i] = 1.0
        F[6 + i, 6 + i] = 1.0
        F[3 + i, 6 + i] = dt
        # - R_m [f x], row by row
        r = (R[3 * i], R[3 * i + 1], R[3 * i + 2])
        m = crossed(f, r)
        for j in range(3):
            F[i, j] = after[3 * j + i]
            F[i, 9 + j] = -dt * J[i, j]
            by_angle = m[0] * middle[3 * j] + m[1] * middle[3 * j + 1] + m[2] * middle[3 * j + 2]
            by_bias = m[0] * J_half[0, j] + m[1] * J_half[1, j] + m[2] * J_half[2, j]
            F[6 + i, j] = dt * by_angle
            F[6 + i, 9 + j] = -0.5 * dt * dt * by_bias
            F[6 + i, 12 + j] = -dt * r[j]
            F[3 + i, j] = 0.5 * dt * F[6 + i, j]
            F[3 + i, 9 + j] = 0.5 * dt * F[6 + i, 9 + j]
            F[3 + i, 12 + j] = 0.5 * dt * F[6 + i, 12 + j]


@register_jitable
def _right_jacobian(turn: Signal, J: np.ndarray) -> None:
    """Write J_r(turn), the error at the end of a turn by that of the turn; Solà, equation 183."""
    x, y, z = turn
    s = x * x + y * y + z * z
    a = 0.5 - s * (1.0 / 24.0 - s / 720.0)
    b = 1.0 / 6.0 - s * (1.0 / 120.0 - s / 5040.0)
    J[0, 0] = 1.0 + b * (x * x - s)
    J[0, 1] = a * z + b * x * y
    J[0, 2] = -a * y + b * x * z
    J[1, 0] = -a * z + b * x * y
    J[1, 1] = 1.0 + b * (y * y - s)
    J[1, 2] = a * x + b * y * z
    J[2, 0] = a * y + b * x * z
    J[2, 1] = -a * x + b * y * z
    J[2, 2] = 1.0 + b * (z * z - s)


@register_jitable
def spread(P: np.ndarray, F: np.ndarray, settings: Signal, dt: float) -> None:
    """Write F P F' + Q into P (15, 15).

    Args:
        P: covariance of the errors.
        F: see `transition`; biases stay as they are.
        settings: see `settings.EkfSettings`.
        dt: the period [s].
    """
    T = np.zeros((9, ERRORS))
    for i in range(9):
        for k in range(ERRORS):
            share = F[i, k]
            if share != 0.0:
                for j in range(ERRORS):
                    T[i, j] += share * P[k, j]
    for i in range(9):
        for j in range(i, 9):
            total = 0.0
            for k in range(ERRORS):
                total += T[i, k] * F[j, k]
            P[i, j] = total
            P[j, i] = total
        for j in range(9, ERRORS):
            P[i, j] = T[i, j]
            P[j, i] = T[i, j]
    gyro, accel = settings[0] * settings[0] * dt, settings[1] * settings[1] * dt
    for i in range(3):
        P[i, i] += gyro
        P[3 + i, 3 + i] += accel * dt * dt / 3.0
        P[3 + i, 6 + i] += 0.5 * accel * dt
        P[6 + i, 3 + i] += 0.5 * accel * dt
        P[6 + i, 6 + i] += accel
        P[9 + i, 9 + i] += settings[2] * settings[2] * dt
        P[12 + i, 12 + i] += settings[3] * settings[3] * dt


@register_jitable
def fused(
    P: np.ndarray, error: np.ndarray, row: np.ndarray, gap: float, variance: float, gate: float
) -> float:
    """Take a measured number into error (15) and covariance, in place; return its variance s.

    Args:
        P: covariance (15, 15).
        error: so far.
        row: H (15).
        gap: y - h(x).
        variance: of the measurement.
        gate: it is left out beyond so many deviations.
    """
    gain = np.zeros(ERRORS)
    s, innovation = variance, gap
    for k in range(ERRORS):
        if row[k] != 0.0:
            innovation -= row[k] * error[k]
            for i in range(ERRORS):
                gain[i] += P[i, k] * row[k]
    for k in range(ERRORS):
        s += row[k] * gain[k]
    if innovation * innovation > gate * gate * s:
        return s
    for i in range(ERRORS):
        share = gain[i] / s
        error[i] += share * innovation
        for j in range(i, ERRORS):  # rounding would make halves of its own differ more and more
            P[i, j] -= share * gain[j]
            P[j, i] = P[i, j]
    return s


@register_jitable
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
    R = rotation((x[0], x[1], x[2], x[3]))
    p_BI = mounting[0:3]
    if z[GPS] > 0.0:
        _gps_rows(x, z, mounting, settings, rows, gaps)
    up = (R[6], R[7], R[8])
    if z[BAROMETER] > 0.0:
        arm = _lever(mounting[6:9], p_BI)
        turn = crossed(arm, up)
        gaps[6, 0] = z[BAROMETER + 1] - (x[6] + into_world(R, arm)[2])
        gaps[6, 1] = settings[7] * settings[7]
        rows[6, 5] = 1.0
        for j in range(3):
            rows[6, j] = turn[j]
    if z[MAGNETOMETER] > 0.0:
        m_x, m_y, m_z = mounting[15], mounting[16], mounting[17]
        level = m_x * m_x + m_y * m_y
        k = z[MAGNETOMETER + 1 : MAGNETOMETER + 4]
        n_x, n_y, _ = into_world(R, (k[0], k[1], k[2]))
        gaps[7, 0] = math.atan2(n_x * m_y - n_y * m_x, n_x * m_x + n_y * m_y)
        gaps[7, 1] = settings[8] * settings[8] / level
        # a wrong tilt turns the horizontal part of a field that dips; taken of the known field, as
        # the measured one's noise would come into H, and seem to tell of the tilt
        about = into_body(R, (-m_z * m_x / level, -m_z * m_y / level, 1.0))
        for j in range(3):
            rows[7, j] = about[j]
    if z[RANGE_FINDER] > 0.0:
        arm = _lever(mounting[9:12], p_BI)
        n = (mounting[12], mounting[13], mounting[14])
        down = -into_world(R, n)[2]
        if down > LEAST_LOOK:
            height = x[6] + into_world(R, arm)[2]
            by_place, by_view = crossed(arm, up), crossed(n, up)
            gaps[8, 0] = z[RANGE_FINDER + 1] - height / down
            gaps[8, 1] = settings[9] * settings[9]
            rows[8, 5] = 1.0 / down
            for j in range(3):
                rows[8, j] = by_place[j] / down + height / (down * down) * by_view[j]


@register_jitable
def _gps_rows(
    x: Signal, z: Signal, mounting: Signal, settings: Signal, rows: np.ndarray, gaps: np.ndarray
) -> None:
    """Write what `rows_of` does of a sample of the GPS.

    It is held against the motion at its own time: x, carried back over its age.
    """
    back = -z[GPS + 1]
    F = np.empty((9, ERRORS))
    transition(x, z[IMU:GPS], back, F)
    then = propagated(x, z[IMU:GPS], back)
    R = rotation(then[0:4])
    w = (z[0] - x[10], z[1] - x[11], z[2] - x[12])
    arm = _lever(mounting[3:6], mounting[0:3])
    turn = crossed(w, arm)
    place, speed = into_world(R, arm), into_world(R, turn)
    for i in range(3):
        r = (R[3 * i], R[3 * i + 1], R[3 * i + 2])
        of_place, of_speed, of_bias = crossed(arm, r), crossed(turn, r), crossed(r, arm)
        deviation = settings[4] if i < 2 else settings[5]
        gaps[i, 0] = z[GPS + 2 + i] - (then[4 + i] + place[i])
        gaps[i, 1] = deviation * deviation
        gaps[3 + i, 0] = z[GPS + 5 + i] - (then[7 + i] + speed[i])
        gaps[3 + i, 1] = settings[6] * settings[6]
        for k in range(ERRORS):
            rows[i, k], rows[3 + i, k] = F[3 + i, k], F[6 + i, k]
            for j in range(3):
                rows[i, k] += of_place[j] * F[j, k]
                rows[3 + i, k] += of_speed[j] * F[j, k]
        for j in range(3):
            rows[3 + i, 9 + j] += of_bias[j]


@register_jitable(forceinline=True)
def _lever(p: Signal, p_BI: Signal) -> tuple[Scalar, Scalar, Scalar]:
    return p[0] - p_BI[0], p[1] - p_BI[1], p[2] - p_BI[2]


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
    P = memory[COVARIANCE:INNOVATIONS].reshape(ERRORS, ERRORS)
    if dt > 0.0:
        F = np.empty((9, ERRORS))
        transition(x, z[IMU:GPS], dt, F)
        after = propagated(x, z[IMU:GPS], dt)
        for i in range(NOMINAL):
            x[i] = after[i]
        spread(P, F, settings, dt)
    told = memory[INNOVATIONS:SIZE].reshape(CHANNELS, 2)
    told[:, :] = math.nan
    if z[GPS] + z[BAROMETER] + z[MAGNETOMETER] + z[RANGE_FINDER] == 0.0:
        return
    rows, error = np.empty((CHANNELS, ERRORS)), np.zeros(ERRORS)
    rows_of(x, z, mounting, settings, rows, told)
    for channel in range(CHANNELS):
        gap, variance = told[channel, 0], told[channel, 1]
        if not math.isnan(gap):
            for k in range(ERRORS):
                told[channel, 0] -= rows[channel, k] * error[k]
            told[channel, 1] = fused(P, error, rows[channel], gap, variance, settings[10])
    found = corrected(x, error)
    for i in range(NOMINAL):
        x[i] = found[i]


def nominal(state: Signal, p_BI: Signal) -> np.ndarray:
    """Return the nominal state (16) of a known motion, without biases.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
    """
    R = rotation(state[0:4])
    w_B = into_body(R, state[7:10])
    x = np.zeros(NOMINAL)
    x[0:4] = np.asarray(state[0:4]) / np.linalg.norm(state[0:4])
    x[4:7] = np.asarray(state[4:7]) + into_world(R, p_BI)
    x[7:10] = np.asarray(state[10:13]) + into_world(R, crossed(w_B, p_BI))
    return x


def initial(state: Signal, p_BI: Signal, deviations: InitialDeviations) -> np.ndarray:
    """Return the memory of a filter that begins at a known motion.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
        deviations: of its errors.
    """
    memory = np.full(SIZE, math.nan)
    memory[:NOMINAL] = nominal(state, p_BI)
    memory[COVARIANCE:INNOVATIONS] = np.diag(np.repeat(np.square(deviations), 3)).ravel()
    return memory
