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

one number after another, which equals a joint update if their noises are independent. A number
whose innovation is beyond the gate is rejected. A sample of age T is compared with the motion T
ago, by the same equations over -T with the last means of the IMU.

Source: J. Solà, Quaternion kinematics for the error-state Kalman filter, arXiv:1711.02508, 2017:
sections 5.3 (local error), 5.4.3 and 6.1.
"""

import math
from typing import NamedTuple

import numpy as np

from workbench.common.jitable import Scalar, Vector, register_jitable
from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.estimation.covariance import (
    ERRORS as ERRORS,
)
from workbench.estimation.covariance import (
    Block,
    Covariance,
    Error,
    Measured,
    Three,
    Transition,
    blocks_of,
    carried,
    fused,
    scaled,
    spread,
    times,
    transposed,
    write_blocks,
)
from workbench.estimation.samples import AGES, BAROMETER, GPS, IMU, MAGNETOMETER, RANGE_FINDER
from workbench.plant.gravity import GRAVITY

NONE, EAST, NORTH, UP = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
EXACT = (0.0,) * 15

NOMINAL, CHANNELS = 16, 10
"""Sizes of the nominal state, and of measurements: position and velocity of the antenna (6),
height, heading, distance, and an unused place."""
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
"""Names of the measurements."""
SETTINGS = (
    "ekf_gps_position",
    "ekf_gps_position",
    "ekf_gps_height",
    "ekf_gps_velocity",
    "ekf_gps_velocity",
    "ekf_gps_velocity",
    "ekf_barometer",
    "ekf_magnetometer",
    "ekf_range_finder",
)
"""Parameter with the standard deviation of each measurement."""
HEIGHT, HEADING, DISTANCE = 6, 7, 8
"""Places of the measurements after those of the GPS."""
COVARIANCE = NOMINAL
INNOVATIONS = COVARIANCE + ERRORS * ERRORS
SIZE = INNOVATIONS + 2 * CHANNELS
"""Layout of the memory, and its size: x (16), P row by row (225), and for each measurement its
innovation and variance in this update, NaN without one."""
LEAST_LOOK = 0.5
"""Smallest cosine of the angle between the range finder's beam and vertical for a measurement."""


START = "start of the estimate"
"""Name of the source of the errors at the start."""


class InitialDeviations(NamedTuple):
    """Standard deviations of the initial errors of the estimate.

    The defaults are those that the shipped drone's sensors reach within a minute.
    """

    attitude: float = 0.001
    position: float = 0.05
    velocity: float = 0.01
    gyro_bias: float = 1e-4
    accel_bias: float = 0.005


