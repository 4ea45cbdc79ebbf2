"""The bytes of a WebSocket, decoded one frame at a time, see RFC 6455."""

from collections.abc import Callable

from websockets.exceptions import PayloadTooBig
from websockets.frames import CloseCode, Opcode
from websockets.frames import Frame as Piece
from websockets.protocol import State
from websockets.server import ServerProtocol

from workbench.link.codes import ErrorCode
from workbench.link.wire import SKIPPABLE_BIT, Decoder, WireError, WireFrame

PARTIAL_FRAME = WireFrame(SKIPPABLE_BIT, 0, 0, 0, 0, b"")
"""Stands for a frame of a WebSocket that completes no frame of the protocol: it has taken as much
time as one that may be skipped."""
MASK_BYTES = 4
"""Size of the mask that every frame of a client has [bytes]."""


class WebSocket(Decoder):
    """The server's side of a WebSocket: decodes received bytes, and encodes messages.

    Each call of `next` decodes one frame of the WebSocket at most. So whoever calls it decides when
    the next one is decoded, and can count those that carry nothing.

    Args:
        protocol: after its handshake.
        send: sends bytes.
        ended: called when the client has ended the WebSocket.
    """

    def __init__(
        self, protocol: ServerProtocol, send: Callable[[bytes], None], ended: Callable[[], None]
    ) -> None:
        super().__init__()
        self._protocol = protocol
        self._send = send
        self._ended = ended
        self.received = bytearray()
        self._left = 0  # bytes that the present frame of the WebSocket still lacks
        self._code = CloseCode.NORMAL_CLOSURE

    def next(self) -> WireFrame | None:
        """Return the next frame, `PARTIAL_FRAME` for a piece that completes none, or None.

        Raises:
            WireError: if the bytes are not a frame, or break the standard.
        """
        if (frame := super().next()) is not None:
            return frame
        return (super().next() or PARTIAL_FRAME) if self._take_piece() else None

    def say(self, data: bytes) -> None:
        """Send frames in a message, unless the WebSocket has ended."""
        if self._protocol.state is State.OPEN:
            self._protocol.send_binary(data)
            self._flush()

    def close(self) -> None:
        """End the WebSocket from this side; its connection must follow."""
        if self._protocol.state is State.OPEN:
            self._protocol.send_close(self._code)
            self._flush()

    def _take_piece(self) -> bool:
        """Decode received bytes up to the end of a frame of the WebSocket; return whether it came.

        Raises:
            WireError: if it breaks the standard, or is a text.
        """
        if not self.received:
            return False
        self._left = self._left or websocket_frame_size(self.received)
        taken = bytes(self.received[: self._left])
        del self.received[: self._left]
        self._left -= len(taken)
        self._protocol.receive_data(taken)
        self._flush()
        for piece in self._protocol.events_received():
            assert isinstance(piece, Piece)
            if piece.opcode is Opcode.TEXT:
                self._code = CloseCode.UNSUPPORTED_DATA
                raise WireError(ErrorCode.KIND, "a text came, where frames go in binary messages")
            if piece.opcode in (Opcode.BINARY, Opcode.CONT):
                self._undecoded += piece.data
        if (error := self._protocol.parser_exc) is not None:
            code = ErrorCode.LENGTH if isinstance(error, PayloadTooBig) else ErrorCode.KIND
            raise WireError(code, f"the WebSocket is not as RFC 6455 says: {error}")
        if self._protocol.state is not State.OPEN:
            self._ended()
        return bool(taken) and not self._left

    def _flush(self) -> None:
        if data := b"".join(self._protocol.data_to_send()):
            self._send(data)


def websocket_frame_size(received: bytes | bytearray) -> int:
    """Return the size of a client's frame of a WebSocket that begins here; 0 while unknown."""
    if len(received) < 2:
        return 0
    length = received[1] & 0x7F
    end = {126: 4, 127: 10}.get(length, 2)
    if len(received) < end:
        return 0
    if end > 2:
        length = int.from_bytes(received[2:end], "big")
    return end + MASK_BYTES + length
