"""Derivatives by small rotations: how AutoDiff values of a motion begin and are read."""

from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient

MOTION_STATE_SIZE = 12
"""Angles, position, angular velocity and velocity, all in W."""


def autodiff_constants(values: Iterable[float]) -> np.ndarray:
    """Return numbers as AutoDiff values without derivatives."""
    return np.array([AutoDiffXd(value) for value in values])


def gradient(values: Iterable[float], columns: int) -> np.ndarray:
    """Return the derivatives of AutoDiff values; those of plain numbers are 0."""
    found = ExtractGradient(autodiff_values(values))
    return found if found.shape[1] else np.zeros((found.shape[0], columns))


def autodiff_values(values: Iterable[float]) -> np.ndarray:
    """Return values as AutoDiff numbers; a saturated one may have become a plain number."""
    flat = np.array(values, dtype=object).ravel()
    return np.array([v if isinstance(v, AutoDiffXd) else AutoDiffXd(v) for v in flat])


def angle_seeds(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of a quaternion (4) by the three small angles, (4, 3)."""
    w, x, y, z = q_WB
    return 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])


def angles_of(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of the three small angles by a quaternion's change, (3, 4)."""
    return 4.0 * angle_seeds(q_WB).T / float(q_WB @ q_WB)


def state_seeds(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of a plant state (13) by angles, position, w and v, (13, 12)."""
    seeds = np.zeros((13, 12))
    seeds[0:4, 0:3] = angle_seeds(q_WB)
    seeds[4:13, 3:12] = np.eye(9)
    return seeds


def reduced_state_seeds(q_WB: np.ndarray) -> np.ndarray:
    """Return the derivatives of angles, position, w and v by a plant state, (12, 13)."""
    rows = np.zeros((12, 13))
    rows[0:3, 0:4] = angles_of(q_WB)
    rows[3:12, 4:13] = np.eye(9)
    return rows


def heading_turn(angle: float, vectors: int) -> np.ndarray:
    """Return the matrix that turns a number of stacked vectors in W to axes rotated by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.kron(np.eye(vectors), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


def turn_with_heading(A: np.ndarray, yaw_rate: float, places: Sequence[int]) -> None:
    """Transform a continuous model from W to axes that turn with the heading, in place.

    Angles come first. With q = (1, a / 2) q_trim their derivative is 2 (dq/dt) q_trim⁻¹. One half,
    w x a / 2, comes from the turn of the trim itself, and is missing in reduced derivatives of q.

    Args:
        A: rows and columns of states.
        yaw_rate: of the heading [rad/s].
        places: index of each further vector in W.
    """
    cross = yaw_rate * np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    A[0:3, 0:3] -= 0.5 * cross
    for place in places:
        A[place : place + 3, place : place + 3] -= cross
