"""How a drone is tilted, as an artificial horizon shows it; plain mathematics."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

LADDER_STEP = 10
"""Between the lines of the pitch ladder [degrees]."""


@dataclass(frozen=True)
class Attitude:
    """The tilt of a body whose axes point forward, left and up.

    Both are signed as pilots have it. The angles of `roll_pitch_yaw` have the same bank, and the
    opposite sign for the nose: a rotation about the left axis lowers it.

    Attributes:
        nose_up: of the forward axis over the horizon [rad], -pi/2 .. pi/2.
        bank: right side down is positive [rad], -pi .. pi.
    """

    nose_up: float
    bank: float

    def rounded(self, step: float) -> "Attitude":
        """Return it in whole steps [rad], so that what nobody sees is no change."""
        return Attitude(step * round(self.nose_up / step), step * round(self.bank / step))

    @property
    def sky(self) -> tuple[float, float]:
        """Direction towards the sky on the screen, to the right and down, a unit vector.

        With the right side down, the sky leans to the left.
        """
        return -math.sin(self.bank), -math.cos(self.bank)


def attitude_of(q_WB: Sequence[float]) -> Attitude | None:
    """Return the attitude of an orientation, None of one that is no number.

    Args:
        q_WB: unit quaternion w, x, y, z of the body B in the world W, whose z is up.
    """
    if not all(map(math.isfinite, q_WB)):
        return None
    w, x, y, z = q_WB
    forward = 2.0 * (x * z - w * y)  # world z of the body's axes: third row of the rotation
    left = 2.0 * (y * z + w * x)
    up = 1.0 - 2.0 * (x * x + y * y)
    return Attitude(math.asin(max(-1.0, min(1.0, forward))), math.atan2(left, up))


@dataclass(frozen=True)
class Horizon:
    """Where things of the sky are in a round window on it.

    Attributes:
        attitude: of the body that looks.
        radius: of the window [px].
        view: angle from the middle of the window to its rim [rad].
    """

    attitude: Attitude
    radius: float
    view: float

    def height(self, elevation: float) -> float:
        """Return how far towards the sky an elevation [rad] is seen from the middle [px]."""
        return (elevation - self.attitude.nose_up) / self.view * self.radius

    @property
    def line(self) -> float:
        """Height of the horizon [px]; a rim of sky or of earth is always left."""
        most = 0.88 * self.radius
        return max(-most, min(most, self.height(0.0)))

    def place(self, height: float, aside: float = 0.0) -> tuple[float, float]:
        """Return a place in the window from its middle, to the right and down [px].

        Args:
            height: towards the sky.
            aside: along the horizon, to the right of who looks.
        """
        right, down = self.attitude.sky
        return height * right - aside * down, height * down + aside * right

    def ladder(self, least: int = LADDER_STEP) -> tuple[int, ...]:
        """Return the elevations of ladder lines that are well within the window [degrees]."""
        middle = math.degrees(self.attitude.nose_up)
        reach = 0.62 * math.degrees(self.view)
        first = math.ceil(max(-90.0, middle - reach) / least)
        last = math.floor(min(90.0, middle + reach) / least)
        return tuple(k * least for k in range(first, last + 1) if k)
