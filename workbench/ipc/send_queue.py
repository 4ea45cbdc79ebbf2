"""Sends messages without blocking the sender, whatever the reader does."""

import logging
import pickle
import threading
from collections import deque
from collections.abc import Callable
from multiprocessing.connection import Connection

MOST_OFFERED = 100
"""Number of waiting messages at which `offer` refuses further ones."""


class SendQueue:
    """A queue in front of a connection; a thread empties it.

    Messages are sent in order. Of messages for display only the newest counts: it replaces one that
    is not sent yet, so a slow or stopped reader costs neither time nor memory.

    Args:
        connection: connection to the reader.
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
        """Queue a message; it is pickled now."""
        data = pickle.dumps(message)
        with self._change:
            if self._shown is not None:  # the shown message is older, so it goes first
                self._waiting.append(self._shown)
                self._shown = None
            self._waiting.append(data)
            self._change.notify()

    def offer(self, message: object) -> bool:
        """Queue a message unless many wait; return whether it was queued.

        It may overtake a message for display.
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

    def _empty(self) -> None:
        """Send until closed, or until the reader is gone."""
        while (data := self._next()) is not None:
            try:
                self._connection.send_bytes(data)
            # The reader is gone, which its listener notices; or (TypeError) the connection was
            # closed here in the middle of a message.
            except (OSError, TypeError):
                return

    def _next(self) -> bytes | None:
        """Wait for a message to send; None at the end."""
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
