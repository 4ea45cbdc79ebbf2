"""A connection that never blocks, in either direction, for loops that must keep running.

The other side is a `multiprocessing.connection.Connection`: each record is a pickle, preceded by
its length in 4 bytes, big-endian.
"""

import pickle
import socket
import struct
from collections import deque
from collections.abc import Iterator
from multiprocessing.connection import Connection

LENGTH_PREFIX = struct.Struct("!i")
CHANNEL_READ_BYTES = 65536
"""Bytes per read."""


class RecordChannel:
    """Sends and receives records over a connection without a thread.

    What does not fit into the system's buffer waits here and is sent with the next calls: as bytes
    if it was offered, else as a record in `waiting`. A received record is yielded only when it is
    complete.

    Args:
        connection: still belongs to the caller; nothing else may use it while this object does.

    Attributes:
        waiting: records for `flush` to send after all offered ones; their order may be changed, and
            newer ones may replace them.
    """

    def __init__(self, connection: Connection) -> None:
        self._socket = socket.socket(fileno=socket.dup(connection.fileno()))
        self._socket.setblocking(False)
        self.waiting: deque[object] = deque()
        self._unsent = bytearray()
        self._unread = bytearray()

    def fileno(self) -> int:
        """Return the file descriptor, for an event loop to watch."""
        return self._socket.fileno()

    @property
    def unsent(self) -> int:
        """Number of bytes that wait to be sent."""
        return len(self._unsent)

    @property
    def has_more(self) -> bool:
        """Whether a complete record waits to be yielded."""
        return len(self._unread) >= LENGTH_PREFIX.size and len(self._unread) >= self._end()

    def offer(self, record: object, most: int) -> bool:
        """Queue a record unless more than `most` bytes would wait; return whether it was queued."""
        self.flush()
        data = _framed(record)
        if self._unsent and len(self._unsent) + len(data) > most:
            return False
        self._unsent += data
        self.flush()
        return True

    def flush(self) -> bool:
        """Send as much as possible without blocking; return whether anything is left.

        If the other side is gone, what is left is lost; `received` reports that.
        """
        try:
            while self._unsent or self.waiting:
                if not self._unsent:
                    self._unsent += _framed(self.waiting.popleft())
                del self._unsent[: self._socket.send(self._unsent)]
        except BlockingIOError:
            return True  # the rest is sent with the next call
        except OSError:
            self._unsent.clear()
            self.waiting.clear()
        return False

    def received(self, most: int) -> Iterator[object]:
        """Yield at most this many received records.

        Raises:
            EOFError: if the other side is gone and everything that it sent was yielded.
        """
        gone = self._read()
        for _ in range(most):
            if not self.has_more:
                if gone:
                    raise EOFError
                return
            end = self._end()
            record = pickle.loads(memoryview(self._unread)[LENGTH_PREFIX.size : end].tobytes())
            del self._unread[:end]
            yield record

    def close(self) -> None:
        """Release the connection; unsent records are lost."""
        self._socket.close()

    def _end(self) -> int:
        """Return where the first record ends."""
        return LENGTH_PREFIX.size + int(LENGTH_PREFIX.unpack_from(self._unread)[0])

    def _read(self) -> bool:
        """Read the next bytes; return whether the other side is gone."""
        try:
            piece = self._socket.recv(CHANNEL_READ_BYTES)
        except BlockingIOError:
            return False
        except OSError:
            return True
        self._unread += piece
        return not piece


def _framed(record: object) -> bytes:
    data = pickle.dumps(record)
    return LENGTH_PREFIX.pack(len(data)) + data
