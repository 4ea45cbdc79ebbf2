"""Propagation of the state of the Kalman filter and of its covariance."""

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Matrix3, Numbers, Quaternion, Vector3
from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.estimation.ekf_state import (
    ACCEL_BIAS_ERROR,
    ATTITUDE_ERROR,
    ERRORS,
    GYRO_BIAS_ERROR,
    POSITION_ERROR,
    VELOCITY_ERROR,
)
from workbench.plant.gravity import GRAVITY


@register_jitable(forceinline=True)
def turned_by(q: Numbers, turn: Numbers) -> Quaternion:
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
def propagated(x: Numbers, imu: Numbers, dt: float) -> tuple[float, ...]:
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
def corrected(x: Numbers, error: Numbers) -> tuple[float, ...]:
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
def transition(x: Numbers, imu: Numbers, dt: float) -> np.ndarray:
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
    F[ATTITUDE_ERROR, ATTITUDE_ERROR] = _matrix(_turned_back(turn))
    F[ATTITUDE_ERROR, GYRO_BIAS_ERROR] = -dt * _matrix(_right_jacobian(turn))
    F[VELOCITY_ERROR, ATTITUDE_ERROR] = dt * _matrix(_times(pull, _turned_back(half)))
    F[VELOCITY_ERROR, GYRO_BIAS_ERROR] = (
        -0.5 * dt * dt * _matrix(_times(pull, _right_jacobian(half)))
    )
    F[VELOCITY_ERROR, ACCEL_BIAS_ERROR] = -dt * _matrix(R_m)
    F[POSITION_ERROR] += 0.5 * dt * F[VELOCITY_ERROR]
    F[POSITION_ERROR, VELOCITY_ERROR] *= 2.0
    return F


@register_jitable
def _matrix(rows: Matrix3) -> np.ndarray:
    """Return a matrix (3, 3) of its rows (9)."""
    return np.array(rows).reshape(3, 3)


@register_jitable(forceinline=True)
def _times(A: Matrix3, B: Matrix3) -> Matrix3:
    """Return the rows of A B (9), of the rows of both (9 each)."""
    return into_body(B, A[0:3]) + into_body(B, A[3:6]) + into_body(B, A[6:9])


@register_jitable(forceinline=True)
def _turned_back(turn: Vector3) -> Matrix3:
    """Return the rows (9) of R(turn)'."""
    x, y, z = turn
    return rotation(turned_by((1.0, 0.0, 0.0, 0.0), (-x, -y, -z)))


@register_jitable(forceinline=True)
def _right_jacobian(turn: Vector3) -> Matrix3:
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
def process_noise(settings: Numbers, dt: float) -> np.ndarray:
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
