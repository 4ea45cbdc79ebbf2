"""The connection to ground stations."""

import asyncio
import contextlib
import math
from collections.abc import Callable
from typing import Any


class GroundStation(asyncio.DatagramProtocol):
    """Ground stations: messages to and from all of them, by UDP, each with a transport.

    Args:
        say: shows the user a sentence.

    Attributes:
        heard: messages from them that are not read yet.
        heard_at: time of their last message, by the clock of the loop [s].
    """

    MOST_WAITING = 1000
    """Largest number of waiting messages; more are dropped."""

    def __init__(self, say: Callable[[str], None]) -> None:
        from pymavlink.dialects.v20 import common as mavlink

        from workbench.extras.gateways.mavlink_messages import COMPONENT_ID, SYSTEM_ID

        self.heard: asyncio.Queue[Any] = asyncio.Queue(self.MOST_WAITING)
        self.heard_at = -math.inf
        self._say = say
        self._mav = mavlink.MAVLink(None, srcSystem=SYSTEM_ID, srcComponent=COMPONENT_ID)
        self._transports: list[asyncio.DatagramTransport] = []

    def connection_made(self, transport: Any) -> None:
        """Keep a transport."""
        self._transports.append(transport)

    def send(self, *messages: Any) -> None:
        """Send messages; they are lost if nobody listens."""
        for message in messages:
            data = message.pack(self._mav)
            self._mav.seq = (self._mav.seq + 1) % 256
            for transport in self._transports:
                transport.sendto(data)

    def close(self) -> None:
        """Close all transports."""
        for transport in self._transports:
            transport.close()

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        """Keep messages for this vehicle; a datagram has complete messages."""
        from pymavlink.dialects.v20 import common as mavlink

        from workbench.extras.gateways.mavlink_messages import SYSTEM_ID

        self.heard_at = asyncio.get_running_loop().time()
        parser = mavlink.MAVLink(None)
        parser.robust_parsing = True
        for message in parser.parse_buffer(data) or ():
            target = getattr(message, "target_system", SYSTEM_ID)
            if message.get_type() != "BAD_DATA" and target in (0, SYSTEM_ID):
                with contextlib.suppress(asyncio.QueueFull):
                    self.heard.put_nowait(message)

    def error_received(self, exc: Exception) -> None:
        """Report that nobody listens, unless one of several stations was heard."""
        if self.heard_at > -math.inf:
            return
        self._say(f"no ground station listens yet ({exc}): start it, or name another --to")
