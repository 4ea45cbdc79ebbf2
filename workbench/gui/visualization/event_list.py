"""What happened in a flight: events and changed parameters, newest last."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from workbench.link.backplane import Published
from workbench.link.topics import PREFIX, Topic

MOST = 2000
"""Events that are kept; then the oldest go."""
SEVERITIES = ("information", "warning", "failure")


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes:
        time: when, simulated [s].
        kind: information, warning, failure or parameter.
        said: what, in words.
    """

    time: float
    kind: str
    said: str


class EventList:
    """Picks events out of what a flight publishes."""

    def __init__(self) -> None:
        self.events: deque[Event] = deque(maxlen=MOST)
        self._events: Topic | None = None
        self._parameters: Topic | None = None

    def begin(self, topics: Iterable[Topic]) -> None:
        """Forget all: a flight begins."""
        self.events.clear()
        by_name = {topic.name: topic for topic in topics}
        self._events = by_name.get(f"{PREFIX}events")
        self._parameters = by_name.get(f"{PREFIX}parameters")

    def add(self, published: Iterable[Published]) -> list[Event]:
        """Take what was published; return what of it are events."""
        found = []
        for each in published:
            for number, payload in each.payloads:
                for topic in (self._events, self._parameters):
                    if topic is not None and topic.id == number:
                        found.append(_event(topic, each.t_ns * 1e-9, payload))
        self.events.extend(found)
        return found


def _event(topic: Topic, time: float, payload: bytes) -> Event:
    values = topic.unpack(payload)
    if "said" in values:
        severity = values["severity"]
        assert isinstance(severity, int)
        return Event(time, SEVERITIES[min(max(severity, 0), 2)], str(values["said"]))
    value = values["value"]
    assert isinstance(value, float)
    return Event(time, "parameter", f"{values['name']} = {value:g}")
