"""Connections at a port, with TLS if there is a certificate, and their limits.

The limits are the same for programs and the page. Every connection counts, even during the TLS
handshake or while it closes. So strangers use only a limited number of file descriptors.
"""

import asyncio
import contextlib
import errno
import socket
import ssl
from abc import abstractmethod
from collections import Counter, deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, is_loopback, network_of
from workbench.link.codes import ErrorCode

LISTEN_BACKLOG = 4096
"""Largest number of connections waiting in the system to be accepted, as many as Linux allows: who
finds the queue full tries again only after a second."""
MAX_BEGUN_CONNECTIONS = 256
"""Largest number of connections that have begun."""
MAX_PENDING_CONNECTIONS = 24
"""Largest number of accepted connections that wait to begin. So one that is not chosen ends after
some 50 ms, and its program tries again."""
ACCEPTS_PER_TURN = 48
"""Number of connections accepted in a turn of the loop; each takes 30 us. They are taken faster
than a program can make them, as the system delays who finds its queue full by a second."""
BEGINS_PER_TURN = 2
"""Largest number of connections begun in a turn; each takes 0.15 ms up to the greeting."""
BEGIN_RATE_HZ = 500.0
"""Rate at which connections begin [1/s]. So one that begins keeps its place for `MOST / BEGIN_RATE`
at least, which is enough for a login."""
BEGIN_PERIOD_S = 1e-3
"""Pause before further waiting connections begin [s]."""
NO_TLS = "others than this machine are served over TLS alone"
CROWD_REASON = "too many connections at once: the oldest one without a login was ended"
ACCEPT_RETRY_S = 0.2
"""Pause before accepting again if the system has no free file descriptor [s]."""
LINGER_TIMEOUT_S = 1.0
"""Time limit to send the last bytes [s]."""
HANDSHAKE_TIMEOUT_S = 3.0
HANDSHAKE_COST_BYTES = 2048
"""Cost of a TLS handshake, see `Hub.later`."""
TLS_CLOSE_TIMEOUT_S = 1.0
"""Time limit for the end of TLS [s]."""
KEEPALIVE_IDLE_S = 5
"""Silence after which the system probes the other side (TCP keepalive) [s]."""
KEEPALIVE_INTERVAL_S = 2
KEEPALIVE_PROBES = 3
TCP_USER_TIMEOUT_MS = 10_000
"""Time after which the system gives up on unacknowledged data (TCP_USER_TIMEOUT)."""
TCP_OPTIONS = {
    "TCP_KEEPIDLE": KEEPALIVE_IDLE_S,
    "TCP_KEEPINTVL": KEEPALIVE_INTERVAL_S,
    "TCP_KEEPCNT": KEEPALIVE_PROBES,
    "TCP_USER_TIMEOUT": TCP_USER_TIMEOUT_MS,
}
"""Options of connections by their names in `socket`, which has those of the system."""


class AcceptedProtocol(asyncio.Protocol):
    """The protocol of an accepted connection.

    Attributes:
        ended: set when the connection has ended.
    """

    def __init__(self) -> None:
        self.ended = asyncio.Event()

    @property
    @abstractmethod
    def is_in(self) -> bool:
        """Whether it has logged in, so that its connection is kept."""

    @abstractmethod
    def close(self) -> None:
        """End the connection after all written bytes are sent, or after `LINGER_TIMEOUT_S` at
        most.
        """

    @abstractmethod
    def abort(self) -> None:
        """End the connection at once."""


class AcceptedConnection(NamedTuple):
    """A connection that has not begun."""

    end: socket.socket
    address: Address
    network: str


class PendingConnections:
    """Accepted connections that wait to begin, by their networks.

    Attributes:
        count: number of them.
    """

    def __init__(self) -> None:
        self._networks: dict[str, deque[AcceptedConnection]] = {}
        self.count = 0

    def add(self, accepted: AcceptedConnection) -> AcceptedConnection | None:
        """Add a connection; return one that has to go, the oldest of the largest network."""
        self._networks.setdefault(accepted.network, deque()).append(accepted)
        self.count += 1
        if self.count <= MAX_PENDING_CONNECTIONS:
            return None
        largest = max(self._networks, key=lambda network: len(self._networks[network]))
        return self._taken(largest, deque.popleft)

    def take(self, begun: Mapping[str, int]) -> AcceptedConnection | None:
        """Remove and return the newest connection of the network with the fewest, if any waits.

        The oldest ones may have waited for too long already.

        Args:
            begun: number of connections of each network that have begun.
        """
        if not self._networks:
            return None
        network = min(self._networks, key=lambda network: begun.get(network, 0))
        return self._taken(network, deque.pop)

    def _taken(
        self, network: str, take: Callable[[deque[AcceptedConnection]], AcceptedConnection]
    ) -> AcceptedConnection:
        waiting = self._networks[network]
        accepted = take(waiting)
        self.count -= 1
        if not waiting:
            del self._networks[network]
        return accepted