@register_jitable(forceinline=True)
def turned_by(q: Vector, turn: Vector) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the unit quaternion q exp(turn), for a turn in B (3) of at most a few radians."""
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


@register_jitable
def propagated(x: Vector, imu: Vector, dt: Scalar) -> tuple[Scalar, ...]:
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
def corrected(x: Vector, error: Vector) -> tuple[Scalar, ...]:
    """Return the nominal state (16), corrected by an error (15)."""
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
def estimate(x: Vector, imu: Vector, p_BI: Vector) -> tuple[Scalar, ...]:
    """Return the motion of the base origin (13): q_WB, p_WB, w_WB_B [rad/s], v_WB_W.

    Args:
        x: nominal state (16).
        imu: angular velocity in B, first of it (3).
        p_BI: of the IMU (3) [m].
    """
    R = rotation((x[0], x[1], x[2], x[3]))
    w = (imu[0] - x[10], imu[1] - x[11], imu[2] - x[12])
    l_x, l_y, l_z = into_world(R, p_BI)
    u_x, u_y, u_z = into_world(R, cross(w, p_BI))
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


@register_jitable(forceinline=True)
def transition(x: Vector, imu: Vector, dt: Scalar) -> Transition:
    """Return the derivatives of attitude and velocity errors after a period by all errors before.

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
        cross(f, (R[0], R[1], R[2])) + cross(f, (R[3], R[4], R[5])) + cross(f, (R[6], R[7], R[8]))
    )
    by_angle = times(pull, transposed(rotation(turned_by(one, half))))
    by_bias = times(pull, _right_jacobian(half))
    return Transition(
        tt=transposed(rotation(turned_by(one, whole))),
        tg=scaled(-dt, _right_jacobian(whole)),
        vt=scaled(dt, by_angle),
        vg=scaled(-0.5 * dt * dt, by_bias),
        va=scaled(-dt, R),
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
def _lever(p: Vector, p_BI: Vector) -> Three:
    return p[0] - p_BI[0], p[1] - p_BI[1], p[2] - p_BI[2]


@register_jitable(forceinline=True)
def measured_height(x: Vector, z: Vector, mounting: Vector, settings: Vector) -> Measured:
    """Return the measurement of the barometer.

    Args:
        x: nominal state (16).
        z: see `samples`.
        mounting: see `samples.Mounting.packed`.
        settings: see `settings.EkfSettings`.
    """
    imu, back = z[IMU:GPS], -z[AGES]
    then = propagated(x, imu, back)
    R = rotation((then[0], then[1], then[2], then[3]))
    arm = _lever(mounting[6:9], mounting[0:3])
    row = Measured(
        t=cross(arm, (R[6], R[7], R[8])),
        p=UP,
        v=NONE,
        g=NONE,
        a=NONE,
        gap=z[BAROMETER + 1] - (then[6] + into_world(R, arm)[2]),
        variance=settings[7] * settings[7],
    )
    return carried(row, transition(x, imu, back), back)


@register_jitable(forceinline=True)
def measured_heading(x: Vector, z: Vector, mounting: Vector, settings: Vector) -> Measured:
    """Return the measurement of the magnetometer; arguments as for `measured_height`."""
    imu, back = z[IMU:GPS], -z[AGES + 1]
    then = propagated(x, imu, back)
    R = rotation((then[0], then[1], then[2], then[3]))
    m_x, m_y, m_z = mounting[15], mounting[16], mounting[17]
    level = m_x * m_x + m_y * m_y
    k = (z[MAGNETOMETER + 1], z[MAGNETOMETER + 2], z[MAGNETOMETER + 3])
    n_x, n_y, _ = into_world(R, k)
    # a wrong tilt turns the horizontal part of a dipping field; this uses the known field, because
    # noise of the measured one in H would look like information about the tilt
    row = Measured(
        t=into_body(R, (-m_z * m_x / level, -m_z * m_y / level, 1.0)),
        p=NONE,
        v=NONE,
        g=NONE,
        a=NONE,
        gap=math.atan2(n_x * m_y - n_y * m_x, n_x * m_x + n_y * m_y),
        variance=settings[8] * settings[8] / level,
    )
    return carried(row, transition(x, imu, back), back)


@register_jitable(forceinline=True)
def measured_distance(x: Vector, z: Vector, mounting: Vector, settings: Vector) -> Measured:
    """Return the measurement of the range finder; arguments as for `measured_height`."""
    imu, back = z[IMU:GPS], -z[AGES + 2]
    then = propagated(x, imu, back)
    R = rotation((then[0], then[1], then[2], then[3]))
    up = (R[6], R[7], R[8])
    arm = _lever(mounting[9:12], mounting[0:3])
    n = (mounting[12], mounting[13], mounting[14])
    down = -into_world(R, n)[2]
    height = then[6] + into_world(R, arm)[2]
    by_place, by_view = cross(arm, up), cross(n, up)
    tilt = height / (down * down)
    row = Measured(
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
    return carried(row, transition(x, imu, back), back)


@register_jitable(forceinline=True)
def measured_motion(
    x: Vector, z: Vector, mounting: Vector, settings: Vector
) -> tuple[Measured, Measured, Measured, Measured, Measured, Measured]:
    """Return position and velocity as measured by the GPS; arguments as for `measured_height`."""
    imu, back = z[IMU:GPS], -z[GPS + 1]
    F = transition(x, imu, back)
    then = propagated(x, imu, back)
    R = rotation((then[0], then[1], then[2], then[3]))
    arm = _lever(mounting[3:6], mounting[0:3])
    turn = cross((z[0] - x[10], z[1] - x[11], z[2] - x[12]), arm)
    y, v = into_world(R, arm), into_world(R, turn)
    level, height, speed = settings[4], settings[5], settings[6]
    y = (then[4] + y[0], then[5] + y[1], then[6] + y[2])
    v = (then[7] + v[0], then[8] + v[1], then[9] + v[2])
    east, north, up = (R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8])
    return (
        carried(_placed(east, arm, EAST, z[GPS + 2] - y[0], level), F, back),
        carried(_placed(north, arm, NORTH, z[GPS + 3] - y[1], level), F, back),
        carried(_placed(up, arm, UP, z[GPS + 4] - y[2], height), F, back),
        carried(_driven(east, arm, turn, EAST, z[GPS + 5] - v[0], speed), F, back),
        carried(_driven(north, arm, turn, NORTH, z[GPS + 6] - v[1], speed), F, back),
        carried(_driven(up, arm, turn, UP, z[GPS + 7] - v[2], speed), F, back),
    )


@register_jitable(forceinline=True)
def _placed(r: Three, arm: Three, axis: Three, gap: Scalar, deviation: Scalar) -> Measured:
    """Return the measurement of a coordinate of the antenna's position, with a row r of R_WB."""
    return Measured(
        t=cross(arm, r), p=axis, v=NONE, g=NONE, a=NONE, gap=gap, variance=deviation * deviation
    )


@register_jitable(forceinline=True)
def _driven(
    r: Three, arm: Three, turn: Three, axis: Three, gap: Scalar, deviation: Scalar
) -> Measured:
    """Return the measurement of a coordinate of the antenna's velocity, with a row r of R_WB."""
    return Measured(
        t=cross(turn, r),
        p=NONE,
        v=axis,
        g=cross(r, arm),
        a=NONE,
        gap=gap,
        variance=deviation * deviation,
    )


def rows_of(
    x: Vector, z: Vector, mounting: Vector, settings: Vector, rows: np.ndarray, gaps: np.ndarray
) -> None:
    """Write H (10, 15), y - h(x) and variance of every measurement with a new sample.

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


@register_jitable
def update(
    memory: np.ndarray, z: np.ndarray, settings: Vector, mounting: np.ndarray, dt: float
) -> None:
    """Do an update in place: a period of the IMU, then the measurements of other sensors.

    Args:
        memory: see `SIZE`.
        z: see `samples`.
        settings: see `settings.EkfSettings`.
        mounting: see `samples.Mounting.packed`.
        dt: since the previous update [s]; 0 at the first, which only measures.
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
    P: Covariance, error: Error, m: Measured, settings: Vector, told: np.ndarray
) -> tuple[Covariance, Error]:
    """Update with a measurement, and write its innovation and variance."""
    if math.isnan(m.gap):
        return P, error
    found = fused(P, error, m, settings[10])
    told[0], told[1] = found.innovation, found.s
    return found.P, found.error


def nominal(state: Vector, p_BI: Vector) -> np.ndarray:
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
    x[7:10] = np.asarray(state[10:13]) + into_world(R, cross(w_B, p_BI))
    return x


def initial(state: Vector, p_BI: Vector, deviations: InitialDeviations) -> np.ndarray:
    """Return the initial memory for a known motion.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
        deviations: of its errors.
    """
    memory = np.full(SIZE, math.nan)
    memory[:NOMINAL] = nominal(state, p_BI)
    memory[COVARIANCE:INNOVATIONS] = np.diag(np.repeat(np.square(deviations), 3)).ravel()
    return memory


def start_errors(seed: int | None) -> np.ndarray:
    """Return the standard normal numbers of the initial errors (15).

    Args:
        seed: of the source `START`; None for an exact initial estimate.
    """
    if seed is None:
        return np.zeros(ERRORS)
    return np.random.Generator(np.random.Philox(key=seed)).standard_normal(ERRORS)
