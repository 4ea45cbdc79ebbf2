"""Obstacles as a map draws them: seen from above, in plain numbers; no Drake."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Course:
    """Where something that moves is; it moves straight and evenly between the corners.

    Attributes:
        times: of the corners [s], from 0 on, growing.
        corners: x, y, z [m] and yaw [rad] at these times.
        repeat: whether it begins again at the end, where it is as it began; else it stays there.
    """

    times: tuple[float, ...]
    corners: tuple[tuple[float, float, float, float], ...]
    repeat: bool

    def at(self, time: float) -> tuple[float, float, float, float]:
        """Return x, y, z [m] and yaw [rad] in W at a time of the flight [s]."""
        if self.repeat:
            time = math.fmod(time, self.times[-1])
        x, y, z, yaw = (np.interp(time, self.times, row) for row in np.transpose(self.corners))
        return float(x), float(y), float(z), float(yaw)


@dataclass(frozen=True)
class Outline:
    """A convex part of an obstacle from above.

    Attributes:
        name: of the obstacle.
        corners: x, y of the corners, counter-clockwise [m]; in W, or where it moves in its frame.
        low: height of its lowest point, likewise [m].
        high: of its highest.
        course: along which it moves, None where it stands.
    """

    name: str
    corners: tuple[tuple[float, float], ...]
    low: float
    high: float
    course: Course | None = None

    def at(self, time: float) -> "Outline":
        """Return the outline in W, of what stands, at a time of the flight [s]."""
        if self.course is None:
            return self
        x, y, z, yaw = self.course.at(time)
        c, s = math.cos(yaw), math.sin(yaw)
        corners = tuple((x + c * p - s * q, y + s * p + c * q) for p, q in self.corners)
        return Outline(self.name, corners, self.low + z, self.high + z)

    def holds(self, x: float, y: float) -> bool:
        """Return whether a place in W [m] is inside, of what stands."""
        before = (*self.corners[-1:], *self.corners[:-1])
        return all(
            (b[0] - a[0]) * (y - a[1]) >= (b[1] - a[1]) * (x - a[0])
            for a, b in zip(before, self.corners, strict=True)
        )
