"""The pinhole camera: which direction each pixel looks in, and where its depth puts a point.

The frame S of the sensor looks along x, with z up, as SDF has it. The optical frame C has the same
origin and looks along z, with x to the right and y down in the picture, as Drake, ROS and OpenCV
have it.
"""

import math
from typing import NamedTuple

import numpy as np

R_SC = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Orientation of the optical frame in the sensor's."""
R_SC.flags.writeable = False


class Pinhole(NamedTuple):
    """Intrinsics; pixel (u, v) is column and row from zero, and its centre is at whole numbers.

    A point (x, y, z) in the optical frame is seen at u = cx + fx x / z, v = cy + fy y / z.

    Attributes:
        width: pixels in a row.
        height: rows.
        fx: focal length in columns.
        fy: focal length in rows.
        cx: column of the optical axis.
        cy: row of the optical axis.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def points(self, depth: np.ndarray) -> np.ndarray:
        """Return the points seen in the optical frame, row by row, m x 3 [m].

        Args:
            depth: along the optical axis, height x width [m]; what is not finite saw nothing.
        """
        v, u = np.nonzero(np.isfinite(depth))
        z = depth[v, u].astype(float)
        return np.column_stack([(u - self.cx) / self.fx * z, (v - self.cy) / self.fy * z, z])


def make_pinhole(width: int, height: int, horizontal_fov: float) -> Pinhole:
    """Return a camera of square pixels whose optical axis goes through the picture's middle.

    Args:
        width: pixels in a row.
        height: rows.
        horizontal_fov: angle between the left edge of the first pixel and the right edge of the
            last, less than pi [rad].
    """
    focal = width / (2.0 * math.tan(horizontal_fov / 2.0))
    return Pinhole(width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0)
