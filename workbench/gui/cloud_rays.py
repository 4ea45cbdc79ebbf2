"""The rays of the lidar's cloud, and the points of their returns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.gui.charts.statistics import value_at
from workbench.gui.poses import Pose, rotation_from_angles
from workbench.gui.signals import Signals
from workbench.link.topics import PREFIX, Topic


@dataclass(frozen=True, eq=False)
class CloudRays:
    """The rays of a transmitted cloud.

    Attributes:
        directions_S: unit vectors in the sensor's frame (n, 3).
        sensor_in_B: pose of the sensor.
    """

    directions_S: np.ndarray
    sensor_in_B: Pose

    def points_B(self, ranges: np.ndarray) -> np.ndarray:
        """Return the points of ranges (n) with a return, in B (m, 3) [m]."""
        seen = np.isfinite(ranges)
        points: np.ndarray = (
            self.sensor_in_B.p
            + (ranges[seen, None] * self.directions_S[seen]) @ self.sensor_in_B.R.T
        )
        return points


def rays_from(about: Mapping[str, object]) -> CloudRays:
    """Return the rays that a topic describes: layer by layer, angles as first, step and count."""
    azimuths, elevations = _ray_angles(about["azimuths"]), _ray_angles(about["elevations"])
    layer, column = np.meshgrid(elevations, azimuths, indexing="ij")
    level = np.cos(layer)
    directions = np.stack([level * np.cos(column), level * np.sin(column), np.sin(layer)], axis=2)
    p_BS, R_BS = np.array(about["p_BS"], dtype=float), np.array(about["R_BS"], dtype=float)
    return CloudRays(directions.reshape(-1, 3), Pose(p_BS, R_BS))


def _ray_angles(said: object) -> np.ndarray:
    assert isinstance(said, Sequence)
    first, step, count = said
    angles: np.ndarray = float(first) + float(step) * np.arange(int(count))
    return angles


def find_rays(topics: Sequence[Topic]) -> CloudRays | None:
    """Return the rays of a flight's lidar, None without an active one."""
    topic = next((each for each in topics if each.name == f"{PREFIX}lidar_cloud"), None)
    return rays_from(topic.about) if topic is not None else None


def newest_points(signals: Signals, rays: CloudRays) -> np.ndarray:
    """Return the points of a lidar's last scan, in W (N, 3) [m]."""
    newest = signals.newest("lidar_cloud")
    stamp, ranges = newest.get("stamp"), newest.get("ranges")
    if not isinstance(ranges, tuple) or not isinstance(stamp, int):
        return np.empty((0, 3))
    place, angles = pose_at(signals, stamp * 1e-9)
    points: np.ndarray = rays.points_B(np.array(ranges)) @ rotation_from_angles(*angles).T + place
    return points


def pose_at(signals: Signals, time: float) -> tuple[list[float], list[float]]:
    """Return position [m] and roll, pitch, yaw [rad] at the time of a scan; 0 if unknown."""
    found = [
        value_at(*signals.series(f"position_data.{name}", time - 0.1), time)
        for name in ("x", "y", "z", "roll", "pitch", "yaw")
    ]
    known = [value if value == value else 0.0 for value in found]
    return known[:3], known[3:]
