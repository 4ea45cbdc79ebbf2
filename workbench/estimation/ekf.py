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
from workbench.estimation.samples import AGES, BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER
from workbench.plant.gravity import GRAVITY

ERRORS = 15
"""Number of errors."""
ATTITUDE, PLACE, VELOCITY = slice(0, 3), slice(3, 6), slice(6, 9)
GYRO_BIAS, ACCEL_BIAS = slice(9, 12), slice(12, 15)
"""Rows and columns of the errors in P, F and H."""
NOMINAL = 16
"""Size of the nominal state."""
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
CHANNELS = len(NAMES) + 1
"""Number of measurements in the memory; the last place is not used."""
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
HEIGHT, HEADING, DISTANCE = (
    NAMES.index(name) for name in ("barometer", "magnetometer", "range_finder")
)
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


@register_jitable
def transition(x: Vector, imu: Vector, dt: float) -> np.ndarray:
    """Return F (15, 15), the errors after a period by those before it.

    With the matrix [f]x of the cross product, R(turn) of a turn, and its right Jacobian J_r:

        d_theta+ = R(w dt)' d_theta - J_r(w dt) dt d_b_g
        d_v+ = d_v - R_m dt ([f]x (R(w dt/2)' d_theta - J_r(w dt/2) dt/2 d_b_g) + d_b_a)
        d_p+ = d_p + (d_v + d_v+) dt/2

    Args:
        x: nominal state before it (16).
        imu: mean angular velocity and specific force in B (6).
        dt: the period [s].
    """
    turn = (dt * (imu[0] - x[10]), dt * (imu[1] - x[11]), dt * (imu[2] - x[12]))
    f = (imu[3] - x[13], imu[4] - x[14], imu[5] - x[15])
    half = (0.5 * turn[0], 0.5 * turn[1], 0.5 * turn[2])
    R_m = rotation(turned_by((x[0], x[1], x[2], x[3]), half))
    pull = cross(f, R_m[0:3]) + cross(f, R_m[3:6]) + cross(f, R_m[6:9])  # -R_m [f]x
    F = np.eye(ERRORS)
    F[ATTITUDE, ATTITUDE] = _matrix(_turned_back(turn))
    F[ATTITUDE, GYRO_BIAS] = -dt * _matrix(_right_jacobian(turn))
    F[VELOCITY, ATTITUDE] = dt * _matrix(_times(pull, _turned_back(half)))
    F[VELOCITY, GYRO_BIAS] = -0.5 * dt * dt * _matrix(_times(pull, _right_jacobian(half)))
    F[VELOCITY, ACCEL_BIAS] = -dt * _matrix(R_m)
    F[PLACE] += 0.5 * dt * F[VELOCITY]
    F[PLACE, VELOCITY] *= 2.0
    return F


@register_jitable
def _matrix(rows: Vector) -> np.ndarray:
    """Return a matrix (3, 3) of its rows (9)."""
    return np.array(rows).reshape(3, 3)


@register_jitable(forceinline=True)
def _times(A: Vector, B: Vector) -> tuple[Scalar, ...]:
    """Return the rows of A B (9), of the rows of both (9 each)."""
    return into_body(B, A[0:3]) + into_body(B, A[3:6]) + into_body(B, A[6:9])


@register_jitable(forceinline=True)
def _turned_back(turn: Vector) -> tuple[Scalar, ...]:
    """Return the rows (9) of R(turn)'."""
    x, y, z = turn
    return rotation(turned_by((1.0, 0.0, 0.0, 0.0), (-x, -y, -z)))


@register_jitable(forceinline=True)
def _right_jacobian(turn: Vector) -> tuple[Scalar, ...]:
    """Return the rows (9) of J_r(turn), the error at the end of a turn by that of the turn.

    Solà, equation 183, by the series of sine and cosine.
    """
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


@register_jitable
def noise(settings: Vector, dt: float) -> np.ndarray:
    """Return Q of a period (15, 15): white noise of the IMU, integrated, and walks of its biases.

    Args:
        settings: see `settings.EkfSettings`.
        dt: the period [s].
    """
    gyro, accel = settings[0] * settings[0] * dt, settings[1] * settings[1] * dt
    gyro_walk, accel_walk = settings[2] * settings[2] * dt, settings[3] * settings[3] * dt
    Q = np.zeros((ERRORS, ERRORS))
    for t in range(3):
        p, v, g, a = t + 3, t + 6, t + 9, t + 12
        Q[t, t], Q[g, g], Q[a, a] = gyro, gyro_walk, accel_walk
        Q[v, v], Q[p, p] = accel, accel * dt * dt / 3.0
        Q[p, v] = Q[v, p] = 0.5 * accel * dt
    return Q


