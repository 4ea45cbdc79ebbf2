"""Positions of joints as linear models have them: small rotations in place of quaternions."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis, Quaternion

from workbench.design.linear.seeds import angle_seeds

_FREE_COUNT = 7
"""Number of positions of a joint with six freedoms: a quaternion w, x, y, z, and a place."""


class JointCoordinates:
    """The coordinates (j) of the positions of joints, as many as their velocities.

    That of a joint with one freedom is its position. A joint that leaves all six freedoms has a
    rotation vector [rad], then its place [m]; derivatives are by a rotation that is added to it.

    Args:
        counts: numbers of positions of the joints, in the order of the plant.
    """

    def __init__(self, counts: Sequence[int]) -> None:
        self._counts = tuple(counts)

    def positions(self, small: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the positions of the plant (q), and their derivatives by the coordinates (q, j).

        Args:
            small: the coordinates (j).
        """
        free = self._counts.count(_FREE_COUNT)
        found, derivatives = np.zeros(small.size + free), np.zeros((small.size + free, small.size))
        row = column = 0
        for count in self._counts:
            own = small[column : column + min(count, _FREE_COUNT - 1)]
            block, values = np.eye(own.size), own
            if count == _FREE_COUNT:
                quaternion = _quaternion(own[:3])
                values = np.concatenate([quaternion, own[3:]])
                block = np.zeros((count, own.size))
                block[:4, :3], block[4:, 3:] = angle_seeds(quaternion), np.eye(3)
            found[row : row + count] = values
            derivatives[row : row + count, column : column + own.size] = block
            row, column = row + count, column + own.size
        return found, derivatives

    def small(self, positions: np.ndarray) -> np.ndarray:
        """Return the coordinates (j) of positions of the plant (q)."""
        found, start = [np.zeros(0)], 0
        for count in self._counts:
            own = positions[start : start + count]
            start += count
            if count == _FREE_COUNT:
                turn = AngleAxis(Quaternion(own[:4] / np.linalg.norm(own[:4])))
                own = np.concatenate([turn.angle() * turn.axis(), own[4:]])
            found.append(own)
        return np.concatenate(found)

    def inverse(self, derivatives: np.ndarray) -> np.ndarray:
        """Return the derivatives of the coordinates by the positions (j, q).

        Args:
            derivatives: of `positions` (q, j), whose columns are orthogonal.
        """
        squares: np.ndarray = (derivatives**2).sum(axis=0)
        return derivatives.T / squares[:, None]


def _quaternion(turn: np.ndarray) -> np.ndarray:
    """Return the quaternion w, x, y, z of a rotation vector."""
    angle = float(np.linalg.norm(turn))
    axis = turn / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * axis)])
