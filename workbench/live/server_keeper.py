"""The server of a live flight: begun and ended at any time, one after the other."""

import math
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection

from workbench.errors import WorkbenchError
from workbench.link.backplane import Flight, Published, ServerFailed, ServerStatus
from workbench.link.server.config import ServerConfig
from workbench.live.messages import Answer, Refusal
from workbench.live.serving import Ending, Serving

STOPPED = "the server was stopped"
STOOD_STILL = "the server read nothing any more, and was ended: start it again"


class ServerKeeper:
    """Begins a server, hears it, and notices its end; nothing here waits.

    Args:
        flight: tells what is flown.
        time: tells the simulated time [s].

    Attributes:
        status: as the server said last, None where none runs.
        said: why it ended by itself, "" else.
        answers: to the operator's orders, for whoever sends them.
    """

    def __init__(self, flight: Callable[[], Flight], time: Callable[[], float]) -> None:
        self._flight, self._time = flight, time
        self.status: ServerStatus | None = None
        self.said = ""
        self.answers: list[Answer | Refusal] = []
        self._serving: Serving | None = None
        self._starting: int | None = None
        self._ending: Ending | None = None
        self._stopping: list[int] = []
        self._next: tuple[int, ServerConfig] | None = None

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
        if self._ending:  # its port may be the one that is wanted
            self._next = number, config
            return
        self._serving, self._starting = Serving(config, self._flight()), number

    def stop(self, number: int) -> None:
        """End the server, if there is one, and answer an order when it is gone."""
        if self._next:
            (waiting, _), self._next = self._next, None
            self.answers.append(Refusal(waiting, STOPPED))
        if self._serving:
            self._end(self._serving, "")
        if self._ending:
            self._stopping.append(number)
        else:
            self.answers.append(Answer(number, self._time()))

    @property
    def patience(self) -> float:
        """How long nothing is to be done here, whatever comes [s]."""
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
        if self._serving:
            self._end(self._serving, "")
        if self._ending:
            self._ending.join()

    def _take(self, status: ServerStatus) -> None:
        self.status, self.said = status, ""
        if self._starting is not None:
            self.answers.append(Answer(self._starting, status.address))
            self._starting = None

    def _end(self, serving: Serving, said: str | None) -> None:
        """End the server and say why; None where that is to be found out."""
        self._ending, self._serving = Ending(serving, said), None
        self.status, self.said = None, said or ""

    def _ended(self, ending: Ending) -> None:
        """Say what came of it, now that the server is gone."""
        ending.join()
        self._ending, self.said = None, ending.said
        if self._starting is not None:
            self.answers.append(Refusal(self._starting, ending.said or STOPPED))
            self._starting = None
        self.answers += [Answer(number, self._time()) for number in self._stopping]
        self._stopping.clear()
        if self._next:
            (number, config), self._next = self._next, None
            try:
                self.serve(number, config)
            except WorkbenchError as error:
                self.answers.append(Refusal(number, str(error)))
