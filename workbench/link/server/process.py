"""The server's process: `python -P -m workbench.link.server.process FD`, a socket to the flight.

It ends when it is told to, or when the flight does. It loads neither Drake nor numpy.
"""

import asyncio
import contextlib
import gc
import importlib.metadata
import os
import sys
from multiprocessing.connection import Connection

from workbench.common.errors import WorkbenchError
from workbench.link.backplane import Flight, ServerFailed
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.flight_connection import FlightConnection
from workbench.link.server.hub import TICK_PERIOD, Hub
from workbench.link.server.policy import Policy
from workbench.link.server.tcp import TcpListener

NAME = "drake-drone-workbench"
FAREWELL = "the server stops"


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
        asyncio.run(serve(connection, config, flight))
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

        page = await web.start(hub, config)
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
