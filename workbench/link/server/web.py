"""The page for phones: its files over HTTP, and the link in a WebSocket with the same frames.

Any web page can make a browser connect to a WebSocket of this machine, so Origin is checked. An
attacker can let a name of his own resolve to this machine, so Host is checked.
"""

import asyncio
import base64
import hashlib
import ipaddress
from collections.abc import Callable, Mapping
from importlib import resources

from aiohttp import HttpVersion11, WSCloseCode, WSMsgType, web

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, is_loopback
from workbench.link.codes import ErrorCode
from workbench.link.page_address import page_address
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.tcp import Acceptor, TcpConnection, listen
from workbench.link.wire import HEADER, LARGEST, SKIPPABLE, Decoder, Frame, WireError

LARGEST_MESSAGE = HEADER.size + LARGEST
"""Size limit of a client's message [bytes]; it may have several frames, or a part of one."""
LONGEST_CONTROL = 125
"""Size limit of a ping, a pong or a close [bytes]."""
_NOTHING = Frame(SKIPPABLE, 0, 0, 0, 0, b"")
"""Stands for a message that completes no frame; it counts as a skipped frame."""
TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
WEB_SOCKET = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
"""Constant hashed with the key of a client in the handshake (RFC 6455, section 1.3)."""
IDLE_TIME = 10.0
"""Time without a complete request after which a connection is closed [s]."""
LONGEST_LINE = 2048
"""Size limit of the first line of a request [bytes]."""
LONGEST_HEADER = 8192
"""Size limit of a header [bytes]; other programs of this machine may have set cookies."""
MOST_HEADERS = 64
STRICT = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
    "Referrer-Policy": "no-referrer",
    "Server": "drake-drone-workbench",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
POLICY = (
    "default-src 'self'; connect-src 'self' {socket}; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; object-src 'none'"
)


_OPCODES = frozenset(int(each) for each in WSMsgType if each < 1 << 7)
"""Those of WebSocket frames (RFC 6455, section 5.2); aiohttp has others for itself."""


class WebSocketDecoder(Decoder):
    """Decodes the bytes of a client's WebSocket into frames of the link.

    A message that completes no frame yields a frame to skip, and so counts as a frame: pings, pongs
    and empty messages take as much time.

    Args:
        control: called with the opcode and payload of a ping, pong or close.

    Attributes:
        close_code: the code to close the WebSocket with.
    """

    def __init__(self, control: Callable[[WSMsgType, bytes], None]) -> None:
        super().__init__()
        self.close_code = WSCloseCode.OK
        self._control = control
        self._raw = bytearray()
        self._message = 0
        self._is_in_message = False

    def keep(self, data: bytes) -> None:
        """Take bytes of the WebSocket, and decode them later."""
        self._raw += data

    def next(self) -> Frame | None:
        """Return the next complete frame, or None.

        Raises:
            WireError: if the bytes are not a WebSocket frame, or not frames of the link in it.
        """
        frame = super().next()
        if frame is not None:
            return frame
        found = self._next_message()
        if found is None:
            return None
        opcode, payload = found
        if opcode in (WSMsgType.PING, WSMsgType.PONG, WSMsgType.CLOSE):
            self._control(opcode, payload)
            return _NOTHING
        super().keep(payload)
        return super().next() or _NOTHING

    def _next_message(self) -> tuple[WSMsgType, bytes] | None:
        """Return the next complete WebSocket frame, unmasked, or None."""
        raw = self._raw
        if len(raw) < 2:
            return None
        final, opcode = raw[0] & 0x80, self._opcode(raw[0])
        if not raw[1] & 0x80:
            raise self._broken("it is not masked: clients mask what they send")
        size, begin = raw[1] & 0x7F, 2
        if opcode >= WSMsgType.CLOSE and (not final or size > LONGEST_CONTROL):
            raise self._broken(f"a {opcode.name.lower()} has more than {LONGEST_CONTROL} bytes")
        if size > LONGEST_CONTROL:
            begin = 4 if size == LONGEST_CONTROL + 1 else 10
            size = int.from_bytes(raw[2:begin], "big")
        if len(raw) < begin:
            return None
        if opcode < WSMsgType.CLOSE and self._message + size > LARGEST_MESSAGE:
            self.close_code = WSCloseCode.MESSAGE_TOO_BIG
            raise WireError("length", f"a message was longer than {LARGEST_MESSAGE} bytes")
        end = begin + 4 + size
        if len(raw) < end:
            return None
        payload = _unmasked(bytes(raw[begin + 4 : end]), bytes(raw[begin : begin + 4]))
        del raw[:end]
        if opcode < WSMsgType.CLOSE:
            self._is_in_message = not final
            self._message = 0 if final else self._message + size
        return opcode, payload

    def _opcode(self, first: int) -> WSMsgType:
        """Return the opcode in the first byte of a frame.

        Raises:
            WireError: if it is not allowed here.
        """
        number = first & 0x7F  # includes the bits reserved for extensions
        if number not in _OPCODES:
            raise self._broken(f"it has the opcode {number}")
        opcode = WSMsgType(number)
        if opcode is WSMsgType.TEXT:
            self.close_code = WSCloseCode.UNSUPPORTED_DATA
            raise WireError("kind", "a text came, where frames go in binary messages")
        goes_on = opcode is WSMsgType.CONTINUATION
        if opcode < WSMsgType.CLOSE and goes_on is not self._is_in_message:
            raise self._broken("a message begins within another, or goes on without a begin")
        return opcode

    def _broken(self, said: str) -> WireError:
        self.close_code = WSCloseCode.PROTOCOL_ERROR
        return WireError(ErrorCode.KIND, f"this is not a frame of a WebSocket: {said}")


