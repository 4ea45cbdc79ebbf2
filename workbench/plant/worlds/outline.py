"""Obstacles for maps: seen from above, in plain numbers, without Drake."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ObstaclePath:
    """The path of a moving obstacle, at constant speed along straight lines between corners.

    Attributes:
        times: of the corners [s], from 0 on, increasing.
        corners: x, y, z [m] and yaw [rad] at these times.
        repeat: whether it starts again at the end, which then equals the start; else it stays.
    """

    times: tuple[float, ...]
    corners: tuple[tuple[float, float, float, float], ...]
    repeat: bool

    def at(self, time: float) -> tuple[float, float, float, float]:
        """Return x, y, z [m] and yaw [rad] in W at a flight time [s]."""
        if self.repeat:
            time = math.fmod(time, self.times[-1])
        x, y, z, yaw = (np.interp(time, self.times, row) for row in np.transpose(self.corners))
        return float(x), float(y), float(z), float(yaw)


@dataclass(frozen=True)
class Outline:
    """A convex part of an obstacle seen from above.

    Attributes:
        name: of the obstacle.
        corners: x, y of the corners, counter-clockwise [m]; in W, or in the frame of a moving one.
        low: height of its lowest point in the same frame [m].
        high: height of its highest point.
        course: path of a moving obstacle, else None.
    """

    name: str
    corners: tuple[tuple[float, float], ...]
    low: float
    high: float
    course: ObstaclePath | None = None

    def at(self, time: float) -> "Outline":
        """Return the static outline in W at a flight time [s]."""
        if self.course is None:
            return self
        x, y, z, yaw = self.course.at(time)
        c, s = math.cos(yaw), math.sin(yaw)
        corners = tuple((x + c * p - s * q, y + s * p + c * q) for p, q in self.corners)
        return Outline(self.name, corners, self.low + z, self.high + z)

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point in W [m] is inside a static outline."""
        before = (*self.corners[-1:], *self.corners[:-1])
        return all(
            (b[0] - a[0]) * (y - a[1]) >= (b[1] - a[1]) * (x - a[0])
            for a, b in zip(before, self.corners, strict=True)
        )
