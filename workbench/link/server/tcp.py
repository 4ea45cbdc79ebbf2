"""Frames over TCP for programs."""

import asyncio
import ssl
from typing import cast

from workbench.link.server.acceptor import LINGER_TIMEOUT_S, AcceptedProtocol, Acceptor, listen
from workbench.link.server.client_session import ClientSession
from workbench.link.server.hub import Hub
from workbench.link.wire import Decoder

MAX_DISCARDED_BYTES = 256 * 1024
"""Largest number of bytes read after the last frame, so that a reset does not lose that frame."""


def listen_tcp(host: str, port: int, hub: Hub, context: ssl.SSLContext | None) -> Acceptor:
    """Accept the connections of programs, in the running loop.

    Args:
        host: name or address to listen at.
        port: 0 for a free one.
        hub: handles the clients.
        context: for TLS, None without.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    kind = "tcp" if context is None else "tls"

    def connection(address: str) -> TcpConnection:
        return TcpConnection(hub, address, kind)

    return Acceptor(listen(host, port), connection, hub.refusals.add, context, hub.later)


class TcpConnection(AcceptedProtocol):
    """One connection: a transport for the hub, and a protocol for asyncio.

    Args:
        hub: handles the client.
        address: of the client, "HOST:PORT".
        kind: tcp, tls or websocket.
    """

    def __init__(self, hub: Hub, address: str, kind: str) -> None:
        super().__init__()
        self._hub = hub
        self._address = address
        self._kind = kind
        self._transport: asyncio.Transport | None = None
        self._decoder: Decoder = Decoder()
        self._session: ClientSession | None = None
        self._closing = False
        self._dropped = 0
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        if self._closing:  # it had to make room before it was connected
            self.abort()
            return
        self._begin()

    def _begin(self) -> None:
        """Begin with a new connection."""
        self._greet()

    def data_received(self, data: bytes) -> None:
        if self._closing or self._session is None:
            self._dropped += len(data)
            if self._dropped > MAX_DISCARDED_BYTES:
                self.abort()
            return
        self._decoder.received += data
        self._pause(self._hub.receive(self._session, len(data)))

    def connection_lost(self, exc: Exception | None) -> None:
        self._closing = True
        self._set_timer(None)
        if self._session is not None:
            self._hub.lost(self._session)
        self.ended.set()

    @property
    def is_in(self) -> bool:
        return self._session is not None and self._session.role is not None and not self._closing

    @property
    def unsent(self) -> int:
        return self._transport.get_write_buffer_size() if self._transport else 0

    def write(self, data: bytes) -> None:
        if self._transport and not self._closing:
            self._transport.write(data)

    def close(self) -> None:
        self._close(LINGER_TIMEOUT_S)

    def abort(self) -> None:
        self._closing = True
        if self._transport:
            self._transport.abort()

    def _greet(self) -> None:
        """Become a client of the hub, which sends hello."""
        self._session = self._hub.open(self, self._address, self._kind, self._decoder)

    def _close(self, limit: float) -> None:
        """End the connection after all written bytes are sent, or after a time [s]."""
        if self._closing or not self._transport:
            return
        self._closing = True
        self._set_timer(asyncio.get_running_loop().call_later(limit, self.abort))
        # Closing a socket with unread bytes resets the connection, which may lose the last frame.
        # So the other side closes first. TLS has its own exchange.
        if not self._transport.can_write_eof():
            self._transport.close()
            return
        try:
            self._transport.write_eof()
        except OSError:  # the other side has closed already
            self.abort()
        else:
            self._transport.resume_reading()

    def _pause(self, pause: float) -> None:
        """Stop reading for a time [s]."""
        if pause > 0.0 and self._transport and not self._closing:
            self._transport.pause_reading()
            self._set_timer(asyncio.get_running_loop().call_later(pause, self._resume))

    def _resume(self) -> None:
        if self._closing or self._session is None or not self._transport:
            return
        pause = self._hub.receive(self._session)
        if pause > 0.0:
            self._pause(pause)
        else:
            self._transport.resume_reading()

    def _set_timer(self, timer: asyncio.TimerHandle | None) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = timer
