"""Commands of sticks: velocities relative to the heading, and yaw rate.

The heading frame H is level at the drone: x points along the nose, y to its left, z up. Left stick:
up climbs, right turns clockwise. Right stick: up is forward, right is to the right.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

LEAST_WAY = 0.5
"""Least distance that limits the keys' speed near an obstacle [m]; see `WAY_TIME`."""
WAY_TIME = 1.0
"""Least time to reach an obstacle at the keys' speed [s]."""


@dataclass(frozen=True)
class StickCurve:
    """Curve with low sensitivity at the centre and full effect at the end.

    Attributes:
        sensitivity: effect of full stick, 0 .. 1.
        expo: share of the cubic part, 0 .. 1; 0 is a straight line.
        dead_band: share of the travel around the centre without effect, below 1.
    """

    sensitivity: float = 1.0
    expo: float = 0.0
    dead_band: float = 0.0

    def shaped(self, raw: float) -> float:
        """Return a stick's command, -1 .. 1.

        The travel beyond the dead band is rescaled, so that its edge has no jump and full stick
        stays full.

        Args:
            raw: deflection along one axis, -1 .. 1; larger values are clipped.
        """
        way = min(abs(raw), 1.0)
        if way <= self.dead_band:
            return 0.0
        way = (way - self.dead_band) / (1.0 - self.dead_band)
        gentle = (1.0 - self.expo) * way + self.expo * way**3
        return self.sensitivity * (gentle if raw > 0.0 else -gentle)


@dataclass(frozen=True)
class Stick:
    """A stick's position within its circle of radius 1.

    Attributes:
        x: to the right.
        y: away from the pilot, up on a screen.
    """

    x: float = 0.0
    y: float = 0.0

    @property
    def is_neutral(self) -> bool:
        """Whether it is centred."""
        return self.x == 0.0 and self.y == 0.0


MIDDLE = Stick()


@dataclass(frozen=True)
class Sticks:
    """Both sticks of a pilot.

    Attributes:
        left: climb and yaw.
        right: horizontal flight.
    """

    left: Stick = MIDDLE
    right: Stick = MIDDLE

    @property
    def are_neutral(self) -> bool:
        """Whether both are centred."""
        return self.left.is_neutral and self.right.is_neutral


NEUTRAL = Sticks()


def within_circle(x: float, y: float) -> Stick:
    """Return the stick at a position, limited to its circle."""
    way = math.hypot(x, y)
    if not math.isfinite(way):
        return MIDDLE
    return Stick(x, y) if way <= 1.0 else Stick(x / way, y / way)


@dataclass(frozen=True)
class Wish:
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


NOTHING = Wish()

SLACK = 1.001
"""Tolerance factor, so that a stick exactly at the limit does not count as beyond it."""


@dataclass(frozen=True)
class Bite:
    """A limit that a command exceeds.

    Attributes:
        what: limited quantity, in words.
        parameter: parameter with the limit.
        asked: commanded value, in SI.
        limit: limit, in SI.
        unit: unit of both.
    """

    what: str
    parameter: str
    asked: float
    limit: float
    unit: str


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

    def bites(self, wish: Wish) -> tuple[Bite, ...]:
        """Return the limits that a command exceeds."""
        level = math.hypot(wish.forward, wish.left)
        rows = (
            Bite("level speed", "max_speed", level, self.level, "m/s"),
            Bite("climb", "max_climb_rate", abs(wish.climb), self.climb, "m/s"),
            Bite("turning", "max_yaw_rate", abs(wish.yaw_rate), self.turn, "rad/s"),
        )
        return tuple(row for row in rows if row.asked > SLACK * row.limit)


@dataclass(frozen=True)
class Handling:
    """Sensitivity of the sticks.

    Attributes:
        speed: horizontal and vertical speed at full stick [m/s].
        yaw_rate: yaw rate at full stick [rad/s].
        curve: curve of all four axes.
    """

    speed: float = 8.0
    yaw_rate: float = 0.4
    curve: StickCurve = StickCurve()

    def near(self, clearance: float) -> "Handling":
        """Return the keys' handling at a distance from an obstacle [m]: a tap is a smaller step.

        Full stick would take `WAY_TIME` to the obstacle, and partial deflections are reduced by the
        same factor. Sticks that a hand can hold part-way are not reduced.
        """
        return replace(self, speed=min(self.speed, max(LEAST_WAY, clearance) / WAY_TIME))

    def wish(self, sticks: Sticks) -> Wish:
        """Return the sticks' command."""
        shaped = self.curve.shaped
        if sticks.are_neutral:
            return NOTHING
        return Wish(
            forward=self.speed * shaped(sticks.right.y),
            left=self.speed * shaped(-sticks.right.x),
            climb=self.speed * shaped(sticks.left.y),
            yaw_rate=self.yaw_rate * shaped(-sticks.left.x),
        )


def heading_velocity(v_WB: tuple[float, ...], yaw: float) -> tuple[float, float, float]:
    """Return a velocity in W as forward, left and up for a drone with a given yaw [rad]."""
    c, s = math.cos(yaw), math.sin(yaw)
    return c * v_WB[0] + s * v_WB[1], -s * v_WB[0] + c * v_WB[1], v_WB[2]
