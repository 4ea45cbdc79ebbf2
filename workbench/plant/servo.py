"""Servos: what drives the joints of a vehicle, from the description's numbers."""

import math
from dataclasses import dataclass, replace

ASSUMED_SERVO_RATE_RAD_S = 30.0
"""Natural frequency of a position servo without stated gains, and bandwidth of a rate servo."""
SERVO_SYSTEM = "servos"
"""Name of the system that has the setpoints of servos, and of their parameters."""
SERVO_KINDS = ("position", "velocity", "effort")
"""What the setpoint of a servo is."""


@dataclass(frozen=True)
class Servo:
    """A servo in one freedom of a joint, in the units of that freedom.

    With the setpoint r, the position q and the velocity v the effort is, within its limit,

        position   stiffness (r - q) - damping v
        velocity   damping (r - v)
        effort     r

    Attributes:
        kind: one of `SERVO_KINDS`.
        stiffness: effort over position [N m/rad or N/m]; None if not stated.
        damping: effort over velocity [N m s/rad or N s/m]; None if not stated.
        damping_ratio: of a position servo that states only one of the two, or none.
        lower: least setpoint.
        upper: largest setpoint.
        start: setpoint at the start of a flight.
        max_effort: limit of its effort [N m or N].
        max_rate: limit of the velocity of a position servo's setpoint [rad/s or m/s].
        time_constant: of a low-pass of its setpoint [s].
        delay: of its setpoint [s].
    """

    kind: str = "position"
    stiffness: float | None = None
    damping: float | None = None
    damping_ratio: float = 1.0
    lower: float = -math.inf
    upper: float = math.inf
    start: float = 0.0
    max_effort: float = math.inf
    max_rate: float = math.inf
    time_constant: float = 0.0
    delay: float = 0.0

    def driving(self, inertia: float) -> "Servo":
        """Return it with the gains that it does not state, for what it moves [kg m² or kg]."""
        stiffness = self.stiffness
        if stiffness is None and self.damping is not None and self.kind == "position":
            stiffness = (self.damping / (2.0 * self.damping_ratio)) ** 2 / inertia
        elif stiffness is None:
            stiffness = inertia * ASSUMED_SERVO_RATE_RAD_S**2
        damping = self.damping
        if damping is None and self.kind == "velocity":
            damping = inertia * ASSUMED_SERVO_RATE_RAD_S
        elif damping is None:
            damping = 2.0 * self.damping_ratio * math.sqrt(stiffness * inertia)
        return replace(self, stiffness=stiffness, damping=damping)

    def shifted(self, offset: float) -> "Servo":
        """Return it for a position that is larger by an offset [rad or m]."""
        if self.kind != "position":
            return self
        return replace(
            self, lower=self.lower + offset, upper=self.upper + offset, start=self.start + offset
        )

    @property
    def spring(self) -> float:
        """Effort over a deviation of the position [N m/rad or N/m]; gains must be known."""
        return (self.stiffness or 0.0) if self.kind == "position" else 0.0

    @property
    def damper(self) -> float:
        """Effort over a deviation of the velocity [N m s/rad or N s/m]; gains must be known."""
        return (self.damping or 0.0) if self.kind != "effort" else 0.0

    @property
    def lag(self) -> float:
        """Delay of a slow motion behind the setpoint of a position servo [s]; gains as above."""
        behind = self.damper / self.spring if self.spring else 0.0
        return behind + self.time_constant + self.delay

    def delay_periods(self, period: float) -> int:
        """Return its delay in control periods [s]."""
        return round(self.delay / period)

    def lowpass_share(self, period: float) -> float:
        """Return the share of a step of the wanted setpoint that it takes in a period [s]."""
        return -math.expm1(-period / self.time_constant) if self.time_constant else 1.0

    def within(self, setpoint: float) -> float:
        """Return a setpoint within its limits."""
        return min(max(setpoint, self.lower), self.upper)


def setpoint_range(servo: Servo, slides: bool) -> tuple[float, float]:
    """Return a range for the setpoint of a servo; without limits two turns, 10 m, or 10 of a rate.

    Args:
        servo: within the limits of its freedom.
        slides: whether the joint slides.
    """
    wide = 2.0 * math.pi if servo.kind == "position" and not slides else 10.0
    return max(servo.lower, -wide), min(servo.upper, wide)