class WebSocketConnection(TcpConnection):
    """One connection; the HTTP protocol of `aiohttp.web` passes received bytes on to it."""

    def __init__(self, hub: Hub, all_open: set[TcpConnection], address: str) -> None:
        super().__init__(hub, all_open, address, "websocket")
        self._decoder: Decoder = (web := WebSocketDecoder(self._answer))
        self._web = web

    def feed_data(self, data: bytes) -> tuple[bool, bytes]:
        """Process received bytes; all of them are consumed."""
        self.data_received(data)
        return False, b""

    def feed_eof(self) -> None:
        """Notice the end of the connection."""
        self.connection_lost(None)

    def write(self, data: bytes) -> None:
        if not self._closing:
            self._transport.write(_message(WSMsgType.BINARY, data))

    def close(self) -> None:
        if not self._closing:
            code = self._web.close_code.to_bytes(2, "big")
            self._transport.write(_message(WSMsgType.CLOSE, code))
        super().close()

    def _answer(self, opcode: WSMsgType, payload: bytes) -> None:
        if opcode is WSMsgType.PING and not self._closing:
            self._transport.write(_message(WSMsgType.PONG, payload))
        elif opcode is WSMsgType.CLOSE:  # after the present call
            asyncio.get_running_loop().call_soon(self._end)

    def _end(self) -> None:
        self.close()
        self._transport.close()


def _message(opcode: WSMsgType, payload: bytes) -> bytes:
    """Return a WebSocket frame of the server."""
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


