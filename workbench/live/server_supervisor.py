"""The server of a live flight: begun and ended at any time, one after the other.

A server that ends by itself, be it killed, is started again at the same address. The flight goes on
meanwhile: the drone holds, as the connection of whoever flew it has ended.
"""

import dataclasses
import math
import threading
import time
from collections.abc import Callable, Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from urllib.parse import urlsplit

from workbench.common.errors import WorkbenchError
from workbench.ipc.channel import Channel
from workbench.ipc.child_process import ChildProcess
from workbench.ipc.worker_process import Answer, Refusal
from workbench.link.backplane import Flight, Published, ServerFailed, ServerStatus, Stop
from workbench.link.server.config import ServerConfig

STOPPED = "the server was stopped"
STOOD_STILL = "the server read nothing any more, and was ended"
PAUSES = (0.1, 0.5, 1.0, 2.0, 4.0)
"""Before a server is started again, one after the other [s]; after the last one it is not."""
STABLE = 60.0
"""A server that has listened for so long may be started again as often as a new one [s]."""
MOST_TOPICS = 1_000_000
"""Bytes that wait for the server, a second of topics or more; further topics are left out."""
MOST_ANSWERS = 8_000_000
"""The same of answers and of who flies, without which clients would wait for ever."""
MOST_RECEIVED = 200
"""Records of the server that are dealt with at once, so that it cannot stop the flight."""
RETRY = 0.01
"""After which what did not go at once is tried again [s]."""
CLOSING = 2.0
"""Time that the server has to say goodbye [s]."""


class ServerProcess(Channel):
    """A server's process, and the channel to it.

    Args:
        config: what it is to do.
        flight: what is flown.

    Raises:
        WorkbenchError: if no process can be started.
    """

    def __init__(self, config: ServerConfig, flight: Flight) -> None:
        self._process = ChildProcess("workbench.link.server.process", "server")
        super().__init__(self._process.connection)
        self.offer(config, MOST_ANSWERS)
        self.offer(flight, MOST_ANSWERS)

    @property
    def connection(self) -> Connection:
        """Readable when the server has said something, or is gone."""
        return self._process.connection

    @property
    def wait_time(self) -> float:
        """How long nothing is to be done here, whatever comes [s]."""
        if self.has_more:
            return 0.0
        return RETRY if self.unsent else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, unless the server does not keep up: newer ones will come."""
        self.offer(published, MOST_TOPICS)

    def tell(self, record: object) -> None:
        """Send what must not be lost.

        Raises:
            EOFError: if the server has read nothing for so long that it is of no use.
        """
        if not self.offer(record, MOST_ANSWERS):
            raise EOFError

    def cause(self) -> str:
        """Say why it ended."""
        return self._process.cause()

    def close(self) -> None:
        """Let it say goodbye, and end it; this may take seconds."""
        self.offer(Stop.STOP, 2 * MOST_ANSWERS)
        end = time.monotonic() + CLOSING
        while self.unsent and time.monotonic() < end:
            time.sleep(RETRY)
            self.flush()
        super().close()
        self._process.end(max(0.0, end - time.monotonic()))
        self._process.release()


class Ending:
    """Ends a server in a thread, as no flight waits for a server that stands still.

    Args:
        process: the server's.
        said: why it ends; None if it ended by itself, so that the cause is to be found.

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


