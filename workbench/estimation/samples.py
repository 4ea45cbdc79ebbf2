"""Samples for an estimator between two of its updates, and positions of the sensors."""

from typing import NamedTuple

import numpy as np

from workbench.common.vectors import Numbers

# Places in an array of samples, which begins with those of the IMU (6): means of angular velocity
# [rad/s] and specific force [m/s²] since the update before, in B. Each other sensor has 1 for a new
# sample or 0, then values.
GPS = 6
"""Age [s], position and velocity of the antenna in W [m, m/s] (7)."""
BAROMETER = 14
"""Height [m]."""
MAGNETOMETER = 16
"""Field in B [T] (3)."""
RANGE_FINDER = 20
"""Distance [m]."""
AGES = 22
"""Ages of the samples of barometer, magnetometer and range finder (3) [s]."""
SAMPLE_ARRAY_SIZE = 25
"""Size of the array."""


class Mounting(NamedTuple):
    """Positions of sensors in B [m], and references of their measurements.

    Attributes:
        p_BI: of the IMU (3).
        p_BG: of the GPS antenna (3).
        p_BP: of the barometer (3).
        p_BR: of the range finder (3).
        n_BR: unit direction of its beam (3).
        m_W: magnetic field (3) [T].
    """

    p_BI: Numbers = (0.0, 0.0, 0.0)
    p_BG: Numbers = (0.0, 0.0, 0.0)
    p_BP: Numbers = (0.0, 0.0, 0.0)
    p_BR: Numbers = (0.0, 0.0, 0.0)
    n_BR: Numbers = (0.0, 0.0, -1.0)
    m_W: Numbers = (0.0, 2e-5, -4e-5)

    def packed(self) -> np.ndarray:
        """Return all of it as an array (18), in this order."""
        return np.concatenate([np.asarray(part, dtype=float) for part in self])
