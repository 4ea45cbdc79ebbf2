"""Measurements of the Kalman filter: rows H and differences y - h(x)."""

import math

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.estimation.ekf_propagation import propagated, transition
from workbench.estimation.ekf_state import (
    ATTITUDE_ERROR,
    DISTANCE_CHANNEL,
    ERRORS,
    GYRO_BIAS_ERROR,
    HEADING_CHANNEL,
    HEIGHT_CHANNEL,
    MEASUREMENT_CHANNELS,
    POSITION_ERROR,
    three_of,
)
from workbench.estimation.samples import AGES, BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER

MIN_BEAM_COSINE = 0.5
"""Smallest cosine of the angle between the range finder's beam and vertical for a measurement."""


@register_jitable
def measurement_rows(
    x: Numbers, z: np.ndarray, mounting: Numbers, settings: Numbers
) -> tuple[np.ndarray, np.ndarray]:
    """Return H (10, 15), and y - h(x) with its variance (10, 2), of the new samples.

    Without one, a row of H is zero, and the numbers are NaN.

    Args:
        x: nominal state (16).
        z: see `samples`.
        mounting: see `samples.Mounting.packed`.
        settings: see `settings.EkfSettings`.
    """
    H, gaps = np.zeros((MEASUREMENT_CHANNELS, ERRORS)), np.full((MEASUREMENT_CHANNELS, 2), math.nan)
    imu, old = mean_imu(z), float(z[GPS + 1])
    ages = (old, old, old, old, old, old, *three_of(z, AGES), 0.0)
    if z[GPS] > 0.0:
        then = propagated(x, imu, -ages[0])
        _measure_motion(H, gaps, then, z, mounting, settings)
    if z[BAROMETER] > 0.0:
        then = propagated(x, imu, -ages[HEIGHT_CHANNEL])
        _measure_height(H[HEIGHT_CHANNEL], gaps[HEIGHT_CHANNEL], then, z, mounting, settings)
    if z[MAGNETOMETER] > 0.0:
        then = propagated(x, imu, -ages[HEADING_CHANNEL])
        _measure_heading(H[HEADING_CHANNEL], gaps[HEADING_CHANNEL], then, z, mounting, settings)
    if z[RANGE_FINDER] > 0.0:
        then = propagated(x, imu, -ages[DISTANCE_CHANNEL])
        _measure_distance(H[DISTANCE_CHANNEL], gaps[DISTANCE_CHANNEL], then, z, mounting, settings)
    age, F = 0.0, np.eye(ERRORS)
    for i in range(MEASUREMENT_CHANNELS):
        if not math.isnan(gaps[i, 0]):
            if ages[i] != age:  # several sensors often sample at the same time
                age = ages[i]
                F = transition(x, imu, -age)
            H[i] = H[i] @ F
    return H, gaps


@register_jitable
def _measure_motion(
    H: np.ndarray, gaps: np.ndarray, x: Numbers, z: np.ndarray, mounting: Numbers, settings: Numbers
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
    w_x, w_y, w_z = three_of(z, 0)
    turn = cross((w_x - x[10], w_y - x[11], w_z - x[12]), arm)
    r, u = into_world(R, arm), into_world(R, turn)
    for i in range(3):
        axis = (R[3 * i], R[3 * i + 1], R[3 * i + 2])  # of W, in B
        position = settings[5] if i == 2 else settings[4]
        H[i, ATTITUDE_ERROR], H[i, 3 + i] = cross(arm, axis), 1.0
        gaps[i] = z[GPS + 2 + i] - (x[4 + i] + r[i]), position * position
        H[3 + i, ATTITUDE_ERROR], H[3 + i, 6 + i] = cross(turn, axis), 1.0
        H[3 + i, GYRO_BIAS_ERROR] = cross(axis, arm)
        gaps[3 + i] = z[GPS + 5 + i] - (x[7 + i] + u[i]), settings[6] * settings[6]


@register_jitable
def _measure_height(
    H: np.ndarray, gap: np.ndarray, x: Numbers, z: np.ndarray, mounting: Numbers, settings: Numbers
) -> None:
    """Write the row of the barometer (15); arguments as for `_measure_motion`."""
    R, arm = rotation(x[0:4]), _arm(mounting, 6)
    H[ATTITUDE_ERROR], H[POSITION_ERROR] = cross(arm, R[6:9]), (0.0, 0.0, 1.0)
    gap[0] = z[BAROMETER + 1] - (x[6] + into_world(R, arm)[2])
    gap[1] = settings[7] * settings[7]


@register_jitable
def _measure_heading(
    H: np.ndarray, gap: np.ndarray, x: Numbers, z: np.ndarray, mounting: Numbers, settings: Numbers
) -> None:
    """Write the row of the magnetometer (15); arguments as for `_measure_motion`."""
    R, (m_x, m_y, m_z) = rotation(x[0:4]), three_of(mounting, 15)
    level = m_x * m_x + m_y * m_y
    n_x, n_y, _ = into_world(R, three_of(z, MAGNETOMETER + 1))
    # a wrong tilt turns the horizontal part of a dipping field; this uses the known field, because
    # noise of the measured one in H would look like information about the tilt
    H[ATTITUDE_ERROR] = into_body(R, (-m_z * m_x / level, -m_z * m_y / level, 1.0))
    gap[0] = math.atan2(n_x * m_y - n_y * m_x, n_x * m_x + n_y * m_y)
    gap[1] = settings[8] * settings[8] / level


@register_jitable
def _measure_distance(
    H: np.ndarray, gap: np.ndarray, x: Numbers, z: np.ndarray, mounting: Numbers, settings: Numbers
) -> None:
    """Write the row of the range finder (15), unless it looks too far aside.

    Arguments are as for `_measure_motion`.
    """
    R, arm, n = rotation(x[0:4]), _arm(mounting, 9), three_of(mounting, 12)
    down = -into_world(R, n)[2]
    if down > MIN_BEAM_COSINE:
        distance = (x[6] + into_world(R, arm)[2]) / down
        by_place, by_view = cross(arm, R[6:9]), cross(n, R[6:9])
        for i in range(3):
            H[i] = (by_place[i] + distance * by_view[i]) / down
        H[POSITION_ERROR] = (0.0, 0.0, 1.0 / down)
        gap[0], gap[1] = z[RANGE_FINDER + 1] - distance, settings[9] * settings[9]


@register_jitable
def mean_imu(z: np.ndarray) -> tuple[float, ...]:
    """Return mean angular velocity and specific force in B (6) of samples."""
    return three_of(z, 0) + three_of(z, 3)


@register_jitable
def _arm(mounting: Numbers, at: int) -> Vector3:
    """Return a sensor's position from the IMU, in B [m], by its place in the mounting."""
    x, y, z = three_of(mounting, at)
    return x - float(mounting[0]), y - float(mounting[1]), z - float(mounting[2])
