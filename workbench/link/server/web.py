"""The page for phones: its files over HTTP, and the link in a WebSocket with the same frames.

Any web page can make a browser connect to a WebSocket of this machine, so Origin is checked. An
attacker can let a name of his own resolve to this machine, so Host is checked.
"""

import asyncio
import ipaddress
from collections.abc import Mapping
from contextlib import suppress
from importlib import resources

from aiohttp import HttpVersion11, WSCloseCode, WSMessage, WSMsgType, web

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, is_loopback
from workbench.link.codes import ErrorCode
from workbench.link.page_address import page_address
from workbench.link.server.client_session import ClientSession
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.tcp import LINGER, Acceptor, listen
from workbench.link.wire import HEADER, LARGEST, Decoder

LARGEST_MESSAGE = HEADER.size + LARGEST
"""Size limit of a client's message [bytes]; it may have several frames, or a part of one."""
TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
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


class WebSocketConnection:
    """One connection: a transport for the hub, whose frames aiohttp carries in messages."""

    def __init__(self, hub: Hub, request: web.BaseRequest, socket: web.WebSocketResponse) -> None:
        assert request.transport is not None
        self._hub = hub
        self._socket = socket
        self._transport = request.transport
        self._unsent: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._waiting = 0
        self._closing = False
        self._code = WSCloseCode.OK

    @property
    def unsent(self) -> int:
        return self._waiting + self._transport.get_write_buffer_size()

    def write(self, data: bytes) -> None:
        if not self._closing:
            self._waiting += len(data)
            self._unsent.put_nowait(data)

    def close(self) -> None:
        if not self._closing:
            self._closing = True
            self._unsent.put_nowait(None)
            asyncio.get_running_loop().call_later(LINGER, self.abort)

    def abort(self) -> None:
        self._closing = True
        self._transport.abort()

    async def run(self, address: str) -> None:
        """Pass on what is received and sent, until the connection ends."""
        decoder = Decoder()
        session = self._hub.open(self, address, "websocket", decoder)
        sending = asyncio.create_task(self._send())
        try:
            with suppress(ConnectionError):  # a pong to a client that is gone
                async for message in self._socket:
                    if message.type is WSMsgType.ERROR:  # aiohttp has ended the connection
                        self._hub.refusals.add(_fault(message.data), f"{address}: {message.data}")
                    elif session is not None and not self._closing:
                        await self._take(message, session, decoder)
        finally:
            if session is not None:
                self._hub.lost(session)
            sending.cancel()

    async def _take(self, message: WSMessage, session: ClientSession, decoder: Decoder) -> None:
        """Take a message, and read no further while its client is ahead of what it may send.

        A message that completes no frame counts as one: pings, pongs and empty ones take as much
        time.
        """
        if message.type is WSMsgType.BINARY:
            decoder.keep(message.data)
        elif message.type is WSMsgType.PING:
            await self._socket.pong(message.data)
        elif message.type is WSMsgType.TEXT:
            self._code = WSCloseCode.UNSUPPORTED_DATA
            session.end(ErrorCode.KIND, "a text came, where frames go in binary messages")
        pause = self._hub.receive(session, len(message.data))
        while pause > 0.0 and not self._closing:
            await asyncio.sleep(pause)
            pause = self._hub.receive(session)

    async def _send(self) -> None:
        with suppress(ConnectionError):  # the client is gone, which `run` notices
            while (data := await self._unsent.get()) is not None:
                self._waiting -= len(data)
                await self._socket.send_bytes(data)
            await self._socket.close(code=self._code)


def _fault(error: Exception) -> ErrorCode:
    too_long = getattr(error, "code", None) == WSCloseCode.MESSAGE_TOO_BIG
    return ErrorCode.LENGTH if too_long else ErrorCode.KIND


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
        socket = web.WebSocketResponse(
            autoping=False, compress=False, max_msg_size=LARGEST_MESSAGE + 1, timeout=LINGER
        )
        if not socket.can_prepare(request):
            return plain(400, "A WebSocket is to be opened here.")
        await socket.prepare(request)
        if request.transport is not None:  # the client is still there
            await WebSocketConnection(self._hub, request, socket).run(address)
        return socket

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
