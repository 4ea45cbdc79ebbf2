"""The Home screen's part of the published data; no Qt."""

import struct
from collections.abc import Sequence

from workbench.gui.instruments.ring_scan import RingScan
from workbench.gui.signals import parameter_changes
from workbench.link import drone_topics
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.parameters.parameter_table import flight_table


class StreamWatch:
    """Keeps the newest cloud and rotor speeds, and the present live parameters.

    Attributes:
        scan: reads the cloud, None without one.
        cloud: newest payload, b"" before the first.
    """

    def __init__(self) -> None:
        self.scan: RingScan | None = None
        self.cloud = b""
        self._rotors = b""
        self._values: dict[str, float] = {}
        self._defaults = flight_table().defaults()

    def begin(self, view: LiveView) -> None:
        """Clear all: a flight begins."""
        self._values = dict(view.values)
        self.cloud = self._rotors = b""
        clouds = [topic for topic in view.topics if topic.id == drone_topics.LIDAR_CLOUD_SIGNAL.id]
        self.scan = RingScan(clouds[0]) if clouds else None

    def hear(self, published: Sequence[Published]) -> None:
        """Take published data, in order of time."""
        for each in published:
            for number, payload in each.payloads:
                if number == drone_topics.LIDAR_CLOUD_SIGNAL.id:
                    self.cloud = payload
                elif number == drone_topics.ROTORS_SIGNAL.id:
                    self._rotors = payload
        self._values |= {name: value for _, name, value in parameter_changes(published)}

    def value(self, name: str) -> float:
        """Return a live parameter's present value, or its default in a flight without it."""
        return self._values.get(name, self._defaults[name])

    def rotor_speeds(self) -> tuple[float, ...]:
        """Return the newest speed of each rotor [rad/s], none before the first."""
        numbers = struct.unpack(f"<{len(self._rotors) // 4}f", self._rotors)
        return numbers[: len(numbers) // 2]  # thrusts follow
