"""What sticks ask of the drone: velocities along its heading, and how fast it turns.

The heading frame H stands level under the drone: x where the nose points, y to its left, z up.
Left stick: up climbs, right turns clockwise. Right stick: up is forward, right is to the right.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

LEAST_WAY = 0.5
"""Keys never ask for less than an obstacle at this distance takes a second to reach with [m]."""
WAY_TIME = 1.0
"""Near an obstacle keys ask for no speed that takes less time to it [s]."""


@dataclass(frozen=True)
class StickCurve:
    """Gentle around the middle, and full at the end.

    Attributes:
        sensitivity: share that full stick reaches, 0 .. 1.
        expo: share of the cubic part, 0 .. 1; 0 is a straight line.
        dead_band: share of the way around the middle that asks for nothing, below 1.
    """

    sensitivity: float = 1.0
    expo: float = 0.0
    dead_band: float = 0.0

    def shaped(self, raw: float) -> float:
        """Return what a stick asks for, -1 .. 1.

        What is beyond the dead band is stretched, so that nothing jumps at its edge and full stick
        stays full.

        Args:
            raw: how far it is pushed along one axis, -1 .. 1; what is beyond counts as full.
        """
        way = min(abs(raw), 1.0)
        if way <= self.dead_band:
            return 0.0
        way = (way - self.dead_band) / (1.0 - self.dead_band)
        gentle = (1.0 - self.expo) * way + self.expo * way**3
        return self.sensitivity * (gentle if raw > 0.0 else -gentle)


@dataclass(frozen=True)
class Stick:
    """A stick's place within its circle of radius 1.

    Attributes:
        x: to the right.
        y: away from the pilot, up on a screen.
    """

    x: float = 0.0
    y: float = 0.0

    @property
    def is_neutral(self) -> bool:
        """Whether it stands in its middle."""
        return self.x == 0.0 and self.y == 0.0


MIDDLE = Stick()


@dataclass(frozen=True)
class Sticks:
    """Both sticks of a pilot.

    Attributes:
        left: climbs and turns.
        right: flies level.
    """

    left: Stick = MIDDLE
    right: Stick = MIDDLE

    @property
    def are_neutral(self) -> bool:
        """Whether both stand in their middle."""
        return self.left.is_neutral and self.right.is_neutral


NEUTRAL = Sticks()


def within_circle(x: float, y: float) -> Stick:
    """Return the stick at a place, drawn back to its circle where that is outside."""
    way = math.hypot(x, y)
    if not math.isfinite(way):
        return MIDDLE
    return Stick(x, y) if way <= 1.0 else Stick(x / way, y / way)


@dataclass(frozen=True)
class Wish:
    """What is asked of the drone.

    Attributes:
        forward: where the nose points [m/s].
        left: of it [m/s].
        climb: up [m/s].
        yaw_rate: to the left, seen from above [rad/s].
    """

    forward: float = 0.0
    left: float = 0.0
    climb: float = 0.0
    yaw_rate: float = 0.0

    def velocity(self, yaw: float) -> tuple[float, float, float]:
        """Return the velocity in W [m/s] of a drone that points to a yaw [rad]."""
        c, s = math.cos(yaw), math.sin(yaw)
        return c * self.forward - s * self.left, s * self.forward + c * self.left, self.climb


NOTHING = Wish()

SLACK = 1.001
"""So that a stick at exactly the limit is not said to be beyond it."""


@dataclass(frozen=True)
class Bite:
    """A limit that a wish is beyond.

    Attributes:
        what: is limited, in words.
        parameter: that says so.
        asked: too much, in SI.
        limit: in SI.
        unit: of both.
    """

    what: str
    parameter: str
    asked: float
    limit: float
    unit: str


@dataclass(frozen=True)
class FlightLimits:
    """The flight's largest speeds, for every pilot; infinite where unknown.

    Attributes:
        level: largest level speed [m/s].
        climb: largest speed up or down [m/s].
        turn: largest yaw rate [rad/s].
    """

    level: float = math.inf
    climb: float = math.inf
    turn: float = math.inf

    def after(self, values: Mapping[str, float]) -> "FlightLimits":
        """Return the limits once live parameters, by name, have these values."""
        return FlightLimits(
            values.get("max_speed", self.level),
            values.get("max_climb_rate", self.climb),
            values.get("max_yaw_rate", self.turn),
        )

    def bites(self, wish: Wish) -> tuple[Bite, ...]:
        """Return where a wish asks for more than is flown."""
        level = math.hypot(wish.forward, wish.left)
        rows = (
            Bite("level speed", "max_speed", level, self.level, "m/s"),
            Bite("climb", "max_climb_rate", abs(wish.climb), self.climb, "m/s"),
            Bite("turning", "max_yaw_rate", abs(wish.yaw_rate), self.turn, "rad/s"),
        )
        return tuple(row for row in rows if row.asked > SLACK * row.limit)


@dataclass(frozen=True)
class Handling:
    """How strongly sticks are felt.

    Attributes:
        speed: that full stick asks for, level and up [m/s].
        yaw_rate: that full stick asks for [rad/s].
        curve: of all four axes.
    """

    speed: float = 8.0
    yaw_rate: float = 0.4
    curve: StickCurve = StickCurve()

    def near(self, clearance: float) -> "Handling":
        """Return the handling of keys at a distance from an obstacle [m]: a tap is a smaller step.

        Full stick would take `WAY_TIME` to the obstacle, so all of the way to full stick is as much
        gentler. Sticks that a hand can hold in between are not.
        """
        return replace(self, speed=min(self.speed, max(LEAST_WAY, clearance) / WAY_TIME))

    def wish(self, sticks: Sticks) -> Wish:
        """Return what sticks ask for."""
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
    """Return a velocity in W as forward, left and up of a drone that points to a yaw [rad]."""
    c, s = math.cos(yaw), math.sin(yaw)
    return c * v_WB[0] + s * v_WB[1], -s * v_WB[0] + c * v_WB[1], v_WB[2]
