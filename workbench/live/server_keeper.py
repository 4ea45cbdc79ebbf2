"""The server of a live flight: begun and ended at any time, one after the other.

A server that ends by itself, be it killed, is started again at the same address. The flight goes on
meanwhile: the drone holds, as the connection of whoever flew it has ended.
"""

import dataclasses
import math
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from urllib.parse import urlsplit

from workbench.common.errors import WorkbenchError
from workbench.link.backplane import Flight, Published, ServerFailed, ServerStatus
from workbench.link.server.config import ServerConfig
from workbench.live.messages import Answer, Refusal
from workbench.live.serving import Ending, Serving

STOPPED = "the server was stopped"
STOOD_STILL = "the server read nothing any more, and was ended"
PAUSES = (0.1, 0.5, 1.0, 2.0, 4.0)
"""Before a server is started again, one after the other [s]; after the last one it is not."""
CALM = 60.0
"""A server that has listened for so long may be started again as often as a new one [s]."""


class ServerKeeper:
    """Begins a server, hears it, and notices its end; nothing here waits.

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
        self._serving: Serving | None = None
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
        return self._serving is not None

    @property
    def connections(self) -> list[Connection]:
        """Readable when there is something to hear."""
        return [each.connection for each in (self._serving, self._ending) if each]

    def serve(self, number: int, config: ServerConfig) -> None:
        """Begin a server, once the last one is gone; its address answers an order.

        Raises:
            WorkbenchError: if there is one, or the configuration is no good.
        """
        if self._serving or self._next:
            raise WorkbenchError("the flight is served already: stop its server first")
        config.check()
        self._config, self._again_due, self._restarts = config, None, 0
        if self._ending:  # its port may be the one that is wanted
            self._next = number, config
            return
        self._serving, self._starting = Serving(config, self._flight()), number

    def stop(self, number: int) -> None:
        """End the server, if there is one, and answer an order when it is gone."""
        if self._next:
            (waiting, _), self._next = self._next, None
            self.answers.append(Refusal(waiting, STOPPED))
        if self.starts_again:
            self.said = ""
        self._again_due, self._restarts = None, 0
        if self._serving:
            self._end(self._serving, "")
        if self._ending:
            self._stopping.append(number)
        else:
            self.answers.append(Answer(number, self._time()))

    @property
    def patience(self) -> float:
        """How long nothing is to be done here, whatever comes [s]."""
        if self._again_due is not None:
            return max(0.0, self._again_due - self._now())
        return self._serving.patience if self._serving else math.inf

    def publish(self, published: Published) -> None:
        """Send topics, if there is a server."""
        if self._serving:
            self._serving.publish(published)

    def tell(self, record: object) -> None:
        """Send what must not be lost, if there is a server."""
        if self._serving:
            try:
                self._serving.tell(record)
            except EOFError:
                self._end(self._serving, STOOD_STILL)

    def heard(self) -> Iterator[object]:
        """Yield what clients ask for; the rest is dealt with here."""
        if self._ending and self._ending.connection.poll():
            self._ended(self._ending)
        if self._again_due is not None and self._now() >= self._again_due:
            self._start_again()
        serving = self._serving
        if not serving:
            return
        try:
            for record in serving.heard():
                match record:
                    case ServerFailed(said):
                        return self._end(serving, said)
                    case ServerStatus():
                        self._take(record)
                    case _:
                        yield record
        except EOFError:
            self._end(serving, None)

    def close(self) -> None:
        """End the server, and wait until it is gone."""
        self._again_due, self._restarts = None, 0
        if self._serving:
            self._end(self._serving, "")
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

    def _end(self, serving: Serving, said: str | None) -> None:
        """End the server and say why; None where that is to be found out."""
        self._ending, self._serving = Ending(serving, said), None
        if self.status is not None and self._now() - self._since > CALM:
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
            self._serving = Serving(self._config, self._flight())
        except WorkbenchError as error:  # the token file is gone, or the system has no room
            self._plan_again(str(error))


def _at_the_same_ports(config: ServerConfig, status: ServerStatus) -> ServerConfig:
    """Return the configuration of a server that listens where this one does."""
    page = urlsplit(status.page).port if status.page else None
    port = int(status.address.rpartition(":")[2])
    return dataclasses.replace(config, port=port, web_port=page or config.web_port)
