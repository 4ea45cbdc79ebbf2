"""What gains mean, in angular and linear acceleration, whatever the law calls them.

Around an axis, with the error e of the angle, ω its rate, and α the angular acceleration:

    ω_sp = angle e + angle_integral ∫e - angle_rate ω
    α    = rate (ω_sp - ω) + rate_integral ∫(ω_sp - ω) - slope dω/dt

and along an axis, with the error e of the place, velocity v and acceleration a:

    v_sp = place e + place_integral ∫e
    a    = speed (v_sp - v) + speed_integral ∫(v_sp - v) - slope dv/dt

From the angle θ to -α such a loop is slope s² + c1 s + c0 + c_1 / s + c_2 / s², with

    c1 = rate (1 + angle_rate),   c0 = rate angle + rate_integral (1 + angle_rate),
    c_1 = rate angle_integral + rate_integral angle,   c_2 = rate_integral angle_integral

so laws that have other parts than these can have the same loop.
"""

import math
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Turn:
    """Gains around an axis, see above.

    Attributes:
        angle: [1/s].
        angle_integral: [1/s²].
        angle_rate: [-].
        rate: [1/s].
        rate_integral: [1/s²].
        slope: [-].
        ahead: angular acceleration per rate asked for [1/s].
    """

    angle: float = 0.0
    angle_integral: float = 0.0
    angle_rate: float = 0.0
    rate: float = 0.0
    rate_integral: float = 0.0
    slope: float = 0.0
    ahead: float = 0.0

    @property
    def stiffness(self) -> float:
        """Angular acceleration per angle, c0 [1/s²]."""
        return self.rate * self.angle + self.rate_integral * (1.0 + self.angle_rate)

    @property
    def stiffness_integral(self) -> float:
        """Angular acceleration per integral of the angle, c_1 [1/s³]."""
        return self.rate * self.angle_integral + self.rate_integral * self.angle

    def less(self, drag: float) -> "Turn":
        """Return the same loop, of which drag has damped the rate already by so much [1/s]."""
        rate = self.rate - drag
        return replace(self, rate=rate, angle=self.angle * self.rate / rate) if rate else self

    def of_rate(self) -> "Turn":
        """Return the same loop with its slope of ω alone, of one with that of ω_sp - ω.

        Of the loop with the error's slope, c1 is larger by slope angle.
        """
        rate = self.rate + self.slope * self.angle
        if rate <= 0.0:
            return self
        root = self.stiffness**2 - 4.0 * rate * self.stiffness_integral
        angle = (self.stiffness + math.sqrt(max(0.0, root))) / (2.0 * rate)
        integral = self.stiffness - rate * angle
        return replace(self, angle=angle, rate=rate, rate_integral=integral)

    def of_error(self) -> "Turn | None":
        """Return the same loop with the slope of ω_sp - ω, of one with that of ω; None for none.

        It is (s + angle) (slope s² + rate s + rate_integral) / s, so angle is a root of the loop.
        """
        c = (self.slope, self.rate, self.stiffness, self.stiffness_integral)
        roots = np.roots(c)
        angles = [-float(x.real) for x in roots if abs(x.imag) < 1e-9 * abs(x) and x.real < 0.0]
        if not angles:
            return None if self.angle else self
        angle = min(angles, key=lambda each: abs(each - self.angle))
        rate = self.rate - self.slope * angle
        integral = self.stiffness - rate * angle
        return replace(self, angle=angle, rate=rate, rate_integral=max(0.0, integral))

    def without_angle_rate(self) -> "Turn":
        """Return the same loop without the derivative of the angle, exactly."""
        more = 1.0 + self.angle_rate
        return replace(
            self,
            angle=self.angle / more,
            angle_integral=self.angle_integral / more,
            angle_rate=0.0,
            rate=self.rate * more,
            rate_integral=self.rate_integral * more,
        )

    def without_angle_integral(self) -> "Turn":
        """Return the same loop without integral and derivative of the angle, but for c_2.

        angle and rate_integral / rate are the roots of rate x² - c0 x + c_1 = 0.
        """
        plain = self.without_angle_rate()
        if not plain.angle_integral or plain.rate <= 0.0:
            return replace(plain, angle_integral=0.0)
        root = plain.stiffness**2 - 4.0 * plain.rate * plain.stiffness_integral
        angle = (plain.stiffness + math.sqrt(max(0.0, root))) / (2.0 * plain.rate)
        integral = plain.stiffness - plain.rate * angle
        return replace(plain, angle=angle, angle_integral=0.0, rate_integral=integral)


@dataclass(frozen=True)
class Move:
    """Gains along an axis, see above.

    Attributes:
        place: [1/s].
        place_integral: [1/s²].
        speed: [1/s].
        speed_integral: [1/s²].
        slope: [-].
        ahead: acceleration per velocity asked for [1/s].
    """

    place: float = 0.0
    place_integral: float = 0.0
    speed: float = 0.0
    speed_integral: float = 0.0
    slope: float = 0.0
    ahead: float = 0.0

    def less(self, drag: float) -> "Move":
        """Return the same loop, of which drag has damped the speed already by so much [1/s]."""
        speed = self.speed - drag
        return replace(self, speed=speed, place=self.place * self.speed / speed) if speed else self

    @property
    def pull(self) -> float:
        """Acceleration per error of the place [1/s²]."""
        return self.speed * self.place + self.speed_integral

    @property
    def pull_integral(self) -> float:
        """Acceleration per integral of it [1/s³]."""
        return self.speed * self.place_integral + self.speed_integral * self.place


@dataclass(frozen=True)
class Meaning:
    """All gains of a law, by what they mean."""

    x: Move = Move()
    y: Move = Move()
    z: Move = Move()
    roll: Turn = Turn()
    pitch: Turn = Turn()
    yaw: Turn = Turn()
