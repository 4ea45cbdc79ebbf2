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

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers
from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.estimation.ekf_measurements import mean_imu, measurement_rows
from workbench.estimation.ekf_propagation import corrected, process_noise, propagated, transition
from workbench.estimation.ekf_state import (
    COVARIANCE_INDEX,
    EKF_MEMORY_SIZE,
    ERRORS,
    INNOVATIONS_INDEX,
    MEASUREMENT_CHANNELS,
    NOMINAL,
    covariance_of,
    innovations_of,
    nominal_of,
)
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER

START_ERRORS_SOURCE = "start of the estimate"
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


@register_jitable
def motion_estimate(x: Numbers, imu: Numbers, p_BI: Numbers) -> tuple[float, ...]:
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
def update(
    memory: np.ndarray, z: np.ndarray, settings: Numbers, mounting: np.ndarray, dt: float
) -> None:
    """Do an update in place: a period of the IMU, then the measurements of other sensors.

    Args:
        memory: see `EKF_MEMORY_SIZE`.
        z: see `samples`.
        settings: see `settings.EkfSettings`.
        mounting: see `samples.Mounting.packed`.
        dt: since the previous update [s]; 0 at the first, which only measures.
    """
    x, P, innovations = nominal_of(memory), covariance_of(memory), innovations_of(memory)
    if dt > 0.0:
        F = transition(x, mean_imu(z), dt)
        x = propagated(x, mean_imu(z), dt)
        spread = F @ P @ F.T + process_noise(settings, dt)
        P[:, :] = 0.5 * (spread + spread.T)  # rounding errors would make it less symmetric
    innovations[:, :] = math.nan
    if z[GPS] + z[BAROMETER] + z[MAGNETOMETER] + z[RANGE_FINDER] > 0.0:
        dx = np.zeros(ERRORS)
        H, gaps = measurement_rows(x, z, mounting, settings)
        for i in range(MEASUREMENT_CHANNELS):
            gap, variance = gaps[i, 0], gaps[i, 1]
            if not math.isnan(gap):
                innovations[i] = _fuse_measurement(P, dx, H[i], gap, variance, settings[10])
        x = corrected(x, dx)
    memory[:NOMINAL] = x


@register_jitable
def _fuse_measurement(
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


def nominal(state: Numbers, p_BI: Numbers) -> np.ndarray:
    """Return the nominal state (16) of a known motion, without biases.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
    """
    R = rotation(state[0:4])
    w_B = into_body(R, state[7:10])
    x = np.zeros(NOMINAL)
    q_WB = np.asarray(state[0:4])
    x[0:4] = q_WB / np.linalg.norm(q_WB)
    x[4:7] = np.asarray(state[4:7]) + into_world(R, p_BI)
    x[7:10] = np.asarray(state[10:13]) + into_world(R, cross(w_B, p_BI))
    return x


def initial_ekf(state: Numbers, p_BI: Numbers, deviations: InitialDeviations) -> np.ndarray:
    """Return the initial memory for a known motion.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
        deviations: of its errors.
    """
    memory = np.full(EKF_MEMORY_SIZE, math.nan)
    memory[:NOMINAL] = nominal(state, p_BI)
    memory[COVARIANCE_INDEX:INNOVATIONS_INDEX] = np.diag(
        np.repeat(np.square(deviations), 3)
    ).ravel()
    return memory


def start_errors(seed: int | None) -> np.ndarray:
    """Return the standard normal numbers of the initial errors (15).

    Args:
        seed: of the source `START_ERRORS_SOURCE`; None for an exact initial estimate.
    """
    if seed is None:
        return np.zeros(ERRORS)
    return np.random.Generator(np.random.Philox(key=seed)).standard_normal(ERRORS)
