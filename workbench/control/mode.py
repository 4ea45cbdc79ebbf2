"""Flight modes and requests by name; `flight_mode` has the transitions.

This module is separate so that displays of a flight need not load the control law.
"""

from enum import IntEnum


class FlightMode(IntEnum):
    """Modes in the order of a flight; they include the paper's conditions."""

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
    """Why a flight does something on its own, or what it lacks; shown beside the mode."""

    NONE = 0
    BATTERY_LOW = 1
    BATTERY_EMPTY = 2
    DEAD_RECKONING = 3
    """No GPS any more: the position is held by the rest of the estimate."""
    POSITION_LOST = 4
    IMU_FAILED = 5
    HEADING_DRIFTS = 6
    """The magnetometer is silent or rejected: the heading follows the gyro alone."""
    AUTOPILOT_ENDED = 7
    """The program that runs the law has ended: the rotors stop, and the mode is held."""

    @property
    def label(self) -> str:
        """The reason in words, empty for NONE."""
        return _REASON_TEXTS[self]


_REASON_TEXTS = (
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


class ModeRequest(IntEnum):
    """Requests of a pilot to the flight mode."""

    NONE = 0
    ARM = 1
    TAKE_OFF = 2
    HOLD = 3
    """End a take-off at its present place; other modes hold automatically without a command."""
    LAND = 4
    STOP = 5
    ABORT_LANDING = 6
    """Climb to a height, or hold the position if that is lower. It is a separate request because
    the others have no effect in a landing: neither an automatic hold nor old scripts end it."""
