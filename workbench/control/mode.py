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
