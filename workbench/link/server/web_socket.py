"""A WebSocket as one of the hub's connections: the same frames, in binary messages."""

import asyncio
from collections.abc import Callable
from enum import IntEnum

from workbench.link.codes import ErrorCode
from workbench.link.server.hub import Hub
from workbench.link.server.tcp import TcpConnection
from workbench.link.wire import HEADER, LARGEST, SKIPPABLE, Decoder, Frame, WireError

LARGEST_MESSAGE = HEADER.size + LARGEST
"""Of a client; it may hold several frames, or a part of one."""
LONGEST_CONTROL = 125
"""Bytes of a ping, a pong or a close."""
_NOTHING = Frame(SKIPPABLE, 0, 0, 0, 0, b"")
"""What a message comes to that finishes no frame: it counts as one that is skipped."""


class Opcode(IntEnum):
    """What a message of a WebSocket is (RFC 6455, section 5.2)."""

    CONTINUATION = 0
    TEXT = 1
    BINARY = 2
    CLOSE = 8
    PING = 9
    PONG = 10


_OPCODES = frozenset(int(each) for each in Opcode)


class CloseCode(IntEnum):
    """Why a WebSocket is closed (RFC 6455, section 7.4.1)."""

    NORMAL = 1000
    PROTOCOL_ERROR = 1002
    UNSUPPORTED_DATA = 1003
    MESSAGE_TOO_BIG = 1009


class WebSocketDecoder(Decoder):
    """Takes the bytes of a client's WebSocket, and returns the frames within.

    Each message that finishes no frame is returned as one that is to be skipped, so that it counts
    as a frame does: pings, pongs and empty messages cost as much time.

    Args:
        control: told of a client's ping or close, with its payload, and why it is told.

    Attributes:
        close_code: with which the WebSocket is to be closed.
    """

    def __init__(self, control: Callable[[Opcode, bytes], None]) -> None:
        super().__init__()
        self.close_code = CloseCode.NORMAL
        self._control = control
        self._raw = bytearray()
        self._message = 0
        self._is_in_message = False

    def keep(self, data: bytes) -> None:
        """Take bytes of the WebSocket, and look at them later."""
        self._raw += data

    def next(self) -> Frame | None:
        """Return the next frame, None if none is whole.

        Raises:
            WireError: if what came is no frame of a WebSocket, or none of the link in it.
        """
        frame = super().next()
        if frame is not None:
            return frame
        found = self._next_message()
        if found is None:
            return None
        opcode, payload = found
        if opcode in (Opcode.PING, Opcode.PONG, Opcode.CLOSE):
            self._control(opcode, payload)
            return _NOTHING
        super().keep(payload)
        return super().next() or _NOTHING

    def _next_message(self) -> tuple[Opcode, bytes] | None:
        """Return the next message, or part of one, without its mask; None if none is whole."""
        raw = self._raw
        if len(raw) < 2:
            return None
        final, opcode = raw[0] & 0x80, self._opcode(raw[0])
        if not raw[1] & 0x80:
            raise self._broken("it is not masked: clients mask what they send")
        size, begin = raw[1] & 0x7F, 2
        if opcode >= Opcode.CLOSE and (not final or size > LONGEST_CONTROL):
            raise self._broken(f"a {opcode.name.lower()} has more than {LONGEST_CONTROL} bytes")
        if size > LONGEST_CONTROL:
            begin = 4 if size == LONGEST_CONTROL + 1 else 10
            size = int.from_bytes(raw[2:begin], "big")
        if len(raw) < begin:
            return None
        if opcode < Opcode.CLOSE and self._message + size > LARGEST_MESSAGE:
            self.close_code = CloseCode.MESSAGE_TOO_BIG
            raise WireError("length", f"a message was longer than {LARGEST_MESSAGE} bytes")
        end = begin + 4 + size
        if len(raw) < end:
            return None
        payload = _unmasked(bytes(raw[begin + 4 : end]), bytes(raw[begin : begin + 4]))
        del raw[:end]
        if opcode < Opcode.CLOSE:
            self._is_in_message = not final
            self._message = 0 if final else self._message + size
        return opcode, payload

    def _opcode(self, first: int) -> Opcode:
        """Return what begins with a byte.

        Raises:
            WireError: if it may not stand there.
        """
        number = first & 0x7F  # with the bits that only extensions use
        if number not in _OPCODES:
            raise self._broken(f"it has the opcode {number}")
        opcode = Opcode(number)
        if opcode is Opcode.TEXT:
            self.close_code = CloseCode.UNSUPPORTED_DATA
            raise WireError("kind", "a text came, where frames go in binary messages")
        if opcode < Opcode.CLOSE and (opcode is Opcode.CONTINUATION) is not self._is_in_message:
            raise self._broken("a message begins within another, or goes on without a begin")
        return opcode

    def _broken(self, said: str) -> WireError:
        self.close_code = CloseCode.PROTOCOL_ERROR
        return WireError(ErrorCode.KIND, f"that is no frame of a WebSocket: {said}")


class WebSocketConnection(TcpConnection):
    """One connection; HTTP's protocol hands over what comes, see `aiohttp.web`."""

    def __init__(self, hub: Hub, all_open: set[TcpConnection], address: str) -> None:
        super().__init__(hub, all_open, address, "websocket")
        self._decoder = self._web = WebSocketDecoder(self._answer)

    def feed_data(self, data: bytes) -> tuple[bool, bytes]:
        """Take what has come; say that it was all used."""
        self.data_received(data)
        return False, b""

    def feed_eof(self) -> None:
        """Notice the end of the connection."""
        self.connection_lost(None)

    def write(self, data: bytes) -> None:
        if not self._closing:
            self._transport.write(_message(Opcode.BINARY, data))

    def close(self) -> None:
        if not self._closing:
            code = self._web.close_code.to_bytes(2, "big")
            self._transport.write(_message(Opcode.CLOSE, code))
        super().close()

    def _answer(self, opcode: Opcode, payload: bytes) -> None:
        if opcode is Opcode.PING and not self._closing:
            self._transport.write(_message(Opcode.PONG, payload))
        elif opcode is Opcode.CLOSE:  # after what is being done now
            asyncio.get_running_loop().call_soon(self._end)

    def _end(self) -> None:
        self.close()
        self._transport.close()


def _message(opcode: Opcode, payload: bytes) -> bytes:
    """Return a message of a server."""
    size = len(payload)
    if size <= LONGEST_CONTROL:
        head = bytes((0x80 | opcode, size))
    elif size < 1 << 16:
        head = bytes((0x80 | opcode, 126)) + size.to_bytes(2, "big")
    else:
        head = bytes((0x80 | opcode, 127)) + size.to_bytes(8, "big")
    return head + payload


def _unmasked(payload: bytes, mask: bytes) -> bytes:
    size = len(payload)
    key = int.from_bytes((mask * (size // 4 + 1))[:size], "little")
    return (int.from_bytes(payload, "little") ^ key).to_bytes(size, "little")