class Acceptor:
    """Accepts connections in the running loop.

    If too many connections wait to begin, or have begun, the oldest one without a login ends, of
    the network that has most of these. So nobody without a login can keep out who has one.

    Args:
        listener: the listening socket; this object owns it from now on.
        make: makes the protocol of a connection from its "HOST:PORT".
        refuse: counts a rejection, by code and sentence.
        context: for TLS, None without.
        later: calls as soon as a turn of the loop has time, see `Hub.later`.
    """

    def __init__(
        self,
        listener: socket.socket,
        make: Callable[[str], AcceptedProtocol],
        refuse: Callable[[str, str], None],
        context: ssl.SSLContext | None = None,
        later: Callable[[Callable[[], int]], object] = lambda call: call(),
    ) -> None:
        self._listener = listener
        self._make = make
        self._refuse = refuse
        self._context = context
        self._later = later
        self._loop = asyncio.get_running_loop()
        self._waiting = PendingConnections()
        self._guests: dict[AcceptedProtocol, str] = {}  # their networks, the oldest guest first
        self._handshakes: dict[AcceptedProtocol, asyncio.Task[None]] = {}
        self._timer: asyncio.TimerHandle | None = None
        self._due = 0.0  # connections that may begin, at a time of the loop
        self._counted = self._loop.time()
        self._watch()

    @property
    def address(self) -> Address:
        """The address that it listens at."""
        return Address(*self._listener.getsockname()[:2])

    async def close(self) -> None:
        """Stop listening, end all connections, and wait until their last bytes are sent."""
        self._loop.remove_reader(self._listener)
        self._listener.close()
        if self._timer is not None:
            self._timer.cancel()
        while (accepted := self._waiting.take({})) is not None:
            accepted.end.close()
        for guest in list(self._handshakes):
            self._guests.pop(guest, None)
            self._end(guest)
        for guest in self._guests:
            guest.close()
        ended = [guest.ended.wait() for guest in self._guests]
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*ended), 2.0 * LINGER_TIMEOUT_S)

    def _watch(self) -> None:
        if self._listener.fileno() >= 0:
            self._loop.add_reader(self._listener, self._accept)

    def _accept(self) -> None:
        for _ in range(ACCEPTS_PER_TURN):
            try:
                end, address = self._listener.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                break
            except OSError as error:
                self._refuse(ErrorCode.TOO_MANY, f"no connection can be accepted: {error}")
                self._loop.remove_reader(self._listener)
                self._loop.call_later(ACCEPT_RETRY_S, self._watch)
                break
            host, port = address[:2]
            if self._context is None and not is_loopback(host):
                self._refuse("tls", f"{host}: {NO_TLS}")
                end.close()
                continue
            accepted = AcceptedConnection(end, Address(host, port), network_of(host))
            if (shed := self._waiting.add(accepted)) is not None:
                self._turn_away(shed)
        if self._timer is None:
            self._begin_some()

    def _begin_some(self) -> None:
        """Begin with some of the waiting connections; the others follow."""
        self._timer = None
        now = self._loop.time()
        self._due = min(BEGINS_PER_TURN, self._due + BEGIN_RATE_HZ * (now - self._counted))
        self._counted = now
        self._guests = {one: of for one, of in self._guests.items() if not one.ended.is_set()}
        strangers = {one: of for one, of in self._guests.items() if not one.is_in}
        counts = Counter(strangers.values())
        while self._due >= 1.0 and (accepted := self._waiting.take(counts)) is not None:
            self._due -= 1.0
            if len(self._guests) >= MAX_BEGUN_CONNECTIONS:
                if not strangers:
                    self._turn_away(accepted)
                    continue
                most = max(counts.values())
                oldest = next(one for one, of in strangers.items() if counts[of] == most)
                counts[strangers.pop(oldest)] -= 1
                self._leave(oldest)
            strangers[self._begin(accepted)] = accepted.network
            counts[accepted.network] += 1
        if self._waiting.count:
            self._timer = self._loop.call_later(BEGIN_PERIOD_S, self._begin_some)

    def _begin(self, accepted: AcceptedConnection) -> AcceptedProtocol:
        _set_up(accepted.end)
        address = str(accepted.address)
        guest = self._make(address)
        self._guests[guest] = accepted.network
        task = self._loop.create_task(self._connect(accepted.end, address, guest))
        self._handshakes[guest] = task
        task.add_done_callback(lambda _: self._handshakes.pop(guest, None))
        return guest

    def _turn_away(self, accepted: AcceptedConnection) -> None:
        self._refuse(ErrorCode.TOO_MANY, f"{accepted.address.host}: {CROWD_REASON}")
        accepted.end.close()

    def _leave(self, guest: AcceptedProtocol) -> None:
        """End the connection of a stranger, even during its handshake, to make room."""
        network = self._guests.pop(guest)
        self._refuse(ErrorCode.TOO_MANY, f"{network}: {CROWD_REASON}")
        self._end(guest)

    def _end(self, guest: AcceptedProtocol) -> None:
        if (handshake := self._handshakes.pop(guest, None)) is not None:
            handshake.cancel()
        guest.abort()

    async def _connect(self, end: socket.socket, address: str, guest: AcceptedProtocol) -> None:
        """Make the TLS handshake, if any, and start the protocol of the connection."""
        tls = self._context is not None
        try:
            if tls:
                await self._first_bytes(end)
            await self._loop.connect_accepted_socket(
                lambda: guest,
                end,
                ssl=self._context,
                ssl_handshake_timeout=HANDSHAKE_TIMEOUT_S if tls else None,
                ssl_shutdown_timeout=TLS_CLOSE_TIMEOUT_S if tls else None,
            )
        except OSError as error:  # not TLS, a reset, or a timeout
            end.close()
            self._guests.pop(guest, None)
            if tls:
                reason = getattr(error, "reason", None) or error
                said = f"{address}: no TLS: {reason}: connect with TLS to this port"
                self._refuse("tls", said)

    async def _first_bytes(self, end: socket.socket) -> None:
        """Wait until a client begins its TLS handshake, and the loop has time for it."""
        begun: asyncio.Future[None] = self._loop.create_future()

        def go_on() -> int:
            if begun.done():
                return 0
            begun.set_result(None)
            return HANDSHAKE_COST_BYTES

        def heard() -> None:
            self._loop.remove_reader(end)
            self._later(go_on)

        self._loop.add_reader(end, heard)
        try:
            async with asyncio.timeout(HANDSHAKE_TIMEOUT_S):
                await begun
        except BaseException:
            self._loop.remove_reader(end)
            end.close()
            raise


