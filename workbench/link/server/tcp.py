"""Listens for connections by TCP, with TLS where there is a certificate."""

import asyncio
import contextlib
import errno
import socket
import ssl

from workbench.errors import WorkbenchError
from workbench.link.address import Address
from workbench.link.server.hub import Hub
from workbench.link.server.tcp_connection import LINGER, TcpConnection

WAITING = 512
"""Connections that the system keeps until they are accepted."""
AT_ONCE = 16
"""Connections that are accepted before anything else is done."""
SPARE = 32
"""Connections beyond the clients: those that are refused and those that shake hands."""
REST = 0.2
"""Until accepting is tried again when the system has no more descriptors [s]."""
HANDSHAKE_TIME = 3.0
IDLE = 5
"""Silence after which the system asks whether the other side is there [s]."""
ASK_EVERY = 2
ASK_TIMES = 3
UNHEARD_MS = 10_000
"""Until the system gives up on what the other side does not confirm."""


class TcpListener:
    """Accepts connections and brings them to the hub.

    Args:
        host: name or address where to listen.
        port: 0 for one that is free.
        hub: whom clients talk to.
        most: connections at once, those that are refused included.
        context: for TLS, None without.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """

    def __init__(
        self, host: str, port: int, hub: Hub, most: int, context: ssl.SSLContext | None
    ) -> None:
        self._hub = hub
        self._most = most
        self._context = context
        self._loop = asyncio.get_running_loop()
        self._socket = listen(host, port)
        self._open: set[TcpConnection] = set()
        self._tasks: set[asyncio.Task[None]] = set()
        self._watch()

    @property
    def address(self) -> str:
        """Where it listens, "HOST:PORT"."""
        return str(Address(*self._socket.getsockname()[:2]))

    async def close(self) -> None:
        """Listen no longer; wait until the last words are out."""
        self._loop.remove_reader(self._socket)
        self._socket.close()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for connection in list(self._open):
            connection.close()
        ended = [connection.ended.wait() for connection in self._open]
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*ended), 2.0 * LINGER)

    def _watch(self) -> None:
        if self._socket.fileno() >= 0:
            self._loop.add_reader(self._socket, self._accept)

    def _accept(self) -> None:
        for _ in range(AT_ONCE):
            try:
                end, address = self._socket.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                self._hub.refusals.add("too_many", f"no connection can be accepted: {error}")
                self._loop.remove_reader(self._socket)
                self._loop.call_later(REST, self._watch)
                return
            if len(self._open) + len(self._tasks) >= self._most:
                end.close()
                self._hub.refusals.add("too_many", f"{address[0]}: too many connections at once")
                continue
            _set_up(end)
            task = self._loop.create_task(self._begin(end, str(Address(*address[:2]))))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    async def _begin(self, end: socket.socket, address: str) -> None:
        """Shake hands, if need be; the connection runs by itself then."""
        kind = "tcp" if self._context is None else "tls"
        limit = None if self._context is None else HANDSHAKE_TIME
        try:
            await self._loop.connect_accepted_socket(
                lambda: TcpConnection(self._hub, self._open, address, kind),
                end,
                ssl=self._context,
                ssl_handshake_timeout=limit,
                ssl_shutdown_timeout=limit and LINGER,
            )
        except OSError as error:  # TLS that is none, a reset, or silence
            end.close()
            if self._context is not None:
                reason = getattr(error, "reason", None) or error
                said = f"{address}: no TLS: {reason}: connect with TLS to this port"
                self._hub.refusals.add("tls", said)


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens and never waits.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = found[0]
        listener = socket.create_server(address[:2], family=family, backlog=WAITING)
    except socket.gaierror as error:
        raise WorkbenchError(f"'{host}' is no host of this machine: {error.strerror}") from error
    except (OSError, OverflowError, UnicodeError) as error:
        raise WorkbenchError(_reason(error, host, port)) from error
    listener.setblocking(False)
    return listener


def _reason(error: Exception, host: str, port: int) -> str:
    match getattr(error, "errno", None):
        case errno.EADDRINUSE:
            return f"port {port} at {host} is in use: end the program that has it, or take another"
        case errno.EADDRNOTAVAIL:
            return f"{host} is no address of this machine: listen at one that is, or at 0.0.0.0"
        case errno.EACCES:
            return f"port {port} at {host} is reserved: take one above 1023"
    return f"it is not possible to listen at {host}:{port}: {error}"


def _set_up(end: socket.socket) -> None:
    end.setblocking(False)
    with contextlib.suppress(OSError):  # the other side may have gone already
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, IDLE)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, ASK_EVERY)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, ASK_TIMES)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, UNHEARD_MS)
