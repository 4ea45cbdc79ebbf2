"""The common part of both clients: a persistent connection, samples, and requests."""

import asyncio
import random
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from workbench.common.errors import WorkbenchError
from workbench.link.address import parse_address
from workbench.link.client_protocol import full_name, make_options
from workbench.link.connection import Connection, RefusedError, make_trust, open_connection
from workbench.link.hello import Hello
from workbench.link.message_json import Operation, ServerMessage
from workbench.link.messages import (
    ControlState,
    DescribeVehicle,
    GetParameters,
    Nack,
    ParameterValues,
    Ping,
    Pong,
    Role,
)
from workbench.link.sample import Sample, SampleQueue

FIRST_RECONNECT_PAUSE_S = 0.1
MAX_RECONNECT_PAUSE_S = 5.0
"""Longest pause between attempts to reconnect; each is twice the one before [s]."""
REQUEST_TIMEOUT_S = 5.0
"""Time limit for an answer [s]."""

T = TypeVar("T")


class ControlListener(Protocol):
    """A receiver of messages about control."""

    def receive(self, message: ServerMessage) -> None:
        """Handle a message."""

    def lose(self, reason: str) -> None:
        """Handle the loss of the connection."""

    def keep_up(self) -> None:
        """Handle the arrival of a newer state."""


