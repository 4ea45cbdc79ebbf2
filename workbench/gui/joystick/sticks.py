"""Where two sticks are, whatever moves them."""

import math
from dataclasses import dataclass


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
