"""The server's end of the connection to its flight, which may stand still without harm to anybody.

All is done in the server's loop: a thread would have to wait for its turn with each record, and
these are to be passed on within a millisecond.
"""

import asyncio
import contextlib
import os
import socket
import time
from collections.abc import Callable
from multiprocessing.connection import Connection

from workbench.link.channel import Channel
from workbench.link.server.waiting import Told, Waiting

MOST_HEARD = 64
"""Records of the flight that are passed on at once."""
BUFFER = 16 * 1024
"""Bytes on their way to the flight: a command that waits there for long is of no use."""
LARGEST = 1_000_000
"""No record has more bytes."""
ENDING = 2.0
"""Time to send what waits at the end [s]."""
RETRY = 0.01


class FlightSide:
    """Sends records to the flight and hands over what it says.

    Args:
        connection: to the flight; it belongs to this from now on.
    """

    def __init__(self, connection: Connection) -> None:
        with contextlib.suppress(OSError), _socket_of(connection) as end:
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)
        self._connection = connection
        self._channel = Channel(connection)
        self._waiting = Waiting()
        self._loop: asyncio.AbstractEventLoop | None = None

    def start(self, hear: Callable[[list[object]], None], ended: Callable[[], None]) -> None:
        """Begin to send and to hear, in the running loop.

        Args:
            hear: is called with the records that have come.
            ended: is called when the flight's end is closed.
        """
        self._hear, self._ended = hear, ended
        self._loop = asyncio.get_running_loop()
        self._loop.add_reader(self._channel.fileno(), self._read)
        self._write()

    def tell(self, record: Told) -> None:
        """Send a record, some time; a newer one may take its place before that."""
        self._waiting.add(record)
        self._write()

    async def close(self) -> None:
        """Send what waits, and let go of the connection."""
        end = time.monotonic() + ENDING
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
            record = self._waiting.next()
            if record is None:
                self._loop.remove_writer(self._channel.fileno())
                return False
            self._channel.offer(record, LARGEST)
        self._loop.add_writer(self._channel.fileno(), self._write)
        return True

    def _read(self) -> None:
        if self._loop is None:
            return
        records: list[object] = []
        gone = False
        try:
            records.extend(self._channel.received(MOST_HEARD))
        except EOFError:
            gone = True
        if records:
            self._hear(records)
        if gone:
            self._loop.remove_reader(self._channel.fileno())
            self._ended()
        elif self._channel.has_more:
            self._loop.call_soon(self._read)


def _socket_of(connection: Connection) -> socket.socket:
    """Return the connection's socket, under another number."""
    return socket.socket(fileno=os.dup(connection.fileno()))
