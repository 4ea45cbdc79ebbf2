"""The memory of the Kalman filter: its states, errors, measurements and their places."""

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3

ERRORS = 15
"""Number of errors."""
ATTITUDE_ERROR, POSITION_ERROR, VELOCITY_ERROR = slice(0, 3), slice(3, 6), slice(6, 9)
GYRO_BIAS_ERROR, ACCEL_BIAS_ERROR = slice(9, 12), slice(12, 15)
"""Rows and columns of the errors in P, F and H."""
NOMINAL = 16
"""Size of the nominal state."""
MEASUREMENT_NAMES = (
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
MEASUREMENT_CHANNELS = len(MEASUREMENT_NAMES) + 1
"""Number of measurements in the memory; the last place is not used."""
MEASUREMENT_SETTINGS = (
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
HEIGHT_CHANNEL, HEADING_CHANNEL, DISTANCE_CHANNEL = (
    MEASUREMENT_NAMES.index(name) for name in ("barometer", "magnetometer", "range_finder")
)
"""Places of the measurements after those of the GPS."""
COVARIANCE_INDEX = NOMINAL
INNOVATIONS_INDEX = COVARIANCE_INDEX + ERRORS * ERRORS
EKF_MEMORY_SIZE = INNOVATIONS_INDEX + 2 * MEASUREMENT_CHANNELS
"""Layout of the memory, and its size: x (16), P row by row (225), and for each measurement its
innovation and variance in this update, NaN without one."""


@register_jitable
def nominal_of(memory: np.ndarray) -> tuple[float, ...]:
    """Return the nominal state (16) of a memory; Python computes faster with its own numbers."""
    q_w, q_x, q_y, q_z = float(memory[0]), float(memory[1]), float(memory[2]), float(memory[3])
    p, v = three_of(memory, 4), three_of(memory, 7)
    return (q_w, q_x, q_y, q_z) + p + v + three_of(memory, 10) + three_of(memory, 13)


@register_jitable
def covariance_of(memory: np.ndarray) -> np.ndarray:
    """Return P (15, 15) of a memory, a view."""
    return memory[COVARIANCE_INDEX:INNOVATIONS_INDEX].reshape(ERRORS, ERRORS)


@register_jitable
def innovations_of(memory: np.ndarray) -> np.ndarray:
    """Return innovations and variances (10, 2) of a memory, a view."""
    return memory[INNOVATIONS_INDEX:EKF_MEMORY_SIZE].reshape(MEASUREMENT_CHANNELS, 2)


@register_jitable
def three_of(numbers: Numbers, at: int) -> Vector3:
    """Return three of some numbers, from a place on."""
    return float(numbers[at]), float(numbers[at + 1]), float(numbers[at + 2])