@register_jitable
def measured(
    x: Vector, z: np.ndarray, mounting: Vector, settings: Vector
) -> tuple[np.ndarray, np.ndarray]:
    """Return H (10, 15), and y - h(x) with its variance (10, 2), of the new samples.

    Without one, a row of H is zero, and the numbers are NaN.

    Args:
        x: nominal state (16).
        z: see `samples`.
        mounting: see `samples.Mounting.packed`.
        settings: see `settings.EkfSettings`.
    """
    H, gaps = np.zeros((CHANNELS, ERRORS)), np.full((CHANNELS, 2), math.nan)
    imu, old = _imu(z), float(z[GPS + 1])
    ages = (old, old, old, old, old, old, *_three(z, AGES), 0.0)
    if z[GPS] > 0.0:
        then = propagated(x, imu, -ages[0])
        _measure_motion(H, gaps, then, z, mounting, settings)
    if z[BAROMETER] > 0.0:
        then = propagated(x, imu, -ages[HEIGHT])
        _measure_height(H[HEIGHT], gaps[HEIGHT], then, z, mounting, settings)
    if z[MAGNETOMETER] > 0.0:
        then = propagated(x, imu, -ages[HEADING])
        _measure_heading(H[HEADING], gaps[HEADING], then, z, mounting, settings)
    if z[RANGE_FINDER] > 0.0:
        then = propagated(x, imu, -ages[DISTANCE])
        _measure_distance(H[DISTANCE], gaps[DISTANCE], then, z, mounting, settings)
    age, F = 0.0, np.eye(ERRORS)
    for i in range(CHANNELS):
        if not math.isnan(gaps[i, 0]):
            if ages[i] != age:  # several sensors often sample at the same time
                age = ages[i]
                F = transition(x, imu, -age)
            H[i] = H[i] @ F
    return H, gaps


@register_jitable
def _measure_motion(
    H: np.ndarray, gaps: np.ndarray, x: Vector, z: np.ndarray, mounting: Vector, settings: Vector
) -> None:
    """Write rows of position and velocity of the antenna, as functions of the state then.

    Args:
        H: places for them, first.
        gaps: places for y - h(x) and variance of each, first.
        x: nominal state at the time of the sample (16).
        z: see `samples`.
        mounting: see `samples.Mounting.packed`.
        settings: see `settings.EkfSettings`.
    """
    R, arm = rotation(x[0:4]), _arm(mounting, 3)
    w_x, w_y, w_z = _three(z, 0)
    turn = cross((w_x - x[10], w_y - x[11], w_z - x[12]), arm)
    r, u = into_world(R, arm), into_world(R, turn)
    for i in range(3):
        axis = (R[3 * i], R[3 * i + 1], R[3 * i + 2])  # of W, in B
        position = settings[5] if i == 2 else settings[4]
        H[i, ATTITUDE], H[i, 3 + i] = cross(arm, axis), 1.0
        gaps[i] = z[GPS + 2 + i] - (x[4 + i] + r[i]), position * position
        H[3 + i, ATTITUDE], H[3 + i, 6 + i] = cross(turn, axis), 1.0
        H[3 + i, GYRO_BIAS] = cross(axis, arm)
        gaps[3 + i] = z[GPS + 5 + i] - (x[7 + i] + u[i]), settings[6] * settings[6]


@register_jitable
def _measure_height(
    H: np.ndarray, gap: np.ndarray, x: Vector, z: np.ndarray, mounting: Vector, settings: Vector
) -> None:
    """Write the row of the barometer (15); arguments as for `_measure_motion`."""
    R, arm = rotation(x[0:4]), _arm(mounting, 6)
    H[ATTITUDE], H[PLACE] = cross(arm, R[6:9]), (0.0, 0.0, 1.0)
    gap[0] = z[BAROMETER + 1] - (x[6] + into_world(R, arm)[2])
    gap[1] = settings[7] * settings[7]


@register_jitable
def _measure_heading(
    H: np.ndarray, gap: np.ndarray, x: Vector, z: np.ndarray, mounting: Vector, settings: Vector
) -> None:
    """Write the row of the magnetometer (15); arguments as for `_measure_motion`."""
    R, (m_x, m_y, m_z) = rotation(x[0:4]), _three(mounting, 15)
    level = m_x * m_x + m_y * m_y
    n_x, n_y, _ = into_world(R, _three(z, MAGNETOMETER + 1))
    # a wrong tilt turns the horizontal part of a dipping field; this uses the known field, because
    # noise of the measured one in H would look like information about the tilt
    H[ATTITUDE] = into_body(R, (-m_z * m_x / level, -m_z * m_y / level, 1.0))
    gap[0] = math.atan2(n_x * m_y - n_y * m_x, n_x * m_x + n_y * m_y)
    gap[1] = settings[8] * settings[8] / level


