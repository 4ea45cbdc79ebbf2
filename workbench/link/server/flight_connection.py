"""The server's end of the connection to its flight, which may stand still without harm to anybody.

All is done in the server's loop: a thread would have to wait for its turn with each record, and
these are to be passed on within a millisecond.
"""

import asyncio
import contextlib
import os
import socket
import time
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

from workbench.ipc.channel import Channel
from workbench.link.backplane import Command, FromServer, Gone, ServerFailed, ServerStatus

MOST_RECEIVED = 64
"""Records of the flight that are passed on at once."""
BUFFER = 16 * 1024
"""Bytes on their way to the flight: a command that waits there for long is of no use."""
LARGEST = 1_000_000
"""No record has more bytes."""
CLOSING = 2.0
"""Time to send what waits at the end [s]."""
RETRY = 0.01


class FlightConnection:
    """Sends records to the flight and hands over what it says.

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
