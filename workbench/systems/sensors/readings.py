"""What sensors measured, as frozen records: ready for a screen, a log or a client.

Times are simulated [s]; W is east-north-up, S the sensor's frame.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.systems.sensors.pinhole import R_SC, Pinhole
from workbench.systems.sensors.scan_pattern import ScanPattern

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Reading:
    """What all readings have: when the sample was taken [s], and its sensor's frame."""

    stamp: float
    frame: str


@dataclass(frozen=True, eq=False)
class DepthImage(Reading):
    """A picture of a depth camera; its arrays cannot be written to.

    The frame S is the sensor's, looking along x; the optical frame C of pictures has the same
    origin and looks along z, see `pinhole`.

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
        """Return the same picture: it never changes, and Drake copies state."""
        return self

    def points(self) -> np.ndarray:
        """Return the point cloud in the optical frame C, row by row of the picture, m x 3 [m]."""
        return self.pinhole.points(self.depth)

    def points_S(self) -> np.ndarray:
        """Return the point cloud in the sensor's frame S, m x 3 [m]."""
        return self.points() @ R_SC.T

    def points_W(self) -> np.ndarray:
        """Return the point cloud in the world, m x 3 [m]."""
        return self.p_WS + self.points_S() @ self.R_WS.T


@dataclass(frozen=True)
class ImuReading(Reading):
    """Of an IMU, along the axes of S.

    Attributes:
        specific_force: acceleration without gravity, at rest g upwards [m/s²].
        angular_velocity: of S in W [rad/s].
        q_WS: orientation of S in W, a unit quaternion (w, x, y, z).
    """

    specific_force: Triple
    angular_velocity: Triple
    q_WS: tuple[float, float, float, float]


@dataclass(frozen=True)
class GpsReading(Reading):
    """Of satellite navigation, for the antenna.

    Attributes:
        latitude: geodetic, on WGS84 [rad].
        longitude: [rad].
        altitude: above the ellipsoid [m].
        velocity: east, north and up, as these are at the home [m/s].
    """

    latitude: float
    longitude: float
    altitude: float
    velocity: Triple


@dataclass(frozen=True)
class BarometerReading(Reading):
    """Of a barometer.

    Attributes:
        pressure: of the air [Pa].
        altitude: above the home, as the standard atmosphere has it for this pressure [m].
    """

    pressure: float
    altitude: float


@dataclass(frozen=True)
class MagnetometerReading(Reading):
    """Of a magnetometer.

    Attributes:
        magnetic_field: along the axes of S [T].
    """

    magnetic_field: Triple


@dataclass(frozen=True)
class RangeReading(Reading):
    """Of a range finder.

    Attributes:
        distance: along the sensor's x to what is first there [m]; inf where nothing is within
            range, -inf where something is nearer than that.
        min_range: least distance it measures [m].
        max_range: largest [m].
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
        """Return the same scan: it never changes."""
        return self

    @property
    def returns(self) -> int:
        """How many rays met something within range."""
        return int(np.isfinite(self.ranges).sum())

    @property
    def nearest(self) -> float:
        """The shortest range of a return [m], infinite without any."""
        return float(np.min(self.ranges, where=np.isfinite(self.ranges), initial=np.inf))

    @property
    def nearest_direction(self) -> Triple:
        """Unit vector in S along which that was measured, zero without any return."""
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


def fixed(array: np.ndarray) -> np.ndarray:
    """Return the array, which nobody can write to any more."""
    array.flags.writeable = False
    return array
