"""The process of the server: `python -P -m workbench.link.server.process FD`.

FD is a socket to the flight. The process ends on request, or when the flight ends. It loads neither
Drake nor numpy.
"""

import asyncio
import contextlib
import gc
import importlib.metadata
import os
import socket
import sys
import time
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

import uvloop

from workbench.common.errors import WorkbenchError
from workbench.ipc.channel import Channel
from workbench.link.backplane import Command, Flight, FromServer, Gone, ServerFailed, ServerStatus
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import TICK_PERIOD, Hub
from workbench.link.server.policy import Policy
from workbench.link.server.tcp import listen_tcp

MOST_RECEIVED = 64
"""Largest number of records of the flight processed in a turn of the loop."""
BUFFER = 16 * 1024
"""Size of the buffer to the flight [bytes]; it is small, as old commands are useless."""
LARGEST = 1_000_000
"""Largest size of a record [bytes]."""
CLOSING = 2.0
"""Time limit to send waiting records at the end [s]."""
RETRY = 0.01
NAME = "drake-drone-workbench"
FAREWELL = "the server stops"


class FlightConnection:
    """Sends records to the flight, which may be stopped, and receives records from it.

    Everything runs in the server's event loop: a thread would have to wait for the interpreter at
    each record, and records should be passed on within a millisecond.

    The queue stays short even if the flight is stopped for long. It has the first and the newest
    command and the few requests of each client, and the newest status.

    Args:
        connection: to the flight; this object owns it from now on.
    """

    def __init__(self, connection: Connection) -> None:
        with contextlib.suppress(OSError), _socket_of(connection) as end:
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
        self._connection = connection
        self._channel = Channel(connection)
        self._waiting: deque[FromServer] = deque()
        self._known: set[int] = set()  # clients that the flight knows
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self, receive: Callable[[list[object]], None], ended: Callable[[], None]) -> None:
        """Start to send and receive, in the running loop.

        Args:
            receive: called with received records.
            ended: called when the flight has closed its end.
        """
        self._receive, self._ended = receive, ended
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._channel.fileno(), self._read)
        self._write()

    def tell(self, record: FromServer) -> None:
        """Queue a record; a newer one may replace it before it is sent."""
        match record:
            case Command():
                if (older := self._superseded(record.peer)) is None:
                    self._waiting.append(record)
                else:
                    self._waiting[older] = record
            case Gone(peer):
                self._forget(peer)
                if peer in self._known:
                    self._known.discard(peer)
                    self._waiting.append(record)
            case ServerStatus():
                kept = [each for each in self._waiting if not isinstance(each, ServerStatus)]
                self._waiting = deque([*kept, record])
            case _:
                self._waiting.append(record)
        self._write()

    async def close(self) -> None:
        """Send waiting records, and close the connection."""
        end = time.monotonic() + CLOSING
        while self._write() and time.monotonic() < end:
            await asyncio.sleep(RETRY)
        if self._loop:
            self._loop.remove_reader(self._channel.fileno())
            self._loop.remove_writer(self._channel.fileno())
            self._loop = None
        self._channel.close()
        self._connection.close()

    def _write(self) -> bool:
        """Send as much as possible without blocking; return whether anything is left."""
        if self._loop is None:
            return False
        self._channel.flush()
        while not self._channel.unsent:
            if not self._waiting:
                self._loop.remove_writer(self._channel.fileno())
                return False
            record = self._waiting.popleft()
            if not isinstance(record, Gone | ServerStatus | ServerFailed):
                self._known.add(record.peer)
            self._channel.offer(record, LARGEST)
        self._loop.add_writer(self._channel.fileno(), self._write)
        return True

    def _read(self) -> None:
        if self._loop is None:
            return
        records: list[object] = []
        gone = False
        try:
            records.extend(self._channel.received(MOST_RECEIVED))
        except EOFError:
            gone = True
        if records:
            self._receive(records)
        if gone:
            self._loop.remove_reader(self._channel.fileno())
            self._ended()
        elif self._channel.has_more:
            self._loop.call_soon(self._read)

    def _superseded(self, peer: int) -> int | None:
        """Return the index of the last command of a client that a newer one may replace, or None.

        The first command stays, as it may be the neutral one of a new holder. Commands and requests
        stay in order.
        """
        own = [at for at, each in enumerate(self._waiting) if _is_of(each, peer)]
        if len(own) > 1 and all(isinstance(self._waiting[at], Command) for at in own[-2:]):
            return own[-1]
        return None

    def _forget(self, peer: int) -> None:
        """Remove the waiting commands of a client that is gone, but not its requests.

        If the flight does not know the client, remove its requests, too.
        """
        known = peer in self._known
        self._waiting = deque(
            each
            for each in self._waiting
            if not _is_of(each, peer) or (known and not isinstance(each, Command))
        )


