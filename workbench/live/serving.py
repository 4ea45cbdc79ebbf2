"""The flight's end of its server: what goes there never waits, and its end is noticed."""

import math
import threading
import time
from collections.abc import Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection

from workbench.link.backplane import Flight, Published, Stop
from workbench.link.channel import Channel
from workbench.link.server.config import ServerConfig
from workbench.live.process import ChildProcess

MOST_TOPICS = 1_000_000
"""Bytes that wait for the server, a second of topics or more; further topics are left out."""
MOST_ANSWERS = 8_000_000
"""The same of answers and of who flies, without which clients would wait for ever."""
MOST_HEARD = 200
"""Records of the server that are heard at once, so that it cannot stop the flight."""
RETRY = 0.01
"""After which what did not go at once is tried again [s]."""
CLOSING = 2.0
"""Time that the server has to say goodbye [s]."""


class Serving:
    """A server's process.

    Args:
        config: what it is to do.
        flight: what is flown.

    Raises:
        WorkbenchError: if no process can be started.
    """

    def __init__(self, config: ServerConfig, flight: Flight) -> None:
        self._process = ChildProcess("workbench.link.server.process", "server")
        self._channel = Channel(self._process.connection)
        self._channel.offer(config, MOST_ANSWERS)
        self._channel.offer(flight, MOST_ANSWERS)

    @property
    def connection(self) -> Connection:
        """Readable when the server has said something, or is gone."""
        return self._process.connection

    @property
    def pid(self) -> int:
        """Number of its process."""
        return self._process.pid

    @property
    def patience(self) -> float:
        """How long nothing is to be done here, whatever comes [s]."""
        if self._channel.has_more:
            return 0.0
        return RETRY if self._channel.unsent else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, unless the server does not keep up: newer ones will come."""
        self._channel.offer(published, MOST_TOPICS)

    def tell(self, record: object) -> None:
        """Send what must not be lost.

        Raises:
            EOFError: if the server has read nothing for so long that it is of no use.
        """
        if not self._channel.offer(record, MOST_ANSWERS):
            raise EOFError

    def heard(self) -> Iterator[object]:
        """Yield what the server said, up to a bound.

        Raises:
            EOFError: if it is gone.
        """
        self._channel.flush()
        yield from self._channel.received(MOST_HEARD)

    def cause(self) -> str:
        """Say why it ended."""
        return self._process.cause()

    def close(self) -> None:
        """Let it say goodbye, and end it; this may take seconds."""
        self._channel.offer(Stop.STOP, 2 * MOST_ANSWERS)
        end = time.monotonic() + CLOSING
        while self._channel.unsent and time.monotonic() < end:
            time.sleep(RETRY)
            self._channel.flush()
        self._channel.close()
        self._process.end(max(0.0, end - time.monotonic()))
        self._process.release()


class Ending:
    """Ends a server in a thread, as no flight waits for a server that stands still.

    Args:
        serving: the server's process.
        said: why it ends; None if it ended by itself, so that the cause is to be found.

    Attributes:
        said: why it ended, once `connection` is readable.
        connection: readable when the server is gone.
    """

    def __init__(self, serving: Serving, said: str | None) -> None:
        self.said = said or ""
        self.connection, self._end = Pipe(duplex=False)
        self._serving, self._is_known = serving, said is not None
        self._thread = threading.Thread(target=self._run, name="ending a server", daemon=True)
        self._thread.start()

    def join(self) -> None:
        """Wait until the server is gone."""
        self._thread.join()
        self.connection.close()

    def _run(self) -> None:
        try:
            if not self._is_known:
                self.said = self._serving.cause()
            self._serving.close()
        finally:
            self._end.close()
