"""Flight modes and requests by name; `flight_mode` says which follows which.

They stand apart so that who shows a flight need not load its law.
"""

from enum import IntEnum


class FlightMode(IntEnum):
    """Modes in the order in which a flight passes them; the paper's conditions are among them."""

    OFF = 0
    ARMED = 1
    TAKING_OFF = 2
    HOVERING = 3
    ASCENDING = 4
    DESCENDING = 5
    CRUISING = 6
    LANDING = 7

    @property
    def label(self) -> str:
        """The mode in words."""
        return self.name.lower().replace("_", " ")


class Reason(IntEnum):
    """Why a flight does what nobody asked for, or what it flies without; it stands by the mode."""

    NONE = 0
    BATTERY_LOW = 1
    BATTERY_EMPTY = 2
    DEAD_RECKONING = 3
    """No GPS any more: the place is held by what is left of the estimate."""
    POSITION_LOST = 4
    IMU_FAILED = 5
    HEADING_DRIFTS = 6
    """The magnetometer is silent, or too far off to count: the heading goes by the gyro alone."""
    AUTOPILOT_ENDED = 7
    """The program that runs the law has ended: the rotors stand, and the mode stays what it was."""

    @property
    def label(self) -> str:
        """The reason in words, none for NONE."""
        return _REASONS[self]


_REASONS = (
    "",
    "battery low",
    "battery empty",
    "no GPS, dead reckoning",
    "position lost",
    "IMU failed",
    "no magnetometer, the heading drifts",
    "autopilot ended",
)
"""By their numbers."""


class Request(IntEnum):
    """What a pilot may ask of the flight mode."""

    NONE = 0
    ARM = 1
    TAKE_OFF = 2
    HOLD = 3
    """End a take-off where it is; the other modes hold by themselves while nothing is asked."""
    LAND = 4
    STOP = 5
    ABORT_LANDING = 6
    """Climb to a height, or hold the place if that is lower. It is a request of its own, as the
    others have no effect in a landing: an automatic hold does not end it, nor do old scripts."""
