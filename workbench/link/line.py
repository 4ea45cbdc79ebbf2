"""A client's connection in use: a conversation over streams."""

import asyncio
import contextlib
import time

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address
from workbench.link.client_tls import Trust
from workbench.link.connecting import LIMIT, connect
from workbench.link.conversation import Conversation, End
from workbench.link.operations import Bye, Operation, Ping
from workbench.link.wishes import Wishes

CHUNK = 256 * 1024
QUIET = 2.0
"""After so long a silence a client asks whether the server is there [s]; after another, it goes."""
FRESH = 0.2
"""After so long without a state a client at the controls asks for the time [s]."""
MOST_UNSENT = 64 * 1024
"""Bytes that may wait to be sent; a command beyond is late already, and is not sent."""

RETRIED = {"lost", "bye", "slow", "overflow", "too_many", "back_off", "internal"}
"""Ends after which it is worth to connect again; the others would end likewise."""


class Line:
    """A conversation with the server.

    Attributes:
        conversation: what was said.
    """

    def __init__(
        self, wishes: Wishes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self.conversation = Conversation(wishes)
        self._reader = reader
        self._writer = writer
        self._end: End | None = None
        self._pinged = False
        self._told = -FRESH

    @property
    def fresh(self) -> bool:
        """Whether the simulated time that is known is the present one."""
        return time.monotonic() - self._told < FRESH

    @property
    def end(self) -> End | None:
        """Why it is over, None while it is not."""
        return self.conversation.end or self._end

    async def read(self) -> None:
        """Take in what comes next, or find that nothing comes any more."""
        try:
            async with asyncio.timeout(QUIET):
                data = await self._reader.read(CHUNK)
        except TimeoutError:
            self._wonder()
            return
        except OSError as error:
            self._end = End("lost", f"the connection broke: {error.strerror or error}")
            return
        self._pinged = False
        if data:
            known = self.conversation.newest_ns
            self.conversation.receive(data)
            if self.conversation.newest_ns != known:
                self._told = time.monotonic()
            self._flush()
        else:
            self._end = End("lost", "the server closed the connection")

    def ask(self, operation: Operation) -> None:
        """Send an operation."""
        self.conversation.ask(operation)
        self._flush()

    def command(self, payload: bytes) -> None:
        """Send a command, unless those before it have not left yet."""
        if self._writer.transport.get_write_buffer_size() < MOST_UNSENT:
            self.conversation.command(payload)
            self._flush()

    async def close(self) -> None:
        """Say goodbye, if somebody is there to hear it, and end."""
        if self.end is None:
            self.ask(Bye())
            self._end = End("closed", "the client was closed")
            self._writer.close()
        else:
            self.abort()
        # Whether the other side took leave properly does not matter any more.
        with contextlib.suppress(OSError, TimeoutError):
            async with asyncio.timeout(1.0):
                await self._writer.wait_closed()
        self.abort()

    def abort(self) -> None:
        """End at once, without a word."""
        self._writer.transport.abort()

    def _wonder(self) -> None:
        if self._pinged:
            self._end = End("lost", f"the server was silent for {2.0 * QUIET:g} s")
            return
        self._pinged = True
        self.ask(Ping())

    def _flush(self) -> None:
        data = self.conversation.take_outgoing()
        if data and not self._writer.is_closing():
            self._writer.write(data)


async def open_line(address: Address, trust: Trust, wishes: Wishes) -> Line:
    """Return a conversation that is past its greeting.

    Raises:
        RefusedError: if there is no connection, or the server refuses.
    """
    try:
        line = Line(wishes, *await connect(address, trust))
    except WorkbenchError as error:
        raise RefusedError("lost", str(error)) from None
    try:
        async with asyncio.timeout(LIMIT):
            while not line.conversation.ready and line.end is None:
                await line.read()
    except TimeoutError:
        await line.close()
        raise RefusedError(
            "lost",
            f"{address} sends no greeting within {LIMIT:g} s: is it a server of drones, and does "
            "it want TLS?",
        ) from None
    except BaseException:
        await line.close()
        raise
    if line.end is not None:
        await line.close()
        raise RefusedError(line.end.code, f"{address}: {line.end.said}{_hint(line.end, wishes)}")
    return line


class RefusedError(WorkbenchError):
    """A connection that did not come to be.

    Attributes:
        retried: whether it may later.
    """

    def __init__(self, code: str, said: str) -> None:
        super().__init__(said)
        self.retried = code in RETRIED


def _hint(end: End, wishes: Wishes) -> str:
    """Return what to do about an end, where the server cannot know it."""
    if end.code == "bad_login":
        return f"; is the token that of the role '{wishes.role.value}'?"
    return ""
