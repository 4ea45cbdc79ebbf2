"""What sticks ask of the drone: velocities along its heading, and how fast it turns.

The heading frame H stands level under the drone: x where the nose points, y to its left, z up.
Left stick: up climbs, right turns clockwise. Right stick: up is forward, right is to the right.
"""

import math
from dataclasses import dataclass

from workbench.gui.joystick.stick_curve import StickCurve
from workbench.gui.joystick.sticks import Sticks


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
