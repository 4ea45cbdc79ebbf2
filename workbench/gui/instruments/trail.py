"""The way that a drone has flown, seen from above: few points, however long it was."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

MOST_POINTS = 600
"""That are kept; then every other one goes, and points are taken half as densely."""
FINEST = 0.02
"""Points nearer to each other than this are one, at the start [m]."""


@dataclass(frozen=True)
class TrailPoint:
    """Where it was.

    Attributes:
        time: when [s].
        east: in W [m].
        north: in W [m].
    """

    time: float
    east: float
    north: float


class Trail:
    """Points of a way, the newest last."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self.points: list[TrailPoint] = []
        self._spacing = FINEST

    def add(self, points: Iterable[TrailPoint]) -> bool:
        """Take points in the order of time, and return whether any was new enough to keep."""
        kept = False
        for point in points:
            if not (math.isfinite(point.east) and math.isfinite(point.north)):
                continue
            if self.points:
                last = self.points[-1]
                if math.hypot(point.east - last.east, point.north - last.north) < self._spacing:
                    continue
            self.points.append(point)
            kept = True
            if len(self.points) > MOST_POINTS:
                self.points = self.points[::2]
                self._spacing *= 2.0
        return kept

    def since(self, time: float) -> list[TrailPoint]:
        """Return the points from a time on, and the one before them."""
        first = next(
            (index for index, point in enumerate(self.points) if point.time >= time),
            len(self.points),
        )
        return self.points[max(0, first - 1) :]
