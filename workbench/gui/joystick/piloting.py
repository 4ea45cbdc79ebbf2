"""Commands of sticks: velocities relative to the heading, and yaw rate.

The heading frame H is level at the drone: x points along the nose, y to its left, z up. Left stick:
up climbs, right turns clockwise. Right stick: up is forward, right is to the right.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

MIN_GENTLE_CLEARANCE_M = 0.5
"""Least distance that limits the speed near an obstacle [m]; see `MIN_OBSTACLE_TIME_S`."""
MIN_OBSTACLE_TIME_S = 1.0
"""Least time to reach an obstacle at full stick by keys or mouse [s]."""


def shaped_deflection(raw: float, expo: float, dead_band: float) -> float:
    """Return the effect of a stick's deflection, -1 .. 1: gentle at the centre, full at the end.

    The travel beyond the dead band is rescaled, so that its edge has no jump and full stick stays
    full.

    Args:
        raw: deflection along one axis, -1 .. 1; larger values are clipped.
        expo: share of the cubic part, 0 .. 1; 0 is a straight line.
        dead_band: share of the travel around the centre without effect, below 1.
    """
    way = min(abs(raw), 1.0)
    if way <= dead_band:
        return 0.0
    way = (way - dead_band) / (1.0 - dead_band)
    return math.copysign((1.0 - expo) * way + expo * way**3, raw)


class Sticks(NamedTuple):
    """Deflections of a pilot's two sticks, -1 .. 1; each stick stays in its circle of radius 1.

    Attributes:
        turn: of the left stick to the right.
        climb: of the left stick away from the pilot, up on a screen.
        right: of the right stick to the right.
        forward: of the right stick away from the pilot.
    """

    turn: float = 0.0
    climb: float = 0.0
    right: float = 0.0
    forward: float = 0.0


CENTRED_STICKS = Sticks()
StickPosition = tuple[float, float]
"""Deflection of one stick to the right, and away from the pilot."""


def within_circle(x: float, y: float) -> StickPosition:
    """Return the position of a stick, limited to its circle."""
    way = math.hypot(x, y)
    if not math.isfinite(way):
        return 0.0, 0.0
    return (x, y) if way <= 1.0 else (x / way, y / way)


@dataclass(frozen=True)
class StickCommand:
    """Command to the drone.

    Attributes:
        forward: velocity along the nose [m/s].
        left: velocity to the left of it [m/s].
        climb: velocity up [m/s].
        yaw_rate: yaw rate, counter-clockwise seen from above [rad/s].
    """

    forward: float = 0.0
    left: float = 0.0
    climb: float = 0.0
    yaw_rate: float = 0.0

    def velocity(self, yaw: float) -> tuple[float, float, float]:
        """Return the velocity in W [m/s] of a drone with a given yaw [rad]."""
        c, s = math.cos(yaw), math.sin(yaw)
        return c * self.forward - s * self.left, s * self.forward + c * self.left, self.climb


ZERO_STICK_COMMAND = StickCommand()


@dataclass(frozen=True)
class FlightLimits:
    """Limits of the flight's speed, for every pilot; infinite if unknown.

    Attributes:
        level: largest horizontal speed [m/s].
        climb: largest speed up or down [m/s].
        turn: largest yaw rate [rad/s].
    """

    level: float = math.inf
    climb: float = math.inf
    turn: float = math.inf

    def after(self, values: Mapping[str, float]) -> "FlightLimits":
        """Return the limits after a change of live parameters, by name."""
        return FlightLimits(
            values.get("max_speed", self.level),
            values.get("max_climb_rate", self.climb),
            values.get("max_yaw_rate", self.turn),
        )


@dataclass(frozen=True)
class Handling:
    """Sensitivity of the sticks.

    Attributes:
        speed: horizontal and vertical speed at full stick [m/s].
        yaw_rate: yaw rate at full stick [rad/s].
        sensitivity: effect of full stick, 0 .. 1.
        expo: share of the cubic part of all four axes, see `shaped_deflection`.
        dead_band: share of the travel without effect, likewise.
    """

    speed: float = 8.0
    yaw_rate: float = 0.4
    sensitivity: float = 1.0
    expo: float = 0.0
    dead_band: float = 0.0

    def shaped(self, raw: float) -> float:
        """Return the effect of a deflection along one axis, as a share of full speed, -1 .. 1."""
        return self.sensitivity * shaped_deflection(raw, self.expo, self.dead_band)

    def near(self, clearance: float) -> "Handling":
        """Return the handling of keys and mouse at a distance from an obstacle [m].

        Full stick would take `MIN_OBSTACLE_TIME_S` to the obstacle, and partial deflections are
        reduced by the same factor. The sticks of a game pad are not reduced.
        """
        return replace(
            self,
            speed=min(self.speed, max(MIN_GENTLE_CLEARANCE_M, clearance) / MIN_OBSTACLE_TIME_S),
        )

    def wish(self, sticks: Sticks) -> StickCommand:
        """Return the sticks' command."""
        return StickCommand(
            forward=self.speed * self.shaped(sticks.forward),
            left=self.speed * self.shaped(-sticks.right),
            climb=self.speed * self.shaped(sticks.climb),
            yaw_rate=self.yaw_rate * self.shaped(-sticks.turn),
        )


def heading_velocity(v_WB: tuple[float, ...], yaw: float) -> tuple[float, float, float]:
    """Return a velocity in W as forward, left and up for a drone with a given yaw [rad]."""
    c, s = math.cos(yaw), math.sin(yaw)
    return c * v_WB[0] + s * v_WB[1], -s * v_WB[0] + c * v_WB[1], v_WB[2]
