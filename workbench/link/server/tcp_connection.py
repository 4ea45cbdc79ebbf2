"""One connection by TCP or TLS: reads no faster than the hub allows, ends with its last words."""

import asyncio
from typing import cast

from workbench.link.server.hub import Hub
from workbench.link.server.seat import Seat
from workbench.link.wire import Decoder

LINGER = 1.0
"""Time for the last words to go out [s]."""
MOST_DROPPED = 256 * 1024
"""Bytes that are read after the last words, so that these are not lost with them."""


class TcpConnection(asyncio.Protocol):
    """One connection: the hub's transport, and asyncio's protocol."""

    def __init__(self, hub: Hub, all_open: set["TcpConnection"], address: str, kind: str) -> None:
        self.ended = asyncio.Event()
        self._hub = hub
        self._all = all_open
        self._address = address
        self._kind = kind
        self._decoder = Decoder()
        self._seat: Seat | None = None
        self._closing = False
        self._dropped = 0
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        self._all.add(self)
        self._seat = self._hub.open(self, self._address, self._kind, self._decoder)

    def data_received(self, data: bytes) -> None:
        if self._closing or self._seat is None:
            self._dropped += len(data)
            if self._dropped > MOST_DROPPED:
                self.abort()
            return
        self._rest(self._hub.receive(self._seat, data))

    def connection_lost(self, exc: Exception | None) -> None:
        self._closing = True
        self._all.discard(self)
        if self._timer is not None:
            self._timer.cancel()
        if self._seat is not None:
            self._hub.lost(self._seat)
        self.ended.set()

    @property
    def unsent(self) -> int:
        return self._transport.get_write_buffer_size()

    def write(self, data: bytes) -> None:
        if not self._closing:
            self._transport.write(data)

    def close(self) -> None:
        if self._closing:
            return
        self._closing = True
        if self._timer is not None:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(LINGER, self.abort)
        # A socket that is closed with bytes unread takes back what it has sent last, so the other
        # side is to close first. TLS has an exchange of its own.
        if not self._transport.can_write_eof():
            self._transport.close()
            return
        try:
            self._transport.write_eof()
        except OSError:  # the other side was faster
            self.abort()
        else:
            self._transport.resume_reading()

    def abort(self) -> None:
        self._closing = True
        self._transport.abort()

    def _rest(self, pause: float) -> None:
        """Read nothing for a while."""
        if pause > 0.0 and not self._closing:
            self._transport.pause_reading()
            self._timer = asyncio.get_running_loop().call_later(pause, self._go_on)

    def _go_on(self) -> None:
        if self._closing or self._seat is None:
            return
        pause = self._hub.go_on(self._seat)
        if pause > 0.0:
            self._rest(pause)
        else:
            self._transport.resume_reading()
