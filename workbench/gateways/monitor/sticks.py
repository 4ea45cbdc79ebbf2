"""Keys as sticks: what a pilot at a keyboard wants at a time."""

import math
from dataclasses import dataclass

KEY_TIME = 0.3
"""A key counts for so long [s], as terminals do not tell when it is let go; see `DECAY_TIME`."""
DECAY_TIME = 0.3
"""Then it fades to nothing in this time [s]."""
SPEEDS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Speeds that + and - choose from [m/s]."""
TURN = 0.4
"""Yaw rate at a speed of 1 m/s and more [rad/s]."""

KEYS = {
    "w": ("ahead", 1.0),
    "s": ("ahead", -1.0),
    "a": ("aside", 1.0),
    "d": ("aside", -1.0),
    "up": ("climb", 1.0),
    "down": ("climb", -1.0),
    "left": ("turn", 1.0),
    "right": ("turn", -1.0),
}
"""What keys move: along the heading, to its left, up, and counter-clockwise."""

Asked = tuple[float, float, float, float]


@dataclass(frozen=True)
class _Push:
    """A stick that was pushed at a time [s]."""

    direction: float
    at: float


class Sticks:
    """Remembers keys, and says what they ask for.

    Args:
        level_speed: largest level speed that may be asked for [m/s].
        climb_rate: the same up or down [m/s].
        yaw_rate: the same of a turn [rad/s].

    Attributes:
        speed: at which keys fly [m/s].
    """

    def __init__(self, level_speed: float, climb_rate: float, yaw_rate: float) -> None:
        self.speed = 1.0
        self._limits = (level_speed, climb_rate, yaw_rate)
        self._pushes: dict[str, _Push] = {}

    def press(self, key: str, now: float) -> bool:
        """Push a stick by a key; return whether the key is one for that."""
        if key not in KEYS:
            return False
        stick, direction = KEYS[key]
        self._pushes[stick] = _Push(direction, now)
        return True

    def let_go(self) -> None:
        """Let all sticks go to their middle at once."""
        self._pushes.clear()

    def faster(self) -> None:
        """Choose the next larger speed."""
        self.speed = min((each for each in SPEEDS if each > self.speed), default=self.speed)

    def slower(self) -> None:
        """Choose the next smaller speed."""
        self.speed = max((each for each in SPEEDS if each < self.speed), default=self.speed)

    def asked(self, now: float, yaw: float) -> Asked:
        """Return the velocity in W [m/s] and the yaw rate [rad/s] that keys ask for.

        Args:
            now: time [s].
            yaw: heading of the drone [rad].
        """
        level, climb, turn = self._limits
        ahead, aside = self._push("ahead", now), self._push("aside", now)
        length = max(1.0, math.hypot(ahead, aside))  # both at once are no faster than one
        speed = min(self.speed, level) / length
        x = speed * (ahead * math.cos(yaw) - aside * math.sin(yaw))
        y = speed * (ahead * math.sin(yaw) + aside * math.cos(yaw))
        z = min(self.speed, climb) * self._push("climb", now)
        return x, y, z, min(TURN * min(self.speed, 1.0), turn) * self._push("turn", now)

    def _push(self, stick: str, now: float) -> float:
        push = self._pushes.get(stick)
        if push is None:
            return 0.0
        over = (now - push.at - KEY_TIME) / DECAY_TIME
        return push.direction * min(max(1.0 - over, 0.0), 1.0)