class ClientCore:
    """A client of the server of a drone; `Client` and `AsyncClient` are two interfaces to it.

    The client restores a lost connection and its subscriptions, with growing pauses. It never takes
    control again automatically. A program that reads too slowly gets the newest samples of each
    topic.

    Args:
        address: of the server, HOST:PORT.
        name: shown to others, at most 48 bytes.
        token: of the role, from the token file of the server; empty if the server needs none.
        role: that of the token, view or command (the default).
        tls: True to trust the certificate authorities of the system, the path of a file of
            certificates, or `sha256:` and the fingerprint of the server certificate; None for no
            TLS.
        topics: names, such as `velocity_data`, or "*" for all.
        rate: largest number of samples per second for each topic [1/s]; None for all.
        reconnect: whether to restore a lost connection.

    Raises:
        WorkbenchError: if an argument is invalid; on entering, if the server cannot be reached or
            rejects the client.

    Attributes:
        name: shown to others.
        control_state: who flies, None until known.
        trouble: why there is no connection at present, else "".
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
        self._options = make_options(name, token, role, topics, rate)
        self._trust = make_trust(tls)
        self._reconnect = reconnect
        self.name = name
        self.control_state: ControlState | None = None
        self.trouble = "the client is not open"
        self._samples = SampleQueue()
        self._failure: WorkbenchError | None = None
        self._connection: Connection | None = None
        self._follower: ControlListener | None = None
        self._answers: dict[int, asyncio.Future[ServerMessage]] = {}
        self._arrived = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    @property
    def hello(self) -> Hello:
        """The server's description of itself, its topics, limits and parameters."""
        if self._connection is None or self._connection.protocol.hello is None:
            raise WorkbenchError("the client is not open: write `with Client(...) as client:`")
        return self._connection.protocol.hello

    @property
    def peer(self) -> int:
        """The number of this connection at the server."""
        return self.hello.peer

    @property
    def connected(self) -> bool:
        """Whether there is a connection at present."""
        return not self.trouble

    @property
    def received(self) -> int:
        """Number of samples received."""
        return self._samples.arrived

    @property
    def dropped(self) -> int:
        """Number of samples dropped as this program was too slow."""
        return self._samples.dropped

    def latest(self, topic: str) -> Sample | None:
        """Return the newest sample of a topic, None before the first."""
        return self._samples.newest(full_name(topic))

    def raise_failure(self) -> None:
        """Raise the error that ended the client, if any; iteration does the same."""
        if self._failure is not None:
            raise self._failure

    # Needed by the controls.

    @property
    def connection(self) -> Connection:
        """The connection.

        Raises:
            WorkbenchError: if there is none at present.
        """
        if self._connection is None or self.trouble:
            raise WorkbenchError(f"not connected: {self.trouble}")
        return self._connection

    async def request(
        self, make: Callable[[int], Operation], wanted: type[T], limit: float = REQUEST_TIMEOUT_S
    ) -> T:
        """Send a request, and return the answer.

        Args:
            make: creates the operation with an id.
            wanted: type of the answer.
            limit: time limit [s].

        Raises:
            WorkbenchError: if it is refused, or there is no answer.
        """
        connection = self.connection
        number = connection.protocol.new_id()
        future: asyncio.Future[ServerMessage] = asyncio.get_running_loop().create_future()
        self._answers[number] = future
        try:
            connection.send(make(number))
            async with asyncio.timeout(limit):
                answer = await future
        except TimeoutError:
            raise WorkbenchError(
                f"{self._address} gave no answer within {limit:g} s: the flight may be busy"
            ) from None
        finally:
            del self._answers[number]
        if isinstance(answer, Nack):
            raise WorkbenchError(f"refused: {answer.said}")
        if not isinstance(answer, wanted):
            raise WorkbenchError(f"{self._address} answered with something else: {answer}")
        return answer

    async def request_parameters(self, *names: str) -> dict[str, float]:
        """Return live parameters by name; all if none is named.

        Raises:
            WorkbenchError: if one is unknown.
        """
        answer = await self.request(lambda id: GetParameters(id, names), ParameterValues)
        return dict(answer.values)

    async def request_description(self) -> str:
        """Return the description of the vehicle as URDF.

        Raises:
            WorkbenchError: if the server is older and does not know it, or it is too long.
        """
        return (await self.request(DescribeVehicle, DescribeVehicle)).urdf

    async def request_time(self) -> float:
        """Ask whether the server is there, and return its simulated time [s]."""
        return (await self.request(Ping, Pong)).t_ns / 1e9

    def follow(self, follower: ControlListener | None) -> None:
        """Pass messages about control to a follower from now on."""
        self._follower = follower

    # The connection.

    async def open(self) -> None:
        """Connect, and maintain the connection.

        Raises:
            WorkbenchError: if the server cannot be reached, or rejects the client.
        """
        connection = await open_connection(self._address, self._trust, self._options)
        self._begin(connection)
        self._task = asyncio.create_task(self._run(connection), name="link client")

    async def close(self) -> None:
        """End the connection."""
        try:
            if self._task is not None:
                self._task.cancel()
                await asyncio.wait([self._task])  # which allows our own cancellation
                if not self._task.cancelled():
                    self._task.result()
        finally:
            self._finish(None)

    def _begin(self, connection: Connection) -> None:
        self._connection = connection
        self.trouble = ""
        self._deliver(connection)

    async def _run(self, connection: Connection) -> None:
        """Run the connection, and make a new one when it ends."""
        try:
            while True:
                try:
                    while connection.end is None:
                        await connection.read()
                        self._deliver(connection)
                    self._lose(connection)
                finally:
                    await connection.close()
                connection = await self._connect_again()
                self._begin(connection)
        except WorkbenchError as error:
            self._finish(error)
        except Exception as error:  # a bug of ours: nobody must wait forever
            self._finish(WorkbenchError(f"the client failed: {type(error).__name__}: {error}"))
            raise

    async def _connect_again(self) -> Connection:
        pause = FIRST_RECONNECT_PAUSE_S
        while True:
            # Random pauses, so that not all clients reconnect at once.
            await asyncio.sleep(pause * random.uniform(0.5, 1.0))
            try:
                return await open_connection(self._address, self._trust, self._options)
            except RefusedError as error:
                self.trouble = str(error)
                if not error.retried:
                    raise
            pause = min(2.0 * pause, MAX_RECONNECT_PAUSE_S)

    def _deliver(self, connection: Connection) -> None:
        """Pass on what has arrived."""
        protocol = connection.protocol
        if protocol.samples:
            self._samples.put(protocol.samples)
            protocol.samples.clear()
            self._arrived.set()
            if self._follower is not None:
                self._follower.keep_up()
        for message in protocol.messages:
            if isinstance(message, ControlState):
                self.control_state = message
            if self._follower is not None:
                self._follower.receive(message)
            answer = self._answers.get(getattr(message, "id", None) or 0)
            if answer is not None and not answer.done():
                answer.set_result(message)
        protocol.messages.clear()

    def _lose(self, connection: Connection) -> None:
        """Report the loss of the connection to all waiting callers.

        Raises:
            WorkbenchError: if it must not be restored.
        """
        assert connection.end is not None
        error = RefusedError(connection.end.code, f"{self._address}: {connection.end.said}")
        self.trouble = str(error)
        self.control_state = None
        if self._follower is not None:
            self._follower.lose(self.trouble)
        for answer in self._answers.values():
            if not answer.done():
                answer.set_exception(WorkbenchError(self.trouble))
        if not (self._reconnect and error.retried):
            raise error

    def _finish(self, failure: WorkbenchError | None) -> None:
        """End, and release all waiting callers."""
        self._failure = failure
        self.trouble = str(failure) if failure else "the client was closed"
        self._samples.close()
        self._arrived.set()
        if self._connection is not None:  # still open if the client was closed before it ran
            self._connection.abort()
