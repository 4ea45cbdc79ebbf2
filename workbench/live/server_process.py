"""The process of the server as the flight sees it, and its shutdown."""

import math
import threading
import time
from multiprocessing import Pipe
from multiprocessing.connection import Connection

from workbench.ipc.channel import RecordChannel
from workbench.ipc.child_process import ChildProcess
from workbench.link.backplane import Published, ServedFlight, StopServer
from workbench.link.server.config import ServerConfig

MAX_TOPIC_BYTES = 1_000_000
"""Limit of waiting bytes for the server, a second of topics or more; further topics are left
out."""
MAX_ANSWER_BYTES = 8_000_000
"""The same limit for answers and control messages, without which clients would wait for ever."""
RETRY_PAUSE_S = 0.01
"""Pause before unsent data is tried again [s]."""
SERVER_CLOSE_TIMEOUT_S = 2.0
"""Time limit for the server to say goodbye [s]."""


class ServerProcess(RecordChannel):
    """A server's process, and the channel to it.

    Args:
        config: configuration of the server.
        flight: description of the flight.

    Raises:
        WorkbenchError: if the process cannot be started.
    """

    def __init__(self, config: ServerConfig, flight: ServedFlight) -> None:
        self._process = ChildProcess("workbench.link.server.process", "server")
        super().__init__(self._process.connection)
        self.offer(config, MAX_ANSWER_BYTES)
        self.offer(flight, MAX_ANSWER_BYTES)

    @property
    def connection(self) -> Connection:
        """Readable when the server has sent something, or is gone."""
        return self._process.connection

    @property
    def wait_time(self) -> float:
        """Time until something is due here, whatever arrives [s]."""
        if self.has_more:
            return 0.0
        return RETRY_PAUSE_S if self.unsent else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, unless the server does not keep up: newer ones will follow."""
        self.offer(published, MAX_TOPIC_BYTES)

    def tell(self, record: object) -> None:
        """Send a message that must not be lost.

        Raises:
            EOFError: if the server has read nothing for so long that it is useless.
        """
        if not self.offer(record, MAX_ANSWER_BYTES):
            raise EOFError

    def cause(self) -> str:
        """Return why it ended."""
        return self._process.cause()

    def close(self) -> None:
        """Let the server say goodbye, and end it; this may take seconds."""
        self.offer(StopServer.STOP, 2 * MAX_ANSWER_BYTES)
        end = time.monotonic() + SERVER_CLOSE_TIMEOUT_S
        while self.unsent and time.monotonic() < end:
            time.sleep(RETRY_PAUSE_S)
            self.flush()
        super().close()
        self._process.end(max(0.0, end - time.monotonic()))
        self._process.release()


class ServerShutdown:
    """Ends a server in a thread, as no flight waits for a server that hangs.

    Args:
        process: the server's process.
        said: why it ends; None if it ended by itself and the cause is still unknown.

    Attributes:
        said: why it ended, once `connection` is readable.
        connection: readable when the server is gone.
    """

    def __init__(self, process: ServerProcess, said: str | None) -> None:
        self.said = said or ""
        self.connection, self._end = Pipe(duplex=False)
        self._process, self._is_known = process, said is not None
        self._thread = threading.Thread(target=self._run, name="ending a server", daemon=True)
        self._thread.start()

    def join(self) -> None:
        """Wait until the server is gone."""
        self._thread.join()
        self.connection.close()

    def _run(self) -> None:
        try:
            if not self._is_known:
                self.said = self._process.cause()
            self._process.close()
        finally:
            self._end.close()
