"""Events and changed parameters of a flight, newest last."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from workbench.gui.signals import ParameterReader
from workbench.link.backplane import Published
from workbench.link.drone_topics import EVENTS
from workbench.link.topics import Topic

MOST = 2000
"""Limit of kept events; beyond it the oldest are dropped."""
SEVERITIES = ("information", "warning", "failure")


@dataclass(frozen=True)
class Event:
    """An event.

    Attributes:
        time: simulated time [s].
        kind: information, warning, failure or parameter.
        said: the event, in words.
    """

    time: float
    kind: str
    said: str


class EventList:
    """Picks events from the published data of a flight."""

    def __init__(self) -> None:
        self.events: deque[Event] = deque(maxlen=MOST)
        self._events: Topic | None = None
        self._reader = ParameterReader()

    def begin(self, topics: Iterable[Topic]) -> None:
        """Clear all: a flight begins."""
        self.events.clear()
        flown = tuple(topics)
        self._events = next((topic for topic in flown if topic.id == EVENTS), None)
        self._reader.begin(flown)

    def add(self, published: Iterable[Published]) -> list[Event]:
        """Add published data; return its events."""
        found = []
        for each in published:
            for number, payload in each.payloads:
                if number == EVENTS and self._events is not None:
                    found.append(_event(self._events, each.t_ns * 1e-9, payload))
            for change in self._reader.read((each,)):
                found.append(Event(change.time, "parameter", f"{change.name} = {change.value:g}"))
        self.events.extend(found)
        return found


def _event(topic: Topic, time: float, payload: bytes) -> Event:
    values = topic.unpack(payload)
    severity = values["severity"]
    assert isinstance(severity, int)
    return Event(time, SEVERITIES[min(max(severity, 0), 2)], str(values["said"]))
