"""Restart the process of the server when it ends or stalls."""

import dataclasses
import math
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from urllib.parse import urlsplit

from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerRefusal, WorkerResult
from workbench.link.backplane import Published, ServedFlight, ServerFailed, ServerStatus
from workbench.link.server.config import ServerConfig
from workbench.live.server_process import ServerProcess, ServerShutdown

SERVER_STOPPED_TEXT = "the server was stopped"
SERVER_STALLED = "the server stopped reading, and was ended"
RESTART_PAUSES_S = (0.1, 0.5, 1.0, 2.0, 4.0)
"""Pauses before restarts of a server that has not listened since the first of them [s]; after the
last one it is not restarted."""
MIN_STABLE_S = 2.0
"""A server that listened for less than this is restarted after `UNSTABLE_PAUSE_S` [s]."""
UNSTABLE_PAUSE_S = 1.0
"""Pause that keeps a server that ends at once from taking a processor for itself [s]."""


class ServerSupervisor:
    """Starts a server, and again when it ends by itself; nothing here blocks.

    A server that ends, even if killed, is restarted at the same address. Meanwhile the flight
    continues: the drone holds, because the connection of its pilot has ended.

    Args:
        flight: returns the description of the flight.
        time: returns the simulated time [s].
        now: returns a monotonic time [s].

    Attributes:
        status: last status from the server, None if none runs.
        said: why it ended by itself, and what happens next; else "".
        answers: unsent answers to the operator's orders.
    """

    def __init__(
        self,
        flight: Callable[[], ServedFlight],
        time: Callable[[], float],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._flight, self._time, self._now = flight, time, now
        self.status: ServerStatus | None = None
        self.said = ""
        self.answers: list[WorkerResult | WorkerRefusal] = []
        self._process: ServerProcess | None = None
        self._starting: int | None = None
        self._ending: ServerShutdown | None = None
        self._stopping: list[int] = []
        self._next: tuple[int, ServerConfig] | None = None
        self._config = ServerConfig()
        self._again_due: float | None = None
        self._restarts = 0  # since a server has listened
        self._since = math.inf
        self._was_ready = self._was_unstable = False

    @property
    def starts_again(self) -> bool:
        """Whether a server that ended by itself is being restarted."""
        return self._again_due is not None or (self._restarts > 0 and self.status is None)

    @property
    def serves(self) -> bool:
        """Whether there is a server without an order to end."""
        return self._process is not None

    @property
    def connections(self) -> list[Connection]:
        """Connections that become readable when a message arrives."""
        return [each.connection for each in (self._process, self._ending) if each]

    def serve(self, number: int, config: ServerConfig) -> None:
        """Start a server once the last one is gone; its address answers an order.

        Raises:
            WorkbenchError: if there is one, or the configuration is invalid.
        """
        if self._process or self._next:
            raise WorkbenchError("the flight is served already: stop its server first")
        config.check()
        self._config, self._again_due, self._restarts = config, None, 0
        if self._ending:  # the new server may need its port
            self._next = number, config
            return
        self._process, self._starting = ServerProcess(config, self._flight()), number

    def stop(self, number: int) -> None:
        """End the server, if there is one, and answer an order when it is gone."""
        if self._next:
            (waiting, _), self._next = self._next, None
            self.answers.append(WorkerRefusal(waiting, SERVER_STOPPED_TEXT))
        if self.starts_again:
            self.said = ""
        self._again_due, self._restarts = None, 0
        if self._process:
            self._end(self._process, "")
        if self._ending:
            self._stopping.append(number)
        else:
            self.answers.append(WorkerResult(number, self._time()))

    @property
    def wait_time(self) -> float:
        """Time until something is due here, whatever arrives [s]."""
        if self._again_due is not None:
            return max(0.0, self._again_due - self._now())
        return self._process.wait_time if self._process else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, if there is a server."""
        if self._process:
            self._process.publish(published)

    def tell(self, record: object) -> None:
        """Send a message that must not be lost, if there is a server."""
        if self._process:
            try:
                self._process.tell(record)
            except EOFError:
                self._end(self._process, SERVER_STALLED)

    def attend(self) -> ServerProcess | None:
        """Start or release a server that is due, and return the running one, if any.

        The caller passes what it receives to `note`, and the end of its messages to `lost`.
        """
        if self._ending and self._ending.connection.poll():
            self._ended(self._ending)
        if self._again_due is not None and self._now() >= self._again_due:
            self._start_again()
        if self._process:
            self._process.flush()
        return self._process

    def note(self, record: object) -> None:
        """Take a message about the server itself; others are the caller's."""
        match record:
            case ServerFailed(said) if self._process:
                self._end(self._process, said)
            case ServerStatus():
                self._take(record)

    def lost(self) -> None:
        """Note that the server is gone, for a reason that is still unknown."""
        if self._process:
            self._end(self._process, None)

    def close(self) -> None:
        """End the server, and wait until it is gone."""
        self._again_due, self._restarts = None, 0
        if self._process:
            self._end(self._process, "")
        if self._ending:
            self._ending.join()

    def _take(self, status: ServerStatus) -> None:
        if self.status is None:
            self._since, self._restarts = self._now(), 0
            self._config = _at_the_same_ports(self._config, status)
        self.status, self.said = status, ""
        if self._starting is not None:
            self.answers.append(WorkerResult(self._starting, status.address))
            self._starting = None

    def _end(self, process: ServerProcess, said: str | None) -> None:
        """End the server for a reason; None if the reason is still unknown."""
        self._ending, self._process = ServerShutdown(process, said), None
        self._was_ready = self.status is not None or self._restarts > 0
        self._was_unstable = self.status is not None and self._now() - self._since < MIN_STABLE_S
        self.status, self.said = None, said or ""

    def _ended(self, ending: ServerShutdown) -> None:
        """Report the end of a server that is gone."""
        ending.join()
        self._ending, self.said = None, ending.said
        if self._starting is not None:
            self.answers.append(WorkerRefusal(self._starting, ending.said or SERVER_STOPPED_TEXT))
            self._starting = None
        elif ending.said and self._was_ready and not self._stopping:
            self._plan_again(ending.said)
        self.answers += [WorkerResult(number, self._time()) for number in self._stopping]
        self._stopping.clear()
        if self._next:
            (number, config), self._next = self._next, None
            try:
                self.serve(number, config)
            except WorkbenchError as error:
                self.answers.append(WorkerRefusal(number, str(error)))

    def _plan_again(self, cause: str) -> None:
        """Restart a server that ended by itself; give up after some that do not even listen."""
        if self._restarts == len(RESTART_PAUSES_S):
            self._restarts = 0
            self.said = f"{cause}; {len(RESTART_PAUSES_S)} restarts have failed: start it yourself"
            return
        pause = UNSTABLE_PAUSE_S if self._was_unstable else RESTART_PAUSES_S[self._restarts]
        self._again_due = self._now() + pause
        self._restarts += 1
        self.said = f"{cause}; the server is started again"

    def _start_again(self) -> None:
        self._again_due = None
        try:
            self._config.check()
            self._process = ServerProcess(self._config, self._flight())
        except WorkbenchError as error:  # the token file is gone, or the system is out of resources
            self._plan_again(str(error))


def _at_the_same_ports(config: ServerConfig, status: ServerStatus) -> ServerConfig:
    """Return the configuration of a server that listens at the same address as this one."""
    page = urlsplit(status.page).port if status.page else None
    port = int(status.address.rpartition(":")[2])
    return dataclasses.replace(config, port=port, web_port=page or config.web_port)
