"""Sends messages without blocking the sender, whatever the reader does."""

import logging
import pickle
import select
import threading
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

MAX_OFFERED_MESSAGES = 100
"""Number of waiting messages at which `offer` refuses further ones."""
MAX_NONBLOCKING_BYTES = 2000
"""Longest message that a socket takes without blocking whenever it is writable [bytes]."""


class SendQueue:
    """A queue in front of a connection; a thread empties it.

    Messages are sent in order. Of messages for display only the newest counts: it replaces one that
    is not sent yet, so a slow or stopped reader costs neither time nor memory.

    A short message is sent in the caller's thread if nothing waits and the socket is writable: a
    busy process can take 20 ms until another of its threads runs.

    Args:
        connection: connection to the reader.
        name: name of the thread.
    """

    def __init__(self, connection: Connection, name: str = "send queue") -> None:
        self._connection = connection
        self._writable = select.poll()
        self._writable.register(connection.fileno(), select.POLLOUT)
        self._waiting: deque[bytes] = deque()
        self._shown: bytes | None = None
        self._sending = self._closing = False
        self._change = threading.Condition()
        self._thread = threading.Thread(target=self._empty, name=name, daemon=True)
        self._thread.start()

    def post(self, message: object) -> None:
        """Queue a message; it is pickled now, and raises here if that is impossible."""
        data = pickle.dumps(message)
        with self._change:
            if self._shown is not None:  # the shown message is older, so it goes first
                self._waiting.append(self._shown)
                self._shown = None
            self._add(data)

    def offer(self, message: object) -> bool:
        """Queue a message unless many wait; return whether it was queued.

        It may overtake a message for display.
        """
        with self._change:
            if len(self._waiting) >= MAX_OFFERED_MESSAGES:
                return False
        data = pickle.dumps(message)
        with self._change:
            self._add(data)
        return True

    def show(self, message: object) -> None:
        """Queue a message for display; a newer one replaces it."""
        data = pickle.dumps(message)
        with self._change:
            self._shown = data
            self._change.notify()

    def close(self, limit: float) -> None:
        """Send waiting messages for at most a time [s], and accept no more."""
        with self._change:
            self._closing = True
            self._change.notify()
        self._thread.join(limit)

    def _add(self, data: bytes) -> None:
        """Send a message at once if that cannot block, else leave it to the thread."""
        idle = not self._waiting and not self._sending
        if idle and len(data) <= MAX_NONBLOCKING_BYTES and self._writable.poll(0):
            self._send(data)
        else:
            self._waiting.append(data)
            self._change.notify()

    def _empty(self) -> None:
        """Send until closed, or until the reader is gone."""
        while (data := self._next()) is not None and self._send(data):
            pass

    def _send(self, data: bytes) -> bool:
        """Send a message; return whether there still is a reader."""
        try:
            self._connection.send_bytes(data)
        # The reader is gone, which its listener notices; or (TypeError) the connection was
        # closed here in the middle of a message.
        except (OSError, TypeError):
            return False
        return True

    def _next(self) -> bytes | None:
        """Wait for a message to send; None at the end."""
        with self._change:
            self._sending = False
            while True:
                if self._waiting or self._shown is not None:
                    self._sending = True
                    if self._waiting:
                        return self._waiting.popleft()
                    data, self._shown = self._shown, None
                    return data
                if self._closing:
                    return None
                self._change.wait()


class LogSender(logging.Handler):
    """Sends log messages.

    Args:
        queue: sends them.
        message: makes a message from a sentence.
    """

    def __init__(self, queue: SendQueue, message: Callable[[str], object]) -> None:
        super().__init__(logging.INFO)
        self._queue = queue
        self._message = message

    def emit(self, record: logging.LogRecord) -> None:
        self._queue.post(self._message(record.getMessage()))
