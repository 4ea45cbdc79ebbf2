"""A sample: what a topic said at one time."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

from workbench.link.topics import Topic, Value


@dataclass(frozen=True)
class Sample:
    """What a topic said at one time; its fields are unpacked when somebody asks for them.

    Attributes:
        definition: the topic's, as the server described it.
        t_ns: simulated time [ns].
        payload: as it came.
    """

    definition: Topic
    t_ns: int
    payload: bytes

    @property
    def topic(self) -> str:
        """Name of the topic, as `/dh_drone/velocity_data`."""
        return self.definition.name

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.t_ns / 1e9

    @cached_property
    def values(self) -> Mapping[str, Value]:
        """The fields by name, in SI units and in the frames that the definition names."""
        return MappingProxyType(self.definition.unpack(self.payload))

    def __getitem__(self, field: str) -> Value:
        return self.values[field]