class ServerSupervisor:
    """Starts a server, takes what it says, and notices its end; nothing here waits.

    Args:
        flight: tells what is flown.
        time: tells the simulated time [s].
        now: rises, whatever happens to the date [s].

    Attributes:
        status: as the server said last, None where none runs.
        said: why it ended by itself, and what comes of it, "" else.
        answers: to the operator's orders, for whoever sends them.
    """

    def __init__(
        self,
        flight: Callable[[], Flight],
        time: Callable[[], float],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._flight, self._time, self._now = flight, time, now
        self.status: ServerStatus | None = None
        self.said = ""
        self.answers: list[Answer | Refusal] = []
        self._process: ServerProcess | None = None
        self._starting: int | None = None
        self._ending: Ending | None = None
        self._stopping: list[int] = []
        self._next: tuple[int, ServerConfig] | None = None
        self._config = ServerConfig()
        self._again_due: float | None = None
        self._restarts = 0
        self._since = math.inf
        self._was_ready = False

    @property
    def starts_again(self) -> bool:
        """Whether a server that has ended by itself is being started again."""
        return self._again_due is not None or (self._restarts > 0 and self.status is None)

    @property
    def serves(self) -> bool:
        """Whether there is a server that has not been told to end."""
        return self._process is not None

    @property
    def connections(self) -> list[Connection]:
        """Readable when there is something to hear."""
        return [each.connection for each in (self._process, self._ending) if each]

    def serve(self, number: int, config: ServerConfig) -> None:
        """Begin a server, once the last one is gone; its address answers an order.

        Raises:
            WorkbenchError: if there is one, or the configuration is no good.
        """
        if self._process or self._next:
            raise WorkbenchError("the flight is served already: stop its server first")
        config.check()
        self._config, self._again_due, self._restarts = config, None, 0
        if self._ending:  # its port may be the one that is wanted
            self._next = number, config
            return
        self._process, self._starting = ServerProcess(config, self._flight()), number

    def stop(self, number: int) -> None:
        """End the server, if there is one, and answer an order when it is gone."""
        if self._next:
            (waiting, _), self._next = self._next, None
            self.answers.append(Refusal(waiting, STOPPED))
        if self.starts_again:
            self.said = ""
        self._again_due, self._restarts = None, 0
        if self._process:
            self._end(self._process, "")
        if self._ending:
            self._stopping.append(number)
        else:
            self.answers.append(Answer(number, self._time()))

    @property
    def wait_time(self) -> float:
        """How long nothing is to be done here, whatever comes [s]."""
        if self._again_due is not None:
            return max(0.0, self._again_due - self._now())
        return self._process.wait_time if self._process else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, if there is a server."""
        if self._process:
            self._process.publish(published)

    def tell(self, record: object) -> None:
        """Send what must not be lost, if there is a server."""
        if self._process:
            try:
                self._process.tell(record)
            except EOFError:
                self._end(self._process, STOOD_STILL)

    def heard(self) -> Iterator[object]:
        """Yield what clients ask for; the rest is dealt with here."""
        if self._ending and self._ending.connection.poll():
            self._ended(self._ending)
        if self._again_due is not None and self._now() >= self._again_due:
            self._start_again()
        process = self._process
        if not process:
            return
        try:
            process.flush()
            for record in process.received(MOST_RECEIVED):
                match record:
                    case ServerFailed(said):
                        return self._end(process, said)
                    case ServerStatus():
                        self._take(record)
                    case _:
                        yield record
        except EOFError:
            self._end(process, None)

    def close(self) -> None:
        """End the server, and wait until it is gone."""
        self._again_due, self._restarts = None, 0
        if self._process:
            self._end(self._process, "")
        if self._ending:
            self._ending.join()

    def _take(self, status: ServerStatus) -> None:
        if self.status is None:
            self._since = self._now()
            self._config = _at_the_same_ports(self._config, status)
        self.status, self.said = status, ""
        if self._starting is not None:
            self.answers.append(Answer(self._starting, status.address))
            self._starting = None

    def _end(self, process: ServerProcess, said: str | None) -> None:
        """End the server and say why; None where that is to be found out."""
        self._ending, self._process = Ending(process, said), None
        if self.status is not None and self._now() - self._since > STABLE:
            self._restarts = 0
        self._was_ready = self.status is not None or self._restarts > 0
        self.status, self.said = None, said or ""

    def _ended(self, ending: Ending) -> None:
        """Say what came of it, now that the server is gone."""
        ending.join()
        self._ending, self.said = None, ending.said
        if self._starting is not None:
            self.answers.append(Refusal(self._starting, ending.said or STOPPED))
            self._starting = None
        elif ending.said and self._was_ready and not self._stopping:
            self._plan_again(ending.said)
        self.answers += [Answer(number, self._time()) for number in self._stopping]
        self._stopping.clear()
        if self._next:
            (number, config), self._next = self._next, None
            try:
                self.serve(number, config)
            except WorkbenchError as error:
                self.answers.append(Refusal(number, str(error)))

    def _plan_again(self, cause: str) -> None:
        """Have a server that has ended by itself started again, but not for ever."""
        if self._restarts == len(PAUSES):
            self._restarts = 0
            self.said = f"{cause}; it was started again {len(PAUSES)} times in vain: start it anew"
            return
        self._again_due = self._now() + PAUSES[self._restarts]
        self._restarts += 1
        self.said = f"{cause}; it is started again"

    def _start_again(self) -> None:
        self._again_due = None
        try:
            self._config.check()
            self._process = ServerProcess(self._config, self._flight())
        except WorkbenchError as error:  # the token file is gone, or the system has no room
            self._plan_again(str(error))


def _at_the_same_ports(config: ServerConfig, status: ServerStatus) -> ServerConfig:
    """Return the configuration of a server that listens where this one does."""
    page = urlsplit(status.page).port if status.page else None
    port = int(status.address.rpartition(":")[2])
    return dataclasses.replace(config, port=port, web_port=page or config.web_port)
