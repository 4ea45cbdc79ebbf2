"""The port for programs: frames over TCP, with TLS where there is a certificate."""

import asyncio
import contextlib
import ssl

from workbench.link.server.door import Door
from workbench.link.server.hub import Hub
from workbench.link.server.listening import listen
from workbench.link.server.tcp_connection import LINGER, TcpConnection


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
        self._door = Door(
            listen(host, port),
            lambda address: TcpConnection(hub, self._open, address, kind),
            hub.refusals.add,
            context,
        )

    @property
    def address(self) -> str:
        """Where it listens, "HOST:PORT"."""
        return str(self._door.address)

    async def close(self) -> None:
        """Listen no longer; wait until the last words are out."""
        await self._door.close()
        for connection in list(self._open):
            connection.close()
        ended = [connection.ended.wait() for connection in self._open]
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.gather(*ended), 2.0 * LINGER)