class Page:
    """The server of the page.

    Args:
        hub: handles its clients.
        config: of the server.

    Attributes:
        address: of the page for a browser, "" before it is open.
        port: that it listens at, 0 before.
    """

    def __init__(self, hub: Hub, config: ServerConfig) -> None:
        self.address = ""
        self.port = 0
        self._hub = hub
        self._host = config.host
        self._port = config.web_port
        self._tls = config.tls()
        self._scheme = "https" if self._tls else "http"
        self._files = page_files()
        self._acceptor: Acceptor | None = None
        self._server: web.Server | None = None
        self._open: set[TcpConnection] = set()

    async def open(self) -> None:
        """Listen.

        Raises:
            WorkbenchError: if it cannot listen there.
        """
        try:
            listener = listen(self._host, self._port)
        except WorkbenchError as error:
            where = Address(self._host, self._port)
            raise WorkbenchError(f"the page cannot listen at {where}: {error}") from error
        self._server = server = web.Server(
            self._answer,
            access_log=None,
            keepalive_timeout=IDLE_TIME,
            lingering_time=1.0,
            max_line_size=LONGEST_LINE,
            max_field_size=LONGEST_HEADER,
            max_headers=MOST_HEADERS,
        )
        self._acceptor = Acceptor(listener, lambda _: server(), self._hub.refusals.add, self._tls)
        self.port = self._acceptor.address.port
        self.address = page_address(self._host, self.port, self._scheme).url

    async def close(self) -> None:
        """Stop listening, and end all connections."""
        if self._acceptor is None or self._server is None:
            return
        await self._acceptor.close()
        self._server.pre_shutdown()
        await self._server.shutdown(timeout=2.0)

    async def _answer(self, request: web.BaseRequest) -> web.StreamResponse:
        """Answer a request."""
        host, port, *_ = request.get_extra_info("peername") or ("unknown", 0)
        address = str(Address(host, port))
        local = (request.get_extra_info("sockname") or ("",))[0]
        if request.version < HttpVersion11 or len(request.headers.getall("Host", ())) != 1:
            return plain(400, "A request of HTTP/1.1 with one Host is answered here.")
        if not is_own_host(request.host, local, self._host):
            said = f"{request.host!r} is not where this page is: open it by the machine's address"
            return self._forbid("host", address, said)
        if request.path == "/ws":
            return await self._join(request, address)
        name = request.path.removeprefix("/") or "index.html"
        if request.method not in ("GET", "HEAD"):
            return plain(405, "Only GET is answered here.", {"Allow": "GET, HEAD"})
        if name not in self._files:
            return plain(404, "There is nothing here: the page is at /.")
        socket = f"{self._scheme.replace('http', 'ws')}://{request.host}"
        policy = {"Content-Security-Policy": POLICY.format(socket=socket)}
        return web.Response(
            body=self._files[name],
            content_type=TYPES[_suffix(name)],
            charset="utf-8",
            headers=STRICT | policy,
        )

    async def _join(self, request: web.BaseRequest, address: str) -> web.StreamResponse:
        """Open the WebSocket, if the page is ours."""
        origins = request.headers.getall("Origin", ())
        origin = ", ".join(origins)
        if len(origins) != 1 or not is_own_origin(origin, request.host, self._scheme):
            said = f"{origin or 'no page'!r} is not the page of this server: programs use TCP"
            return self._forbid("origin", address, said)
        if not web.WebSocketResponse().can_prepare(request):
            return plain(400, "A WebSocket is to be opened here.")
        key = request.headers["Sec-WebSocket-Key"].encode() + WEB_SOCKET
        accepted = base64.b64encode(hashlib.sha1(key, usedforsecurity=False).digest()).decode()
        upgrade = {"Upgrade": "websocket", "Connection": "upgrade"}
        answer = web.StreamResponse(
            status=101, headers=upgrade | {"Sec-WebSocket-Accept": accepted}
        )
        answer.force_close()
        await answer.prepare(request)
        if request.transport is None:  # the client is gone
            return answer
        connection = WebSocketConnection(self._hub, self._open, address)
        connection.connection_made(request.transport)
        request.protocol.set_parser(connection)  # pyrefly: ignore[bad-argument-type]
        await connection.ended.wait()
        return answer

    def _forbid(self, code: str, address: str, said: str) -> web.Response:
        self._hub.refusals.add(code, f"{address}: {code}: {said}")
        return plain(403, f"Refused: {said}.")


def page_files() -> Mapping[str, bytes]:
    """Return the files of the page by name; nothing else is served."""
    folder = resources.files("workbench.link") / "page"
    return {
        file.name: file.read_bytes() for file in folder.iterdir() if _suffix(file.name) in TYPES
    }


def _suffix(name: str) -> str:
    return "." + name.rpartition(".")[2]


def plain(status: int, said: str, more: Mapping[str, str] | None = None) -> web.Response:
    """Return an answer with a sentence."""
    return web.Response(status=status, text=said + "\n", headers=STRICT | dict(more or {}))


def is_own_host(asked: str, local: str, named: str) -> bool:
    """Return whether the Host of a request is this server.

    Args:
        asked: the Host of the request, with or without a port.
        local: address of this machine in the connection.
        named: the host that the server listens at.
    """
    host = _host_in(asked).lower()
    if not host:
        return False
    try:
        return _plain(host) == _plain(local)
    except ValueError:
        return host == named.lower() or (host == "localhost" and is_loopback(local))


def is_own_origin(origin: str, asked: str, scheme: str) -> bool:
    """Return whether a WebSocket is opened by the page of this server.

    Args:
        origin: of the request; a browser always states it correctly.
        asked: the Host of the request.
        scheme: http or https, of the connection.
    """
    return origin.lower() == f"{scheme}://{asked.lower()}"


def _host_in(asked: str) -> str:
    """Return the name or address in a Host without port and brackets; "" if it is invalid."""
    if asked.startswith("["):
        name, bracket, rest = asked[1:].partition("]")
        understood = bool(bracket) and (not rest or rest.startswith(":"))
        port = rest[1:]
    else:
        name, colon, port = asked.partition(":")
        understood = not colon or bool(port)
    if not understood or (port and not (port.isascii() and port.isdigit())):
        return ""
    return name


def _plain(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Return an address; an IPv4 address mapped to IPv6 as IPv4.

    Raises:
        ValueError: if the text is a name.
    """
    address = ipaddress.ip_address(text.partition("%")[0])
    return getattr(address, "ipv4_mapped", None) or address
