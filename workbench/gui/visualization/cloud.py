"""A lidar's cloud: points from ranges, and where they are seen from a side."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.gui.visualization.frame_tree import Pose


@dataclass(frozen=True, eq=False)
class CloudRays:
    """The rays of a cloud on the wire.

    Attributes:
        directions_S: unit vectors in the sensor's frame (n, 3).
        sensor_in_B: pose of the sensor.
        max_range: largest that is measured [m].
    """

    directions_S: np.ndarray
    sensor_in_B: Pose
    max_range: float

    def points_B(self, ranges: np.ndarray) -> np.ndarray:
        """Return the points of ranges (n) that met something, in B (m, 3) [m]."""
        seen = np.isfinite(ranges)
        points: np.ndarray = (
            self.sensor_in_B.p
            + (ranges[seen, None] * self.directions_S[seen]) @ self.sensor_in_B.R.T
        )
        return points


def rays_from(about: Mapping[str, object]) -> CloudRays:
    """Return the rays that a topic describes: layer by layer, angles as first, step and count."""
    azimuths, elevations = _angles(about["azimuths"]), _angles(about["elevations"])
    layer, column = np.meshgrid(elevations, azimuths, indexing="ij")
    level = np.cos(layer)
    directions = np.stack([level * np.cos(column), level * np.sin(column), np.sin(layer)], axis=2)
    p_BS, R_BS = np.array(about["p_BS"], dtype=float), np.array(about["R_BS"], dtype=float)
    ends = about["range"]
    assert isinstance(ends, Sequence)
    return CloudRays(directions.reshape(-1, 3), Pose(p_BS, R_BS), float(ends[1]))


def _angles(said: object) -> np.ndarray:
    assert isinstance(said, Sequence)
    first, step, count = said
    angles: np.ndarray = float(first) + float(step) * np.arange(int(count))
    return angles


@dataclass(frozen=True)
class Viewpoint:
    """From where a cloud is seen.

    Attributes:
        turn: about z; at 0 the eye is behind, and x goes away from it [rad].
        tilt: of the eye above the level; a quarter turn looks straight down [rad].
        width: that is seen across [m].
    """

    turn: float = 0.0
    tilt: float = math.pi / 2
    width: float = 40.0

    def axes(self) -> np.ndarray:
        """Return right, up and away of the picture, as rows (3, 3)."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        ct, st = math.cos(self.tilt), math.sin(self.tilt)
        ahead = np.array([c, s, 0.0])
        right = np.array([s, -c, 0.0])
        up = st * ahead + ct * np.array([0.0, 0.0, 1.0])
        away = ct * ahead - st * np.array([0.0, 0.0, 1.0])
        return np.vstack([right, up, away])

    def project(self, points: np.ndarray, width: float, height: float) -> np.ndarray:
        """Return pixels right and down, and the distance away, of points (n, 3)."""
        seen = points @ self.axes().T
        scale = width / self.width
        seen[:, 0] = 0.5 * width + scale * seen[:, 0]
        seen[:, 1] = 0.5 * height - scale * seen[:, 1]
        return seen


TOP = Viewpoint()
SIDE = Viewpoint(turn=math.pi / 2, tilt=0.0)
SLANTED = Viewpoint(turn=math.radians(25.0), tilt=math.radians(32.0))


def paint_points(
    seen: np.ndarray, colours: np.ndarray, ground: int, width: int, height: int, size: int
) -> np.ndarray:
    """Return a picture 0xffrrggbb (height, width) of projected points, the nearest on top.

    Args:
        seen: pixels right and down, and distance away (n, 3).
        colours: of the points (n).
        ground: colour behind them.
        width: of the picture [pixels].
        height: of it.
        size: of a point [pixels].
    """
    picture = np.full((height, width), ground, dtype=np.uint32)
    order = np.argsort(-seen[:, 2])
    u, v = seen[order, 0].astype(np.intp), seen[order, 1].astype(np.intp)
    inside = (u >= 0) & (u < width - size) & (v >= 0) & (v < height - size)
    u, v, ink = u[inside], v[inside], colours[order][inside]
    for down in range(size):
        for right in range(size):
            picture[v + down, u + right] = ink
    return picture
