"""Watch and fly a drone over the link, with asyncio; `Client` is the same for plain programs."""

import asyncio
import random
from collections.abc import Callable, Sequence
from typing import TypeVar

from workbench.common.errors import WorkbenchError
from workbench.link.address import parse_address
from workbench.link.client_tls import make_trust
from workbench.link.control import AsyncControl
from workbench.link.direct_control import AsyncDirectControl
from workbench.link.hello import Hello
from workbench.link.inbox import Inbox
from workbench.link.line import Line, RefusedError, open_line
from workbench.link.operations import GetParameters, Operation, Ping, Role
from workbench.link.pending import REQUEST_LIMIT, Pending
from workbench.link.sample import Sample
from workbench.link.server_messages import ControlState, ParameterValues, Pong
from workbench.link.wishes import full_name, make_wishes

FIRST_PAUSE = 0.1
LONGEST_PAUSE = 5.0
"""Between attempts to connect again; each is twice the one before [s]."""

T = TypeVar("T")


class AsyncClient:
    """A client of a drone's server, as an asynchronous context manager that yields samples.

    A lost connection is made again, with growing pauses, and subscribed to again; control is
    never taken again by itself. A program that reads too slowly gets the newest of each topic.

    Args:
        address: of the server, HOST:PORT.
        name: what others see of the client, at most 48 bytes.
        token: of the role, from the server's token file; none where it needs none.
        role: view or command (the default) - what the token is for.
        tls: True if the system's authorities vouch for the server, the path of a file of
            certificates, or `sha256:` and the fingerprint of its certificate; None for no TLS.
        topics: names, as `velocity_data`, or "*" for all.
        rate: largest samples a second of each topic; None for all there are [1/s].
        reconnect: whether to connect again when the connection is lost.

    Raises:
        WorkbenchError: if an argument is wrong; on entering, if the server cannot be reached or
            refuses.

    Attributes:
        name: what others see of the client.
        control_state: who flies, None until the server said so.
        trouble: why there is no connection at present, "" while there is one.
    """

    def __init__(
        self,
        address: str = "127.0.0.1:7733",
        *,
        name: str = "",
        token: str = "",
        role: Role | str | None = None,
        tls: str | bool | None = None,
        topics: Sequence[str] = ("*",),
        rate: float | None = None,
        reconnect: bool = True,
    ) -> None:
        self._address = parse_address(address)
        self._wishes = make_wishes(name, token, role, topics, rate)
        self._trust = make_trust(tls)
        self._reconnect = reconnect
        self.name = name
        self.control_state: ControlState | None = None
        self.trouble = "the client is not open"
        self.inbox = Inbox()
        self._failure: WorkbenchError | None = None
        self._line: Line | None = None
        self._control: AsyncDirectControl | None = None
        self._pending = Pending(str(self._address))
        self._arrived = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    async def __aenter__(self) -> "AsyncClient":
        line = await open_line(self._address, self._trust, self._wishes)
        self._begin(line)
        self._task = asyncio.create_task(self._run(line), name="link client")
        return self

    async def __aexit__(self, *_: object) -> None:
        try:
            if self._task is not None:
                self._task.cancel()
                await asyncio.wait([self._task])  # which lets a cancellation of ours through
                if not self._task.cancelled():
                    self._task.result()
        finally:
            self._finish(None)

    def __aiter__(self) -> "AsyncClient":
        return self

    async def __anext__(self) -> Sample:
        while (sample := self.inbox.take()) is None:
            self.raise_failure()
            if self._task is None or self._task.done():
                raise StopAsyncIteration
            self._arrived.clear()
            await self._arrived.wait()
        return sample

    @property
    def hello(self) -> Hello:
        """What the server said of itself, its topics, limits and parameters."""
        if self._line is None or self._line.conversation.hello is None:
            raise WorkbenchError("the client is not open: write `with Client(...) as client:`")
        return self._line.conversation.hello

    @property
    def peer(self) -> int:
        """The number by which the server knows this connection."""
        return self.hello.peer

    @property
    def connected(self) -> bool:
        """Whether there is a connection at present."""
        return not self.trouble

    @property
    def received(self) -> int:
        """Samples that have arrived."""
        return self.inbox.arrived

    @property
    def dropped(self) -> int:
        """Samples that this program was too slow for."""
        return self.inbox.dropped

    def latest(self, topic: str) -> Sample | None:
        """Return a topic's newest sample, None before the first."""
        return self.inbox.newest(full_name(topic))

    def control(self) -> AsyncControl:
        """Return the controls: `async with client.control() as c:` asks for them.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server takes no commands.
        """
        return AsyncControl(self)

    def direct_control(self) -> AsyncDirectControl:
        """Return controls that repeat nothing, for who passes on what a person's hand does.

        Raises:
            WorkbenchError: on entering, if somebody else flies or the server takes no commands.
        """
        return AsyncDirectControl(self)

    async def parameters(self, *names: str) -> dict[str, float]:
        """Return live parameters by name; all if none is named.

        Raises:
            WorkbenchError: if one is unknown.
        """
        said = await self.request(lambda id: GetParameters(id, names), ParameterValues)
        return dict(said.values)

    async def ping(self) -> float:
        """Ask whether the server is there, and return its simulated time [s]."""
        return (await self.request(Ping, Pong)).t_ns / 1e9

    # What the controls need.

    @property
    def line(self) -> Line:
        """The connection.

        Raises:
            WorkbenchError: if there is none at present.
        """
        if self._line is None or self.trouble:
            raise WorkbenchError(f"not connected: {self.trouble}")
        return self._line

    async def request(
        self, make: Callable[[int], Operation], wanted: type[T], limit: float = REQUEST_LIMIT
    ) -> T:
        """Ask for something, and return the answer.

        Args:
            make: makes the operation with an id.
            wanted: type of the answer.
            limit: how long to wait [s].

        Raises:
            WorkbenchError: if it is refused, or no answer comes.
        """
        return await self._pending.ask(self.line, make, wanted, limit)

    def attach(self, control: AsyncDirectControl | None) -> None:
        """Tell a holder what the server says of control, from now on."""
        self._control = control

    def raise_failure(self) -> None:
        """Raise what ended the client by itself, if anything did."""
        if self._failure is not None:
            raise self._failure

    # The connection.

    def _begin(self, line: Line) -> None:
        self._line = line
        self.trouble = ""
        self._pass_on(line)

    async def _run(self, line: Line) -> None:
        """Attend to the connection, and make a new one when it ends."""
        try:
            while True:
                try:
                    while line.end is None:
                        await line.read()
                        self._pass_on(line)
                    self._lose(line)
                finally:
                    await line.close()
                line = await self._connect_again()
                self._begin(line)
        except WorkbenchError as error:
            self._finish(error)
        except Exception as error:  # a fault of ours: nobody is to wait for ever
            self._finish(WorkbenchError(f"the client failed: {type(error).__name__}: {error}"))
            raise

    async def _connect_again(self) -> Line:
        pause = FIRST_PAUSE
        while True:
            # Not all clients of a server that was away come back at once.
            await asyncio.sleep(pause * random.uniform(0.5, 1.0))
            try:
                return await open_line(self._address, self._trust, self._wishes)
            except RefusedError as error:
                self.trouble = str(error)
                if not error.retried:
                    raise
            pause = min(2.0 * pause, LONGEST_PAUSE)

    def _pass_on(self, line: Line) -> None:
        """Hand what has arrived to whom it concerns."""
        conversation = line.conversation
        if conversation.samples:
            self.inbox.put(conversation.samples)
            conversation.samples.clear()
            self._arrived.set()
            if self._control is not None:
                self._control.keep_up()
        for said in conversation.said:
            if isinstance(said, ControlState):
                self.control_state = said
            if self._control is not None:
                self._control.hear(said)
            self._pending.hear(said)
        conversation.said.clear()

    def _lose(self, line: Line) -> None:
        """Let everybody know that the connection is gone.

        Raises:
            WorkbenchError: if it is not to be made again.
        """
        assert line.end is not None
        error = RefusedError(line.end.code, f"{self._address}: {line.end.said}")
        self.trouble = str(error)
        self.control_state = None
        if self._control is not None:
            self._control.lose(self.trouble)
        self._pending.fail(self.trouble)
        if not (self._reconnect and error.retried):
            raise error

    def _finish(self, failure: WorkbenchError | None) -> None:
        """End: nobody waits any longer."""
        self._failure = failure
        self.trouble = str(failure) if failure else "the client was closed"
        self.inbox.close()
        self._arrived.set()
        if self._line is not None:  # left open where the client was closed before it ran
            self._line.abort()
