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
from collections import Counter
from collections.abc import Callable
from multiprocessing.connection import Connection

try:
    from uvloop import new_event_loop
except ModuleNotFoundError:  # only an extra brings it; asyncio's own needs half as much time again
    from asyncio import new_event_loop

from workbench.common.errors import WorkbenchError
from workbench.ipc.channel import RecordChannel
from workbench.link.backplane import (
    ClientDisconnected,
    FromServer,
    ServedFlight,
    ServerFailed,
    ServerStatus,
    VelocityCommand,
)
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import TICK_PERIOD_S, Hub
from workbench.link.server.policy import Policy
from workbench.link.server.tcp import listen_tcp

FLIGHT_RECORDS_PER_TURN = 64
"""Largest number of records of the flight processed in a turn of the loop."""
FLIGHT_BUFFER_BYTES = 16 * 1024
"""Size of the buffer to the flight [bytes]; it is small, as old commands are useless."""
CLOSING_TIMEOUT_S = 2.0
"""Time limit to send waiting records at the end [s]."""
SEND_RETRY_S = 0.01
SERVER_NAME = "drake-drone-workbench"
STOP_REASON = "the server stops"


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
        with (
            contextlib.suppress(OSError),
            socket.socket(fileno=os.dup(connection.fileno())) as end,
        ):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, FLIGHT_BUFFER_BYTES)
        self._connection = connection
        self._channel = RecordChannel(connection)
        self._told: Counter[int] = Counter()  # commands and requests of each client, sent or not
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
        self._loop.add_writer(self._channel.fileno(), self._write)

    def tell(self, record: FromServer) -> None:
        """Send a record, or let it wait; a newer one may then replace it."""
        waiting = self._channel.waiting
        match record:
            case VelocityCommand() if (older := self._superseded(record.peer)) is not None:
                waiting[older] = record
            case ClientDisconnected(peer):
                if self._forget(peer):
                    waiting.append(record)
            case ServerStatus():
                for older in [each for each in waiting if isinstance(each, ServerStatus)]:
                    waiting.remove(older)
                waiting.append(record)
            case _:
                self._told[getattr(record, "peer", 0)] += 1
                waiting.append(record)
        if self._loop and self._channel.flush():
            self._loop.add_writer(self._channel.fileno(), self._write)

    async def close(self) -> None:
        """Send waiting records, and close the connection."""
        end = time.monotonic() + CLOSING_TIMEOUT_S
        while self._channel.flush() and time.monotonic() < end:
            await asyncio.sleep(SEND_RETRY_S)
        if self._loop:
            self._loop.remove_reader(self._channel.fileno())
            self._loop.remove_writer(self._channel.fileno())
            self._loop = None
        self._channel.close()
        self._connection.close()

    def _write(self) -> None:
        """Send what waits, now that there is room."""
        if self._loop and not self._channel.flush():
            self._loop.remove_writer(self._channel.fileno())

    def _read(self) -> None:
        if self._loop is None:
            return
        records: list[object] = []
        gone = False
        try:
            records.extend(self._channel.received(FLIGHT_RECORDS_PER_TURN))
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
        waiting = self._channel.waiting
        own = [at for at, each in enumerate(waiting) if _is_of(each, peer)]
        if len(own) > 1 and all(isinstance(waiting[at], VelocityCommand) for at in own[-2:]):
            return own[-1]
        return None

    def _forget(self, peer: int) -> bool:
        """Remove the waiting commands of a client that is gone, but not its requests.

        If the flight does not know the client, remove its requests, too.

        Returns:
            Whether the flight knows it.
        """
        waiting = self._channel.waiting
        own = [each for each in waiting if _is_of(each, peer)]
        known = self._told.pop(peer, 0) > len(own)
        for each in own:
            if not known or isinstance(each, VelocityCommand):
                waiting.remove(each)
        return known


def _is_of(record: object, peer: int) -> bool:
    return getattr(record, "peer", 0) == peer


def main(connection: Connection) -> int:
    """Serve the flight that the first messages describe, and return the exit code."""
    try:
        config, flight = connection.recv(), connection.recv()
    except (EOFError, OSError):
        return 0
    if not isinstance(config, ServerConfig) or not isinstance(flight, ServedFlight):
        return 1
    gc.freeze()  # a garbage collection of all modules would stop the server for 16 ms
    try:
        config.check()
        with asyncio.Runner(loop_factory=new_event_loop) as runner:
            runner.run(serve_flight(connection, config, flight))
    except WorkbenchError as error:
        with contextlib.suppress(OSError):  # the flight is gone
            connection.send(ServerFailed(str(error)))
    return 0


async def serve_flight(connection: Connection, config: ServerConfig, flight: ServedFlight) -> None:
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
            await _check_until_stopped(hub)
            hub.stop(STOP_REASON)
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


async def _check_until_stopped(hub: Hub) -> None:
    """Check the clients regularly until the flight stops the server."""
    while not hub.stopped.is_set():
        hub.tick()
        try:
            await asyncio.wait_for(hub.stopped.wait(), TICK_PERIOD_S)
        except TimeoutError:
            continue


def _server() -> str:
    """Return the server's name and version."""
    try:
        return f"{SERVER_NAME} {importlib.metadata.version(SERVER_NAME)}"
    except importlib.metadata.PackageNotFoundError:
        return SERVER_NAME


if __name__ == "__main__":
    # all connections are closed: skip the cleanup
    os._exit(main(Connection(int(sys.argv[1]))))
