"""The server's process: `python -P -m workbench.link.server.process FD`, a socket to the flight.

It ends when it is told to, or when the flight does. It loads neither Drake nor numpy.
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
from workbench.link.server.tcp import TcpListener

MOST_RECEIVED = 64
"""Records of the flight that are passed on at once."""
BUFFER = 16 * 1024
"""Bytes on their way to the flight: a command that waits there for long is of no use."""
LARGEST = 1_000_000
"""No record has more bytes."""
CLOSING = 2.0
"""Time to send what waits at the end [s]."""
RETRY = 0.01
NAME = "drake-drone-workbench"
FAREWELL = "the server stops"


class FlightConnection:
    """Sends records to the flight, which may stand still, and hands over what it says.

    All is done in the server's loop: a thread would have to wait for its turn with each record, and
    these are to be passed on within a millisecond.

    What waits to be sent is little, however long the flight stands still: of each client its first
    and its newest command and its few requests, and the newest status.

    Args:
        connection: to the flight; it belongs to this from now on.
    """

    def __init__(self, connection: Connection) -> None:
        with contextlib.suppress(OSError), _socket_of(connection) as end:
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
        self._connection = connection
        self._channel = Channel(connection)
        self._waiting: deque[FromServer] = deque()
        self._known: set[int] = set()  # clients that the flight has heard of
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self, receive: Callable[[list[object]], None], ended: Callable[[], None]) -> None:
        """Begin to send and to receive, in the running loop.

        Args:
            receive: is called with the records that have come.
            ended: is called when the flight's end is closed.
        """
        self._receive, self._ended = receive, ended
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._channel.fileno(), self._read)
        self._write()

    def tell(self, record: FromServer) -> None:
        """Send a record when the flight reads; a newer one may take its place before that."""
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
        """Send what waits, and let go of the connection."""
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
        """Send what goes without waiting; return whether anything is left."""
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
        """Return the place of a client's last command if a newer one may take it, else None.

        The first one stays, as it may be the neutral one that a new holder begins with; and none
        comes before a request that it was sent after.
        """
        own = [at for at, each in enumerate(self._waiting) if _is_of(each, peer)]
        if len(own) > 1 and all(isinstance(self._waiting[at], Command) for at in own[-2:]):
            return own[-1]
        return None

    def _forget(self, peer: int) -> None:
        """Leave out the commands of a client that is gone; what it asked for last still counts.

        Of one that the flight has never heard of, nothing does.
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
    """Return the connection's socket, under another number."""
    return socket.socket(fileno=os.dup(connection.fileno()))


def main(connection: Connection) -> int:
    """Serve the flight that the first messages describe, and return the exit code."""
    try:
        config, flight = connection.recv(), connection.recv()
    except (EOFError, OSError):
        return 0
    if not isinstance(config, ServerConfig) or not isinstance(flight, Flight):
        return 1
    gc.freeze()  # modules are no garbage, and to look through them all stops the server for 16 ms
    try:
        config.check()
        uvloop.run(serve(connection, config, flight))
    except WorkbenchError as error:
        with contextlib.suppress(OSError):  # nobody is there to be told
            connection.send(ServerFailed(str(error)))
    return 0


async def serve(connection: Connection, config: ServerConfig, flight: Flight) -> None:
    """Serve a flight until it says stop or its end of the connection is closed.

    Args:
        connection: to the flight; closed at the end.
        config: where, and whom; checked.
        flight: what is flown.

    Raises:
        WorkbenchError: if the token file is no good any more.
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
    except Exception as error:  # a fault of ours: the flight is to know
        flight_connection.tell(ServerFailed(f"the server failed: {type(error).__name__}: {error}"))
        raise
    finally:
        await flight_connection.close()


async def _open(stack: contextlib.AsyncExitStack, hub: Hub, config: ServerConfig) -> None:
    """Listen, and serve the page if it is wanted.

    Raises:
        WorkbenchError: if it is not possible to listen there.
    """
    listener = TcpListener(config.host, config.port, hub, config.tls())
    stack.push_async_callback(listener.close)
    hub.address = listener.address
    if config.web:
        from workbench.link.server import web  # loads what only the page needs

        page = web.Page(hub, config)
        await page.open()
        stack.push_async_callback(page.close)
        hub.page = page.address


async def _run(hub: Hub) -> None:
    """Look after the clients until the flight stops."""
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
    # the clients have heard goodbye: nothing is left to be taken down
    os._exit(main(Connection(int(sys.argv[1]))))
