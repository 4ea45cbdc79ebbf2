"""A lidar's scan around a drone, seen from above; plain mathematics on arrays."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.gui.cloud_rays import rays_from
from workbench.link.topics import Topic

RING_SECTORS = 120
"""Number of sectors around the drone."""
GROUND_HEIGHT_M = 0.15
"""Returns below this height above the ground count as ground [m]..."""
GROUND_RANGE_SHARE = 0.03
"""...and those below this share of their range, because attitude and scan differ slightly in
time."""


@dataclass(frozen=True, eq=False)
class BearingRing:
    """Nearest returns by bearing, in the body frame B, from the lidar.

    Attributes:
        distances: horizontal distance of the nearest return in each sector [m]; inf without one.
        nearest: smallest of all ranges [m], inf without a return.
        bearing: its bearing, about the body's z from its x, to the left [rad].
        elevation: its elevation above the body's x-y plane [rad].
    """

    distances: np.ndarray
    nearest: float
    bearing: float
    elevation: float


EMPTY_RING = BearingRing(np.full(RING_SECTORS, np.inf), math.inf, 0.0, 0.0)
"""Ring before the first scan."""


def sector_bearings() -> np.ndarray:
    """Return the bearings of the sectors' centres (SECTORS) [rad]; the first is ahead."""
    return np.arange(RING_SECTORS) * (2.0 * math.pi / RING_SECTORS)


class RingScan:
    """Makes a ring of a cloud's payload.

    Args:
        topic: the cloud's topic, whose `about` has the ray directions and the lidar's pose.
    """

    def __init__(self, topic: Topic) -> None:
        about: Any = topic.about
        rays = rays_from(about)
        self._ranges_at = topic.fields[0].size
        directions = rays.directions_S @ rays.sensor_in_B.R.T
        bearings = np.arctan2(directions[:, 1], directions[:, 0])
        sectors = np.round(bearings / (2.0 * math.pi / RING_SECTORS)).astype(int) % RING_SECTORS
        # Rays in order of their sectors, so that a single reduction gives each minimum.
        self._order = np.argsort(sectors, kind="stable")
        self._sectors, self._first = np.unique(sectors[self._order], return_index=True)
        self._directions = directions[self._order]
        self._level = np.hypot(self._directions[:, 0], self._directions[:, 1])
        self._p_BS = rays.sensor_in_B.p
        self.least, self.most = (float(bound) for bound in about["range"])

    def ring(self, payload: bytes, height: float, down_B: Sequence[float]) -> BearingRing:
        """Return the ring of a payload, without ground returns.

        Args:
            payload: payload of the cloud's topic.
            height: height of the body's origin above the ground [m].
            down_B: direction of gravity in B, a unit vector.
        """
        ranges = np.frombuffer(payload, "<f4", offset=self._ranges_at)[self._order].astype(float)
        ranges[ranges < self.least] = self.least  # -inf: closer than the lidar can measure
        falls = self._directions @ np.array(down_B)
        with np.errstate(invalid="ignore"):  # inf - inf: no return is not the ground
            above = height - self._p_BS @ np.array(down_B) - ranges * falls
            ranges[above < GROUND_HEIGHT_M + GROUND_RANGE_SHARE * ranges] = np.inf
        distances = np.full(RING_SECTORS, np.inf)
        distances[self._sectors] = np.minimum.reduceat(ranges * self._level, self._first)
        index = int(np.argmin(ranges))
        if not math.isfinite(ranges[index]):
            return EMPTY_RING
        x, y, z = self._directions[index].tolist()
        return BearingRing(
            distances, float(ranges[index]), math.atan2(y, x), math.asin(max(-1.0, min(1.0, z)))
        )


def side_of(bearing: float) -> str:
    """Return the direction of a bearing [rad], to the left, in words."""
    words = (
        "ahead",
        "ahead left",
        "left",
        "behind left",
        "behind",
        "behind right",
        "right",
        "ahead right",
    )
    return words[round(bearing / (math.pi / 4.0)) % len(words)]
