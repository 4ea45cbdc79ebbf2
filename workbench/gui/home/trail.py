"""The trail of a flight: the latest points of its path."""

import math
from collections.abc import Iterable

MAX_TRAIL_POINTS = 600
"""Number of kept points; beyond it every other one is dropped, and the spacing doubles."""
MIN_TRAIL_SPACING_M = 0.02
"""Initial least distance between points [m]."""
TrailPoint = tuple[float, float, float]
"""A recorded position: its time [s], east and north in W [m]."""


class Trail:
    """Points of a path, the newest last."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Remove all points."""
        self.points: list[TrailPoint] = []
        self._spacing = MIN_TRAIL_SPACING_M

    def add(self, points: Iterable[TrailPoint]) -> bool:
        """Add points in order of time, and return whether any was kept."""
        kept = False
        for point in points:
            if not (math.isfinite(point[1]) and math.isfinite(point[2])):
                continue
            if self.points and math.dist(point[1:], self.points[-1][1:]) < self._spacing:
                continue
            self.points.append(point)
            kept = True
            if len(self.points) > MAX_TRAIL_POINTS:
                self.points = self.points[::2]
                self._spacing *= 2.0
        return kept
