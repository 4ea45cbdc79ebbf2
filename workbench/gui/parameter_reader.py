"""Picks changes of live parameters out of what a flight publishes; no Qt."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS
from workbench.link.topics import Topic


@dataclass(frozen=True)
class ParameterChange:
    """A parameter that has been given a value, by whoever.

    Attributes:
        time: when, simulated [s].
        name: as in the table of parameters.
        value: in SI units.
    """

    time: float
    name: str
    value: float


class ParameterReader:
    """Reads one flight after another."""

    def __init__(self) -> None:
        self._topic: Topic | None = None

    def begin(self, topics: Iterable[Topic]) -> None:
        """Read a flight that publishes these topics from now on."""
        self._topic = next((each for each in topics if each.id == PARAMETERS), None)

    def read(self, published: Iterable[Published]) -> Iterator[ParameterChange]:
        """Go through the changes, in the order of time."""
        if self._topic is None:
            return
        for each in published:
            for number, payload in each.payloads:
                if number == PARAMETERS:
                    told = self._topic.unpack(payload)
                    value = told["value"]
                    assert isinstance(value, float)
                    yield ParameterChange(each.t_ns * 1e-9, str(told["name"]), value)
