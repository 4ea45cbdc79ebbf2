"""What happens on board, as payloads of topics."""

import struct
import time
from collections.abc import Sequence

from workbench.link.backplane import Published
from workbench.link.drone_topics import DRONE_STATE, EVENTS, PARAMETERS
from workbench.link.topics import Topic
from workbench.systems.mode import FlightMode

INFORMATION, WARNING, FAILURE = 0, 1, 2
"""How severe an event is."""


class Announcer:
    """Makes events of what happens.

    Args:
        topics: of the flight.
    """

    def __init__(self, topics: Sequence[Topic]) -> None:
        found = {topic.id: topic for topic in topics}
        self._events, self._parameters = found[EVENTS], found[PARAMETERS]
        self._mode: int | None = None

    def event(self, time_s: float, said: str, severity: int) -> Published:
        """Return a sentence as it is published at a simulated time [s]."""
        return _published(time_s, EVENTS, self._events.pack((severity, said)))

    def parameter(self, time_s: float, name: str, value: float) -> Published:
        """Return a parameter's new value as it is published at a simulated time [s]."""
        return _published(time_s, PARAMETERS, self._parameters.pack((name, value)))

    def mode_said(self, published: Published) -> str | None:
        """Return a sentence where the flight mode is another one than before."""
        for number, payload in published.payloads:
            if number == DRONE_STATE:
                (mode,) = struct.unpack_from("<i", payload)
                before, self._mode = self._mode, mode
                if before is not None and mode != before:
                    return f"flight mode: {FlightMode(mode).label}"
        return None


def _published(time_s: float, number: int, payload: bytes) -> Published:
    return Published(round(time_s * 1e9), time.time_ns(), ((number, payload),))