def _set_up(end: socket.socket) -> None:
    end.setblocking(False)
    with contextlib.suppress(OSError):  # the other side may be gone
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in TCP_OPTIONS.items():
            if hasattr(socket, name):  # macOS has no TCP_USER_TIMEOUT, and some are new there
                end.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


def listen(host: str, port: int) -> socket.socket:
    """Return a non-blocking listening socket, at the first address of a name.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, *_, address = found[0]
        # The complete tuple, as a link-local address needs its scope.
        listener = socket.create_server(address, family=family, backlog=LISTEN_BACKLOG)
    except socket.gaierror as error:
        raise WorkbenchError(f"'{host}' is not a host of this machine: {error.strerror}") from error
    except (OSError, OverflowError, UnicodeError) as error:
        raise WorkbenchError(_listen_error(error, host, port)) from error
    listener.setblocking(False)
    return listener


def _listen_error(error: Exception, host: str, port: int) -> str:
    match getattr(error, "errno", None):
        case errno.EADDRINUSE:
            return f"port {port} at {host} is in use: end its program, or choose another port"
        case errno.EADDRNOTAVAIL:
            return f"{host} is not an address of this machine: listen at one that is, or at 0.0.0.0"
        case errno.EACCES:
            return f"port {port} at {host} is reserved: take one above 1023"
    return f"cannot listen at {host}:{port}: {error}"
