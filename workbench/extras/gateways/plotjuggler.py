"""PlotJuggler: samples as JSON datagrams, for its UDP server with the JSON parser."""

import json
import math
import socket
from collections.abc import Callable, Sequence
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address
from workbench.link.sample import Sample
from workbench.link.topics import FieldValue, Topic

PLOTJUGGLER_PORT = 9870
"""Default port of PlotJuggler's UDP server."""
MAX_DATAGRAM_BYTES = 65_507
"""Largest datagram over IPv4 [bytes]."""


class PlotJuggler:
    """An outlet that sends each sample as a datagram, even if nobody listens.

    Args:
        address: of PlotJuggler's UDP server.
        say: shows the user a sentence.

    Raises:
        WorkbenchError: if the host is unknown.
    """

    def __init__(self, address: Address, say: Callable[[str], None]) -> None:
        self._say = say
        self._too_large: set[str] = set()
        try:
            found = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)
        except OSError as error:
            raise WorkbenchError(f"the host '{address.host}' is unknown: {error}") from None
        family, _, _, _, to = found[0]
        self._to: tuple[Any, ...] = to
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)

    def announce(self, topics: Sequence[Topic]) -> None:
        """Do nothing: PlotJuggler finds topics in the data."""

    def deliver(self, sample: Sample) -> None:
        """Send a sample."""
        data = datagram(sample)
        if len(data) > MAX_DATAGRAM_BYTES:
            if sample.topic not in self._too_large:
                self._too_large.add(sample.topic)
                self._say(
                    f"{sample.topic} is left out: {len(data)} bytes are too many for one packet"
                )
            return
        try:
            self._socket.sendto(data, self._to)
        except BlockingIOError:
            return  # the buffer is full: losing a datagram is acceptable
        except OSError as error:
            raise WorkbenchError(f"PlotJuggler cannot be reached: {error.strerror}") from None

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def datagram(sample: Sample) -> bytes:
    """Return a sample as JSON: `timestamp` [s], and its fields nested by the topic's name."""
    nested: dict[str, object] = {
        name: _strict_json_value(value) for name, value in sample.values.items()
    }
    for part in reversed(sample.topic.strip("/").split("/")):
        nested = {part: nested}
    said = {"timestamp": sample.time} | nested
    return json.dumps(said, allow_nan=False, separators=(",", ":")).encode()


def _strict_json_value(value: FieldValue) -> object:
    """Return a value in strict JSON types; non-finite numbers become null, which is not drawn."""
    if isinstance(value, tuple):
        return [_strict_json_value(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
