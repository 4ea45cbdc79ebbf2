"""Samples for an estimator between two of its updates, and positions of the sensors."""

from typing import Any, NamedTuple

import numpy as np

Signal = Any
"""A sequence of scalars: a list in Python, an array in compiled code."""

IMU, GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER, AGES, SAMPLES = 0, 6, 14, 16, 20, 22, 25
"""Places in an array of samples, and its size: of the IMU mean angular velocity [rad/s] and mean
specific force [m/s²] since the update before, in B (6); of all others whether there is a new sample
(1 or 0) and then: of the GPS its age [s], place and velocity of the antenna in W [m, m/s] (7); of
the barometer the height [m]; of the magnetometer the field in B [T] (3); of the range finder the
distance [m]; and last the ages of these three (3) [s]."""


class Mounting(NamedTuple):
    """Where sensors are mounted, and what they look at; places are in B [m].

    Attributes:
        p_BI: of the IMU (3).
        p_BG: of the GPS antenna (3).
        p_BP: of the barometer (3).
        p_BR: of the range finder (3).
        n_BR: unit direction of its beam (3).
        m_W: magnetic field (3) [T].
    """

    p_BI: Signal = (0.0, 0.0, 0.0)
    p_BG: Signal = (0.0, 0.0, 0.0)
    p_BP: Signal = (0.0, 0.0, 0.0)
    p_BR: Signal = (0.0, 0.0, 0.0)
    n_BR: Signal = (0.0, 0.0, -1.0)
    m_W: Signal = (0.0, 2e-5, -4e-5)

    def packed(self) -> np.ndarray:
        """Return all of it as an array (18), in this order."""
        return np.concatenate([np.asarray(part, dtype=float) for part in self])
