"""Connections at a port, with TLS if there is a certificate, and frames over TCP for programs.

The limits of the number of connections are the same for programs and the page. Every connection
counts, even during the TLS handshake or while it closes. So strangers use only a limited number of
file descriptors.
"""

import asyncio
import contextlib
import errno
import socket
import ssl
from collections.abc import Callable
from typing import cast

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, network_of
from workbench.link.codes import ErrorCode
from workbench.link.server.client_session import ClientSession
from workbench.link.server.hub import Hub
from workbench.link.wire import Decoder

WAITING = 512
"""Largest number of connections waiting in the system to be accepted."""
MOST = 128
"""Largest number of connections."""
MOST_OF_A_NETWORK = 32
"""Largest number of connections from one address (for IPv6, one network of 64 bits); a browser
opens half a dozen for a page."""
AT_ONCE = 2
"""Number of connections accepted in a turn of the loop; each takes about a millisecond up to the
greeting."""
REST = 0.2
"""Pause before accepting again if the system has no free file descriptor [s]."""
HANDSHAKE_TIME = 3.0
GOODBYE_TIME = 1.0
"""Time limit for the end of TLS [s]."""
IDLE = 5
"""Silence after which the system probes the other side (TCP keepalive) [s]."""
ASK_EVERY = 2
ASK_TIMES = 3
UNHEARD_MS = 10_000
"""Time after which the system gives up on unacknowledged data (TCP_USER_TIMEOUT)."""


class Acceptor:
    """Accepts connections in the running loop.

    Args:
        listener: the listening socket; this object owns it from now on.
        make: makes the protocol of a connection from its "HOST:PORT".
        refuse: counts a rejection, by code and sentence.
        context: for TLS, None without.
    """

    def __init__(
        self,
        listener: socket.socket,
        make: Callable[[str], asyncio.BaseProtocol],
        refuse: Callable[[str, str], None],
        context: ssl.SSLContext | None,
    ) -> None:
        self._listener = listener
        self._make = make
        self._refuse = refuse
        self._context = context
        self._loop = asyncio.get_running_loop()
        self._open: dict[socket.socket, str] = {}
        self._handshakes: set[asyncio.Task[None]] = set()
        self._watch()

    @property
    def address(self) -> Address:
        """The address that it listens at."""
        return Address(*self._listener.getsockname()[:2])

    async def close(self) -> None:
        """Stop listening, and end unfinished handshakes."""
        self._loop.remove_reader(self._listener)
        self._listener.close()
        for task in self._handshakes:
            task.cancel()
        await asyncio.gather(*self._handshakes, return_exceptions=True)

    def _watch(self) -> None:
        if self._listener.fileno() >= 0:
            self._loop.add_reader(self._listener, self._accept)

    def _accept(self) -> None:
        for _ in range(AT_ONCE):
            try:
                end, address = self._listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                self._refuse(ErrorCode.TOO_MANY, f"no connection can be accepted: {error}")
                self._loop.remove_reader(self._listener)
                self._loop.call_later(REST, self._watch)
                return
            host, port = address[:2]
            network = network_of(host)
            if not self._has_room(network):
                end.close()
                self._refuse(ErrorCode.TOO_MANY, f"{host}: too many connections at once")
                continue
            _set_up(end)
            self._open[end] = network
            task = self._loop.create_task(self._begin(end, str(Address(host, port))))
            self._handshakes.add(task)
            task.add_done_callback(self._handshakes.discard)

    def _has_room(self, network: str) -> bool:
        """Return whether one more connection is allowed; a closed socket has the descriptor -1."""
        self._open = {end: of for end, of in self._open.items() if end.fileno() >= 0}
        same = sum(of == network for of in self._open.values())
        return len(self._open) < MOST and same < MOST_OF_A_NETWORK

    async def _begin(self, end: socket.socket, address: str) -> None:
        """Make the TLS handshake, if any, and start the protocol of the connection."""
        tls = self._context is not None
        try:
            await self._loop.connect_accepted_socket(
                lambda: self._make(address),
                end,
                ssl=self._context,
                ssl_handshake_timeout=HANDSHAKE_TIME if tls else None,
                ssl_shutdown_timeout=GOODBYE_TIME if tls else None,
            )
        except OSError as error:  # not TLS, a reset, or a timeout
            end.close()
            if tls:
                reason = getattr(error, "reason", None) or error
                said = f"{address}: no TLS: {reason}: connect with TLS to this port"
                self._refuse("tls", said)


def _set_up(end: socket.socket) -> None:
    end.setblocking(False)
    with contextlib.suppress(OSError):  # the other side may be gone
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, IDLE)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, ASK_EVERY)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, ASK_TIMES)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, UNHEARD_MS)


def listen(host: str, port: int) -> socket.socket:
    """Return a non-blocking listening socket, at the first address of a name.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = found[0]
        # The complete tuple, as a link-local address needs its scope.
        listener = socket.create_server(address, family=family, backlog=WAITING)
    except socket.gaierror as error:
        raise WorkbenchError(f"'{host}' is not a host of this machine: {error.strerror}") from error
    except (OSError, OverflowError, UnicodeError) as error:
        raise WorkbenchError(_reason(error, host, port)) from error
    listener.setblocking(False)
    return listener


def _reason(error: Exception, host: str, port: int) -> str:
    match getattr(error, "errno", None):
        case errno.EADDRINUSE:
            return f"port {port} at {host} is in use: end its program, or choose another port"
        case errno.EADDRNOTAVAIL:
            return f"{host} is not an address of this machine: listen at one that is, or at 0.0.0.0"
        case errno.EACCES:
            return f"port {port} at {host} is reserved: take one above 1023"
    return f"cannot listen at {host}:{port}: {error}"


LINGER = 1.0
"""Time limit to send the last frames [s]."""
MOST_DROPPED = 256 * 1024
"""Largest number of bytes read after the last frame, so that a reset does not lose that frame."""


class TcpListener:
    """Accepts the connections of programs.

    Args:
        host: name or address to listen at.
        port: 0 for a free one.
        hub: handles the clients.
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
        """The address that it listens at, "HOST:PORT"."""
        return str(self._acceptor.address)

    async def close(self) -> None:
        """Stop listening, and wait until the last frames are sent."""
        await self._acceptor.close()
        for connection in list(self._open):
            connection.close()
        ended = [connection.ended.wait() for connection in self._open]
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*ended), 2.0 * LINGER)


class TcpConnection(asyncio.Protocol):
    """One connection: a transport for the hub, and a protocol for asyncio."""

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

    def abort(self) -> None:
        self._closing = True
        self._transport.abort()

    def _pause(self, pause: float) -> None:
        """Stop reading for a time [s]."""
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