@register_jitable
def _measure_distance(
    H: np.ndarray, gap: np.ndarray, x: Vector, z: np.ndarray, mounting: Vector, settings: Vector
) -> None:
    """Write the row of the range finder (15), unless it looks too far aside.

    Arguments are as for `_measure_motion`.
    """
    R, arm, n = rotation(x[0:4]), _arm(mounting, 9), _three(mounting, 12)
    down = -into_world(R, n)[2]
    if down > LEAST_LOOK:
        distance = (x[6] + into_world(R, arm)[2]) / down
        by_place, by_view = cross(arm, R[6:9]), cross(n, R[6:9])
        for i in range(3):
            H[i] = (by_place[i] + distance * by_view[i]) / down
        H[PLACE] = (0.0, 0.0, 1.0 / down)
        gap[0], gap[1] = z[RANGE_FINDER + 1] - distance, settings[9] * settings[9]


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
    x, P, told = nominal_of(memory), covariance_of(memory), innovations_of(memory)
    if dt > 0.0:
        F = transition(x, _imu(z), dt)
        x = propagated(x, _imu(z), dt)
        spread = F @ P @ F.T + noise(settings, dt)
        P[:, :] = 0.5 * (spread + spread.T)  # rounding errors would make it less symmetric
    told[:, :] = math.nan
    if z[GPS] + z[BAROMETER] + z[MAGNETOMETER] + z[RANGE_FINDER] > 0.0:
        dx = np.zeros(ERRORS)
        H, gaps = measured(x, z, mounting, settings)
        for i in range(CHANNELS):
            if not math.isnan(gaps[i, 0]):
                told[i] = _take_in(P, dx, H[i], gaps[i, 0], gaps[i, 1], settings[10])
        x = corrected(x, dx)
    memory[:NOMINAL] = x


@register_jitable
def _take_in(
    P: np.ndarray, dx: np.ndarray, H: np.ndarray, gap: float, r: float, gate: float
) -> tuple[float, float]:
    """Update P and dx in place with a measured number; return its innovation and variance.

    Args:
        P: covariance (15, 15).
        dx: error (15).
        H: row of the number (15).
        gap: y - h(x).
        r: variance of its noise.
        gate: limit of the innovation in standard deviations, beyond which it has no effect.
    """
    PH = P @ H
    s = float(H @ PH) + r
    innovation = gap - float(H @ dx)
    if innovation * innovation <= gate * gate * s:
        K = PH / s
        dx += K * innovation
        P -= K.reshape(ERRORS, 1) * K * s  # in this order symmetric to the bit
    return innovation, s


@register_jitable
def nominal_of(memory: np.ndarray) -> tuple[float, ...]:
    """Return the nominal state (16) of a memory; Python computes faster with its own numbers."""
    q_w, q_x, q_y, q_z = float(memory[0]), float(memory[1]), float(memory[2]), float(memory[3])
    p, v = _three(memory, 4), _three(memory, 7)
    return (q_w, q_x, q_y, q_z) + p + v + _three(memory, 10) + _three(memory, 13)


@register_jitable
def covariance_of(memory: np.ndarray) -> np.ndarray:
    """Return P (15, 15) of a memory, a view."""
    return memory[COVARIANCE:INNOVATIONS].reshape(ERRORS, ERRORS)


@register_jitable
def innovations_of(memory: np.ndarray) -> np.ndarray:
    """Return innovations and variances (10, 2) of a memory, a view."""
    return memory[INNOVATIONS:SIZE].reshape(CHANNELS, 2)


@register_jitable
def _imu(z: np.ndarray) -> tuple[float, ...]:
    """Return mean angular velocity and specific force in B (6) of samples."""
    return _three(z, 0) + _three(z, 3)


@register_jitable
def _three(numbers: Vector, at: int) -> tuple[float, float, float]:
    """Return three of some numbers, from a place on."""
    return float(numbers[at]), float(numbers[at + 1]), float(numbers[at + 2])


@register_jitable
def _arm(mounting: Vector, at: int) -> tuple[float, float, float]:
    """Return a sensor's position from the IMU, in B [m], by its place in the mounting."""
    x, y, z = _three(mounting, at)
    return x - float(mounting[0]), y - float(mounting[1]), z - float(mounting[2])


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
