"""Sends messages without ever letting the sender wait, whatever the other side does."""

import logging
import pickle
import threading
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

MOST_OFFERED = 100
"""Messages that wait, beyond which no further one is taken that may be left out."""


class SendQueue:
    """A queue in front of a connection, emptied by a thread.

    Messages are sent in their order. Of what is only shown the newest counts: one that was not
    sent yet is replaced by the next, so a reader that is slow, or stands still, costs neither time
    nor memory.

    Args:
        connection: to the reader.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._waiting: deque[bytes] = deque()
        self._shown: bytes | None = None
        self._closing = False
        self._change = threading.Condition()
        self._thread = threading.Thread(target=self._empty, name="send queue", daemon=True)
        self._thread.start()

    def post(self, message: object) -> None:
        """Send a message, some time; it is copied now."""
        data = pickle.dumps(message)
        with self._change:
            if self._shown is not None:  # it is older, so it goes first
                self._waiting.append(self._shown)
                self._shown = None
            self._waiting.append(data)
            self._change.notify()

    def offer(self, message: object) -> bool:
        """Send a message unless many wait; return whether it will be sent.

        It does not hold what is shown to its place in the order.
        """
        with self._change:
            if len(self._waiting) >= MOST_OFFERED:
                return False
        data = pickle.dumps(message)
        with self._change:
            self._waiting.append(data)
            self._change.notify()
        return True

    def show(self, message: object) -> None:
        """Send a message, unless a newer one is shown before that."""
        data = pickle.dumps(message)
        with self._change:
            self._shown = data
            self._change.notify()

    def close(self, limit: float) -> None:
        """Send what waits, within a time [s], and no more."""
        with self._change:
            self._closing = True
            self._change.notify()
        self._thread.join(limit)

    def _empty(self) -> None:
        """Send until closed, or until nobody reads any more."""
        while (data := self._next()) is not None:
            try:
                self._connection.send_bytes(data)
            # The reader is gone, as who listens to it finds out; or (TypeError) the connection was
            # closed here in the middle of a message.
            except (OSError, TypeError):
                return

    def _next(self) -> bytes | None:
        """Wait for something to send; None at the end."""
        with self._change:
            while True:
                if self._waiting:
                    return self._waiting.popleft()
                if self._shown is not None:
                    data, self._shown = self._shown, None
                    return data
                if self._closing:
                    return None
                self._change.wait()


class LogPoster(logging.Handler):
    """Sends what is logged.

    Args:
        queue: that sends it.
        message: makes a message of a sentence.
    """

    def __init__(self, queue: SendQueue, message: Callable[[str], object]) -> None:
        super().__init__(logging.INFO)
        self._queue = queue
        self._message = message

    def emit(self, record: logging.LogRecord) -> None:
        self._queue.post(self._message(record.getMessage()))
