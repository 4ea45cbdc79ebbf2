"""The port for programs: frames over TCP, with TLS where there is a certificate."""

import asyncio
import contextlib
import ssl
from typing import cast

from workbench.link.server.acceptor import Acceptor, listen
from workbench.link.server.client_session import ClientSession
from workbench.link.server.hub import Hub
from workbench.link.wire import Decoder

LINGER = 1.0
"""Time for the last words to go out [s]."""
MOST_DROPPED = 256 * 1024
"""Bytes that are read after the last words, so that these are not lost with them."""


class TcpListener:
    """Brings the connections at a port to the hub.

    Args:
        host: name or address where to listen.
        port: 0 for one that is free.
        hub: whom clients talk to.
        context: for TLS, None without.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """

    def __init__(self, host: str, port: int, hub: Hub, context: ssl.SSLContext | None) -> None:
        kind = "tcp" if context is None else "tls"
        self._open: set[TcpConnection] = set()
        self._acceptor = Acceptor(
            listen(host, port),
            lambda address: TcpConnection(hub, self._open, address, kind),
            hub.refusals.add,
            context,
        )

    @property
    def address(self) -> str:
        """Where it listens, "HOST:PORT"."""
        return str(self._acceptor.address)

    async def close(self) -> None:
        """Listen no longer; wait until the last words are out."""
        await self._acceptor.close()
        for connection in list(self._open):
            connection.close()
        ended = [connection.ended.wait() for connection in self._open]
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*ended), 2.0 * LINGER)


class TcpConnection(asyncio.Protocol):
    """One connection: the hub's transport, and asyncio's protocol."""

    def __init__(self, hub: Hub, all_open: set["TcpConnection"], address: str, kind: str) -> None:
        self.ended = asyncio.Event()
        self._hub = hub
        self._all = all_open
        self._address = address
        self._kind = kind
        self._decoder = Decoder()
        self._session: ClientSession | None = None
        self._closing = False
        self._dropped = 0
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        self._all.add(self)
        self._session = self._hub.open(self, self._address, self._kind, self._decoder)

    def data_received(self, data: bytes) -> None:
        if self._closing or self._session is None:
            self._dropped += len(data)
            if self._dropped > MOST_DROPPED:
                self.abort()
            return
        self._decoder.keep(data)
        self._pause(self._hub.receive(self._session, len(data)))

    def connection_lost(self, exc: Exception | None) -> None:
        self._closing = True
        self._all.discard(self)
        if self._timer is not None:
            self._timer.cancel()
        if self._session is not None:
            self._hub.lost(self._session)
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

    def _pause(self, pause: float) -> None:
        """Read nothing for a time [s]."""
        if pause > 0.0 and not self._closing:
            self._transport.pause_reading()
            self._timer = asyncio.get_running_loop().call_later(pause, self._resume)

    def _resume(self) -> None:
        if self._closing or self._session is None:
            return
        pause = self._hub.receive(self._session)
        if pause > 0.0:
            self._pause(pause)
        else:
            self._transport.resume_reading()