def _is_of(record: FromServer, peer: int) -> bool:
    return getattr(record, "peer", 0) == peer


def _socket_of(connection: Connection) -> socket.socket:
    """Return the socket of a connection with a new file descriptor."""
    return socket.socket(fileno=os.dup(connection.fileno()))


def main(connection: Connection) -> int:
    """Serve the flight that the first messages describe, and return the exit code."""
    try:
        config, flight = connection.recv(), connection.recv()
    except (EOFError, OSError):
        return 0
    if not isinstance(config, ServerConfig) or not isinstance(flight, Flight):
        return 1
    gc.freeze()  # a garbage collection of all modules would stop the server for 16 ms
    try:
        config.check()
        uvloop.run(serve(connection, config, flight))
    except WorkbenchError as error:
        with contextlib.suppress(OSError):  # the flight is gone
            connection.send(ServerFailed(str(error)))
    return 0


async def serve(connection: Connection, config: ServerConfig, flight: Flight) -> None:
    """Serve a flight until it says stop or its end of the connection is closed.

    Args:
        connection: to the flight; closed at the end.
        config: of the server, checked.
        flight: the flight to serve.

    Raises:
        WorkbenchError: if the token file is no longer valid.
    """
    policy = Policy(flight, config.tokens(), config.allow_commands, config.clients, _server())
    flight_connection = FlightConnection(connection)
    hub = Hub(
        policy,
        Admission(config.clients, config.clients_an_address),
        flight_connection.tell,
        call_soon=asyncio.get_running_loop().call_soon,
    )
    flight_connection.start(hub.hear, hub.stopped.set)
    asyncio.get_running_loop().set_exception_handler(
        lambda _, what: hub.failed(str(what.get("message")), what.get("exception"))
    )
    try:
        async with contextlib.AsyncExitStack() as stack:
            await _open(stack, hub, config)
            await _run(hub)
            hub.stop(FAREWELL)
    except WorkbenchError as error:
        flight_connection.tell(ServerFailed(str(error)))
    except Exception as error:  # a bug of ours: report it to the flight
        flight_connection.tell(ServerFailed(f"the server failed: {type(error).__name__}: {error}"))
        raise
    finally:
        await flight_connection.close()


async def _open(stack: contextlib.AsyncExitStack, hub: Hub, config: ServerConfig) -> None:
    """Listen, and serve the page if requested.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    acceptor = listen_tcp(config.host, config.port, hub, config.tls())
    stack.push_async_callback(acceptor.close)
    hub.address = str(acceptor.address)
    if config.web:
        from workbench.link.server import web  # loads packages that only the page needs

        page = web.Page(hub, config)
        await page.open()
        stack.push_async_callback(page.close)
        hub.page = page.address


async def _run(hub: Hub) -> None:
    """Check the clients regularly until the flight stops the server."""
    while not hub.stopped.is_set():
        hub.tick()
        try:
            await asyncio.wait_for(hub.stopped.wait(), TICK_PERIOD)
        except TimeoutError:
            continue


def _server() -> str:
    """Return the server's name and version."""
    try:
        return f"{NAME} {importlib.metadata.version(NAME)}"
    except importlib.metadata.PackageNotFoundError:
        return NAME


if __name__ == "__main__":
    # all connections are closed: skip the cleanup
    os._exit(main(Connection(int(sys.argv[1]))))
