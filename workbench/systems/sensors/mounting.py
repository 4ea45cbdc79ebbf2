"""Position and motion of a sensor, from the state of the plant."""

from typing import NamedTuple

import numpy as np


class SensorMotion(NamedTuple):
    """Motion of a sensor S that is fixed to the body B, in the world W.

    Attributes:
        q_WB: orientation of the body, unit quaternion (w, x, y, z).
        R_WB: the same as a matrix.
        p_BoSo_W: from the body's origin to the sensor's [m].
        p_WS: position [m].
        w_WB: angular velocity [rad/s].
        v_WS: velocity [m/s].
    """

    q_WB: np.ndarray
    R_WB: np.ndarray
    p_BoSo_W: np.ndarray
    p_WS: np.ndarray
    w_WB: np.ndarray
    v_WS: np.ndarray


def sensor_motion(state: np.ndarray, p_BS: np.ndarray) -> SensorMotion:
    """Return the motion of a sensor at `p_BS` [m] for a state of the plant (13)."""
    q_WB = state[:4] / np.linalg.norm(state[:4])
    R_WB = unit_rotation(q_WB)
    w_WB = state[7:10]
    p_BoSo_W = R_WB @ p_BS
    return SensorMotion(
        q_WB,
        R_WB,
        p_BoSo_W,
        state[4:7] + p_BoSo_W,
        w_WB,
        state[10:] + cross_product(w_WB, p_BoSo_W),
    )


def unit_rotation(q: np.ndarray) -> np.ndarray:
    """Return the rotation matrix of a unit quaternion (w, x, y, z)."""
    w, x, y, z = q.tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def cross_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b, ten times as fast as `np.cross` for three numbers."""
    a1, a2, a3 = a.tolist()
    b1, b2, b3 = b.tolist()
    return np.array([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])
