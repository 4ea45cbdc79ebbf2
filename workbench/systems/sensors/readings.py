"""Measurements of sensors as frozen records, for screens, logs and clients.

Times are simulated [s]; W is east-north-up, S the sensor's frame.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.link.picture import Pinhole
from workbench.systems.sensors.scan_pattern import ScanPattern

R_SC = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Orientation of the optical frame in the sensor's."""
R_SC.flags.writeable = False


def seen_points(pinhole: Pinhole, depth: np.ndarray) -> np.ndarray:
    """Return the points seen in the optical frame, row by row, m x 3 [m].

    Args:
        pinhole: of the camera.
        depth: along the optical axis, height x width [m]; not finite without a return.
    """
    v, u = np.nonzero(np.isfinite(depth))
    z = depth[v, u].astype(float)
    x, y = (u - pinhole.cx) / pinhole.fx * z, (v - pinhole.cy) / pinhole.fy * z
    return np.column_stack([x, y, z])


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


ReadingVector = tuple[float, float, float]


@dataclass(frozen=True)
class Reading:
    """The common fields of all readings: time of the sample [s], and frame of the sensor."""

    stamp: float
    frame: str


@dataclass(frozen=True, eq=False)
class DepthImage(Reading):
    """A picture of a depth camera; its arrays cannot be written to.

    The frame S is the sensor's, looking along x; the optical frame C of pictures has the same
    origin and looks along z, see `Pinhole`.

    Attributes:
        p_WS: position of the camera [m].
        R_WS: its orientation, 3 x 3.
        pinhole: intrinsics.
        depth: along the optical axis, height x width, 32-bit [m]; inf where nothing is within
            range, -inf where something is nearer than that.
        colour: red, green and blue, height x width x 3 bytes; None if it has no colour.
    """

    p_WS: np.ndarray
    R_WS: np.ndarray
    pinhole: Pinhole
    depth: np.ndarray
    colour: np.ndarray | None

    def __deepcopy__(self, memo: dict[int, Any]) -> "DepthImage":
        """Return itself, because it is immutable: Drake copies state."""
        return self

    def points(self) -> np.ndarray:
        """Return the point cloud in the optical frame C, row by row of the picture, m x 3 [m]."""
        return seen_points(self.pinhole, self.depth)

    def points_S(self) -> np.ndarray:
        """Return the point cloud in the sensor's frame S, m x 3 [m]."""
        return self.points() @ R_SC.T

    def points_W(self) -> np.ndarray:
        """Return the point cloud in the world, m x 3 [m]."""
        return self.p_WS + self.points_S() @ self.R_WS.T


@dataclass(frozen=True)
class ImuReading(Reading):
    """Reading of an IMU, along the axes of S.

    Attributes:
        specific_force: acceleration without gravity, at rest g upwards [m/s²].
        angular_velocity: of S in W [rad/s].
        q_WS: orientation of S in W, a unit quaternion (w, x, y, z).
    """

    specific_force: ReadingVector
    angular_velocity: ReadingVector
    q_WS: tuple[float, float, float, float]


@dataclass(frozen=True)
class GpsReading(Reading):
    """Reading of a GPS receiver, for the antenna.

    Attributes:
        latitude: geodetic, on WGS84 [rad].
        longitude: [rad].
        altitude: above the ellipsoid [m].
        velocity: east, north and up, as these are at the home [m/s].
    """

    latitude: float
    longitude: float
    altitude: float
    velocity: ReadingVector


@dataclass(frozen=True)
class BarometerReading(Reading):
    """Reading of a barometer.

    Attributes:
        pressure: of the air [Pa].
        altitude: above the home, as the standard atmosphere has it for this pressure [m].
    """

    pressure: float
    altitude: float


@dataclass(frozen=True)
class MagnetometerReading(Reading):
    """Reading of a magnetometer.

    Attributes:
        magnetic_field: along the axes of S [T].
    """

    magnetic_field: ReadingVector


@dataclass(frozen=True)
class RangeReading(Reading):
    """Reading of a range finder.

    Attributes:
        distance: to the first surface along the sensor's x [m]; inf if nothing is within range,
            -inf if something is nearer.
        min_range: smallest measured distance [m].
        max_range: largest measured distance [m].
    """

    distance: float
    min_range: float
    max_range: float


@dataclass(frozen=True, eq=False)
class LidarScan(Reading):
    """All ranges of a lidar at one moment, layer by layer; its arrays cannot be written to.

    Attributes:
        p_WS: position of the sensor [m].
        R_WS: its orientation, 3 x 3.
        pattern: directions of the rays.
        ranges: layers x columns [m]; inf where nothing is within range, -inf where something is
            nearer than that.
    """

    p_WS: np.ndarray
    R_WS: np.ndarray
    pattern: ScanPattern
    ranges: np.ndarray

    def __deepcopy__(self, memo: dict[int, Any]) -> "LidarScan":
        """Return itself, because it is immutable."""
        return self

    @property
    def returns(self) -> int:
        """Number of rays with a return."""
        return int(np.isfinite(self.ranges).sum())

    @property
    def nearest(self) -> float:
        """The shortest range of a return [m], infinite without any."""
        return float(np.min(self.ranges, where=np.isfinite(self.ranges), initial=np.inf))

    @property
    def nearest_direction(self) -> ReadingVector:
        """Unit vector of that ray in S, zero without any return."""
        if not self.returns:
            return (0.0, 0.0, 0.0)
        nearest = np.where(np.isfinite(self.ranges), self.ranges, np.inf).argmin()
        x, y, z = self.pattern.directions_S[nearest].tolist()
        return (x, y, z)

    def points_S(self) -> np.ndarray:
        """Return the point cloud in the sensor's frame S, layer by layer, m x 3 [m]."""
        ranges = self.ranges.ravel()
        seen = np.isfinite(ranges)
        return ranges[seen, None] * self.pattern.directions_S[seen]

    def points_W(self) -> np.ndarray:
        """Return the point cloud in the world, m x 3 [m]."""
        return self.p_WS + self.points_S() @ self.R_WS.T


def read_only(array: np.ndarray) -> np.ndarray:
    """Return the array, made read-only."""
    array.flags.writeable = False
    return array
