"""The flight's end of its server: what goes there never waits, and its end is noticed."""

from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection

from workbench.link.backplane import Flight, Stop
from workbench.link.server.config import ServerConfig
from workbench.live.outbox import Outbox
from workbench.live.process import ChildProcess

MOST_WAITING = 400
"""Records for the server, two seconds of topics; further ones are left out."""
MOST_HEARD = 200
"""Records of the server that are heard at once, so that it cannot stop the flight."""
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
        self._outbox = Outbox(self._process.connection)
        self._outbox.post(config)
        self._outbox.post(flight)
        self.left_out = 0

    @property
    def connection(self) -> Connection:
        """Readable when the server has said something, or is gone."""
        return self._process.connection

    @property
    def pid(self) -> int:
        """Number of its process."""
        return self._process.pid

    def offer(self, record: object) -> None:
        """Send a record, unless the server does not keep up."""
        if not self._outbox.offer(record, MOST_WAITING):
            self.left_out += 1

    def heard(self) -> Iterator[object]:
        """Yield what the server said, up to a bound.

        Raises:
            EOFError: if it is gone.
        """
        for _ in range(MOST_HEARD):
            try:
                if not self.connection.poll():
                    return
                yield self.connection.recv()
            except OSError as error:
                raise EOFError from error

    def cause(self) -> str:
        """Say why it ended."""
        return self._process.cause()

    def close(self) -> None:
        """Let it say goodbye, and end it."""
        with suppress(OSError):
            self._outbox.offer(Stop.STOP, MOST_WAITING + 1)
        self._process.end(CLOSING)
        self._outbox.close(CLOSING)
        self._process.release()
