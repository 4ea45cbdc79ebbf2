"""What is asked of the drone and what it does, axis by axis along its heading."""

from dataclasses import dataclass

from workbench.gui.joystick.flight_limits import FlightLimits
from workbench.gui.joystick.piloting import Handling, heading_velocity
from workbench.session.snapshot import Snapshot

YAW_RATE = 3
FOLLOW = 7
"""Places in `Snapshot.reference`; the velocity stands before them."""


@dataclass(frozen=True)
class Answered:
    """One axis of a flight; a velocity [m/s] or a yaw rate [rad/s].

    Attributes:
        name: of the axis; positive is what it says first.
        unit: m/s or rad/s.
        asked: by whoever flies; None where the drone flies to a place of its own accord.
        flown: now.
        scale: that fills a bar: full stick, or what is flown beyond it.
        limit: of the flight, that is flown at most.
    """

    name: str
    unit: str
    asked: float | None
    flown: float
    scale: float
    limit: float


def answered(snapshot: Snapshot, handling: Handling, limits: FlightLimits) -> tuple[Answered, ...]:
    """Return the four axes of a flight; to the right is positive, as it is on a stick."""
    yaw = snapshot.roll_pitch_yaw[2]
    asked, follow = snapshot.reference, snapshot.reference[FOLLOW] > 0.0
    wanted = heading_velocity(asked[:3], yaw)
    flown = heading_velocity(snapshot.v_WB, yaw)
    speed, turn = handling.speed, handling.yaw_rate
    rows = (
        ("Forward", "m/s", wanted[0], flown[0], speed, limits.level),
        ("Right", "m/s", -wanted[1], -flown[1], speed, limits.level),
        ("Climb", "m/s", wanted[2], flown[2], speed, limits.climb),
        ("Turn right", "rad/s", -asked[YAW_RATE], -snapshot.w_WB[2], turn, limits.turn),
    )
    return tuple(
        Answered(name, unit, None if follow else want, fly, scale, limit)
        for name, unit, want, fly, scale, limit in rows
    )
