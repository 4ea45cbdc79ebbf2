"""The server's end of the connection to its flight, which may stand still without harm to anybody.

A thread reads and another one writes: the loop never waits for the flight. What a flight that
stands still is not told yet is little: of each client its newest command and its few requests, and
the newest status.
"""

import asyncio
import contextlib
import os
import socket
import threading
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

from workbench.link.backplane import Asked, Command, Gone, ServerFailed, ServerStatus

MOST_UNREAD = 4096
"""Records of the flight that wait for the loop; more wait in the connection."""
BUFFER = 16 * 1024
"""Bytes on their way to the flight: a command that waits there for long is of no use."""
ENDING = 2.0
"""Time for the threads to end [s]."""


class FlightSide:
    """Sends records to the flight and hands over what it says.

    Args:
        connection: to the flight; it belongs to this from now on.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._unread: deque[object] = deque()
        self._called = False
        self._waiting: deque[Asked | ServerStatus | ServerFailed] = deque()
        self._known: set[int] = set()
        self._closing = False
        self._change = threading.Condition()
        self._room = threading.Event()
        self._threads = [
            threading.Thread(target=self._read, name="from the flight", daemon=True),
            threading.Thread(target=self._write, name="to the flight", daemon=True),
        ]

    def start(self, hear: Callable[[list[object]], None], ended: Callable[[], None]) -> None:
        """Begin to send and to hear.

        Args:
            hear: is called in the running loop with the records that have come.
            ended: is called there when the flight's end is closed.
        """
        self._hear = hear
        self._ended = ended
        self._loop = asyncio.get_running_loop()
        _keep_short(self._connection)
        for thread in self._threads:
            thread.start()

    def tell(self, record: Asked | ServerStatus | ServerFailed) -> None:
        """Send a record, some time; a newer one may take its place before that."""
        with self._change:
            match record:
                case Gone(peer):
                    self._forget(peer)
                    if peer not in self._known:
                        return  # the flight has never heard of it
                    self._known.discard(peer)
                    self._waiting.append(record)
                case Command(peer):
                    self._replace(record, lambda each: getattr(each, "peer", 0) == peer)
                case ServerStatus():
                    self._replace(record, lambda each: isinstance(each, ServerStatus))
                case _:
                    self._waiting.append(record)
            self._change.notify()

    def close(self) -> None:
        """Send what waits, and let go of the connection."""
        with self._change:
            self._closing = True
            self._change.notify()
        self._threads[1].join(ENDING)
        with contextlib.suppress(OSError), _socket_of(self._connection) as end:
            end.shutdown(socket.SHUT_RDWR)  # wakes up who reads
        self._room.set()
        for thread in self._threads:
            thread.join(ENDING)
        self._connection.close()

    def _replace(self, record: Command | ServerStatus, fits: Callable[[object], bool]) -> None:
        """Put a record in the place of an older one that waits, but never before another request.

        A command that was asked for after a request must not come before it.
        """
        for at in range(len(self._waiting) - 1, -1, -1):
            if fits(self._waiting[at]):
                if type(self._waiting[at]) is type(record):
                    self._waiting[at] = record
                    return
                break
        self._waiting.append(record)

    def _forget(self, peer: int) -> None:
        kept = [each for each in self._waiting if getattr(each, "peer", 0) != peer]
        self._waiting = deque(kept)

    def _write(self) -> None:
        while (record := self._next()) is not None:
            try:
                self._connection.send(record)
            except (OSError, ValueError):
                return  # the flight is gone, as the other thread finds out

    def _next(self) -> Asked | ServerStatus | ServerFailed | None:
        """Wait for something to send; None at the end."""
        with self._change:
            while not self._waiting:
                if self._closing:
                    return None
                self._change.wait()
            record = self._waiting.popleft()
            if not isinstance(record, Gone | ServerStatus | ServerFailed):
                self._known.add(record.peer)
            return record

    def _read(self) -> None:
        with contextlib.suppress(EOFError, OSError):
            while not self._closing:
                self._unread.append(self._connection.recv())
                if not self._called:
                    self._called = True
                    self._call(self._deliver)
                while len(self._unread) > MOST_UNREAD and not self._closing:
                    self._room.clear()
                    self._room.wait()
        self._call(self._ended)

    def _deliver(self) -> None:
        self._called = False
        records = [self._unread.popleft() for _ in range(len(self._unread))]
        self._room.set()
        self._hear(records)

    def _call(self, what: Callable[[], None]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(what)


def _keep_short(connection: Connection) -> None:
    with contextlib.suppress(OSError), _socket_of(connection) as end:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER)


def _socket_of(connection: Connection) -> socket.socket:
    """Return the connection's socket, under another number."""
    return socket.socket(fileno=os.dup(connection.fileno()))
