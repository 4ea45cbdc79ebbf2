"""The flight's own limits, which hold besides the sticks' scale."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.gui.joystick.piloting import Wish

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
    """The fastest that the flight flies, whoever asks; infinite where that is not known.

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
