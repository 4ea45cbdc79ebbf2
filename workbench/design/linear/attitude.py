"""Three small angles in place of a quaternion, and axes that turn with the heading.

A small rotation from trim is a vector in W: q = (1, angles / 2) q_trim to first order.
"""

from collections.abc import Sequence

import numpy as np


def angle_seeds(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of a quaternion (4) by the three small angles, (4, 3)."""
    w, x, y, z = q_WB
    return 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])


def angles_of(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of the three small angles by a quaternion's change, (3, 4)."""
    return 4.0 * angle_seeds(q_WB).T / float(q_WB @ q_WB)


def state_seeds(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of a plant state (13) by angles, place, w and v, (13, 12)."""
    seeds = np.zeros((13, 12))
    seeds[0:4, 0:3] = angle_seeds(q_WB)
    seeds[4:13, 3:12] = np.eye(9)
    return seeds


def reduced(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of angles, place, w and v by a plant state, (12, 13)."""
    rows = np.zeros((12, 13))
    rows[0:3, 0:4] = angles_of(q_WB)
    rows[3:12, 4:13] = np.eye(9)
    return rows


def heading_turn(angle: float, vectors: int) -> np.ndarray:
    """Return the matrix that gives so many stacked vectors of W in axes turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.kron(np.eye(vectors), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


def turn_with_heading(A: np.ndarray, yaw_rate: float, places: Sequence[int]) -> None:
    """Bring a continuous model, of slopes in W, into axes that turn with the heading, in place.

    Angles stand first. With q = (1, a / 2) q_trim their slope is 2 (dq/dt) q_trim⁻¹, of which the
    trim's own turning brings one half, w x a / 2, and is missing where slopes of q were reduced.

    Args:
        A: rows and columns of states.
        yaw_rate: of the heading [rad/s].
        places: where each further vector of W begins.
    """
    cross = yaw_rate * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    A[0:3, 0:3] -= 0.5 * cross
    for place in places:
        A[place : place + 3, place : place + 3] -= cross
