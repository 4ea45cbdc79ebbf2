"""A WebSocket as one of the hub's connections: the same frames, in binary messages."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable

from aiohttp import WSCloseCode, WSMsgType, web

from workbench.link.codes import ErrorCode
from workbench.link.wire import HEADER, LARGEST

CLOSING_TIME = 1.0
"""For what was written before a connection ends [s]."""
LARGEST_MESSAGE = HEADER.size + LARGEST
"""Of a client; it may hold several frames, or a part of one."""


class WebSocketTransport:
    """Where the hub's answers go; see `Transport`.

    Args:
        socket: that is open.
        under: the connection that carries it.
    """

    def __init__(self, socket: web.WebSocketResponse, under: asyncio.Transport) -> None:
        self._socket = socket
        self._under = under
        self._queue: list[bytes] = []
        self._queued = 0
        self._due = asyncio.Event()
        self._ending: asyncio.TimerHandle | None = None

    @property
    def unsent(self) -> int:
        """Bytes that were written here and not yet taken by the system, about."""
        return self._queued + self._under.get_write_buffer_size()

    def write(self, data: bytes) -> None:
        """Send whole frames."""
        if self._ending is None:
            self._queue.append(data)
            self._queued += len(data)
            self._due.set()

    def close(self) -> None:
        """End the connection when all is out, or after a second."""
        if self._ending is None:
            self._ending = asyncio.get_running_loop().call_later(CLOSING_TIME, self._under.abort)
            self._due.set()

    def abort(self) -> None:
        """End it at once."""
        self.close()
        self._under.abort()

    async def send(self) -> None:
        """Send what is written, until the connection ends."""
        with contextlib.suppress(OSError):
            while self._queue or self._ending is None:
                await self._due.wait()
                self._due.clear()
                if self._queue:
                    data = b"".join(self._queue)
                    self._queue.clear()
                    self._queued = 0  # from here on it counts as what `under` holds
                    await self._socket.send_bytes(data)
            await self._socket.close()

    def done(self) -> None:
        """Forget the timer of a connection that has ended."""
        if self._ending is not None:
            self._ending.cancel()


async def messages(
    socket: web.WebSocketResponse, address: str, refuse: Callable[[str, str], None]
) -> AsyncIterator[bytes]:
    """Yield what a client sends, until the connection ends; nothing for a ping or a pong.

    Args:
        socket: that is open.
        address: host and port of the client.
        refuse: counts what is refused: a code and a sentence.
    """
    async for message in socket:
        if message.type is WSMsgType.BINARY:
            yield message.data
            continue
        if message.type in (WSMsgType.PING, WSMsgType.PONG):
            if message.type is WSMsgType.PING:
                await socket.pong(message.data)
            yield b""
            continue
        if message.type is WSMsgType.TEXT:
            refuse(ErrorCode.KIND, f"{address}: a text came, where frames go in binary messages")
            await socket.close(code=WSCloseCode.UNSUPPORTED_DATA)
        elif getattr(message.data, "code", None) == WSCloseCode.MESSAGE_TOO_BIG:
            said = f"{address}: a message was longer than {LARGEST_MESSAGE} bytes"
            refuse(ErrorCode.LENGTH, said)
        return
