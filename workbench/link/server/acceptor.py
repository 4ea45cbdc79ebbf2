"""Accepts connections at a port, TCP and page alike: only so many, counted before anything else.

Who has never said a word, shakes hands for TLS or hears its last words counts as well as a client
does, so strangers cost so many descriptors and no more.
"""

import asyncio
import contextlib
import errno
import socket
import ssl
from collections.abc import Callable

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, network_of
from workbench.link.codes import ErrorCode

WAITING = 512
"""Connections that the system keeps until they are accepted."""
MOST = 128
"""Connections at once."""
MOST_OF_A_NETWORK = 32
"""Of one address (of IPv6, one network of 64 bits); a browser opens half a dozen for a page."""
AT_ONCE = 2
"""Connections that are accepted before anything else is done: each takes about a millisecond until
its client has received hello."""
REST = 0.2
"""Until accepting is tried again when the system has no more descriptors [s]."""
HANDSHAKE_TIME = 3.0
GOODBYE_TIME = 1.0
"""For the end of TLS [s]."""
IDLE = 5
"""Silence after which the system asks whether the other side is there [s]."""
ASK_EVERY = 2
ASK_TIMES = 3
UNHEARD_MS = 10_000
"""Until the system gives up on what the other side does not confirm."""


class Acceptor:
    """Accepts connections within the running loop, until it is closed.

    Args:
        listener: the socket that listens; it belongs to this from now on.
        make: makes what a connection is handed to, whose "HOST:PORT" it is told.
        refuse: counts who is refused: a code and a sentence.
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
        """Where it listens."""
        return Address(*self._listener.getsockname()[:2])

    async def close(self) -> None:
        """Listen no longer, and end what still shakes hands."""
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
        """Return whether one more may come; a socket that was closed has no number any more."""
        self._open = {end: of for end, of in self._open.items() if end.fileno() >= 0}
        same = sum(of == network for of in self._open.values())
        return len(self._open) < MOST and same < MOST_OF_A_NETWORK

    async def _begin(self, end: socket.socket, address: str) -> None:
        """Shake hands, if need be; the connection runs by itself then."""
        tls = self._context is not None
        try:
            await self._loop.connect_accepted_socket(
                lambda: self._make(address),
                end,
                ssl=self._context,
                ssl_handshake_timeout=HANDSHAKE_TIME if tls else None,
                ssl_shutdown_timeout=GOODBYE_TIME if tls else None,
            )
        except OSError as error:  # TLS that is none, a reset, or silence
            end.close()
            if tls:
                reason = getattr(error, "reason", None) or error
                said = f"{address}: no TLS: {reason}: connect with TLS to this port"
                self._refuse("tls", said)


def _set_up(end: socket.socket) -> None:
    end.setblocking(False)
    with contextlib.suppress(OSError):  # the other side may have gone already
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, IDLE)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, ASK_EVERY)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPCNT, ASK_TIMES)
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, UNHEARD_MS)


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens and never waits: one, also where a name has several addresses.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = found[0]
        # All of the address: that of a link counts only with its number.
        listener = socket.create_server(address, family=family, backlog=WAITING)
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
