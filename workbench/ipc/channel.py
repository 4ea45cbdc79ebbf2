"""A connection that never waits, in either direction, for who must not stand still.

The other side is a `multiprocessing.connection.Connection`: a record is a pickle after its length,
4 bytes, high byte first.
"""

import pickle
import socket
import struct
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection

LENGTH = struct.Struct("!i")
PIECE = 65536
"""Bytes that are read at once."""


class Channel:
    """Sends and receives records over a connection without a thread.

    A record that does not fit into the system's buffer waits here, and goes on its way with the
    next call; of one that has not come as a whole nothing is seen yet.

    Args:
        connection: stays the caller's, and is used by nobody else as long as this is.
    """

    def __init__(self, connection: Connection) -> None:
        self._socket = socket.socket(fileno=socket.dup(connection.fileno()))
        self._socket.setblocking(False)
        self._unsent = bytearray()
        self._unread = bytearray()

    def fileno(self) -> int:
        """Return its number, to be watched."""
        return self._socket.fileno()

    @property
    def unsent(self) -> int:
        """Bytes that wait to be sent."""
        return len(self._unsent)

    @property
    def has_more(self) -> bool:
        """Whether a whole record waits to be yielded."""
        return len(self._unread) >= LENGTH.size and len(self._unread) >= self._end()

    def offer(self, record: object, most: int) -> bool:
        """Send a record, unless more than so many bytes would wait; return whether it will be."""
        self.flush()
        data = pickle.dumps(record)
        if self._unsent and len(self._unsent) + LENGTH.size + len(data) > most:
            return False
        self._unsent += LENGTH.pack(len(data)) + data
        self.flush()
        return True

    def flush(self) -> None:
        """Send as much of what waits as goes."""
        with suppress(OSError):  # it would have to wait; or nobody is there, as `received` says
            while self._unsent:
                del self._unsent[: self._socket.send(self._unsent)]

    def received(self, most: int) -> Iterator[object]:
        """Yield up to so many records that have come.

        Raises:
            EOFError: if the other side is gone, and all that it sent was yielded.
        """
        gone = self._read()
        for _ in range(most):
            if not self.has_more:
                if gone:
                    raise EOFError
                return
            end = self._end()
            record = pickle.loads(memoryview(self._unread)[LENGTH.size : end].tobytes())
            del self._unread[:end]
            yield record

    def close(self) -> None:
        """Let go of the connection; what waits is lost."""
        self._socket.close()

    def _end(self) -> int:
        """Return where the first record ends."""
        return LENGTH.size + int(LENGTH.unpack_from(self._unread)[0])

    def _read(self) -> bool:
        """Take a piece of what has come; return whether the other side is gone."""
        try:
            piece = self._socket.recv(PIECE)
        except BlockingIOError:
            return False
        except OSError:
            return True
        self._unread += piece
        return not piece
