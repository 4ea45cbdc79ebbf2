"""The page for phones: its files over HTTP, and the link in a WebSocket with the same frames.

Any web page can make a browser connect to a WebSocket of this machine, so Origin is checked. An
attacker can let a name of his own resolve to this machine, so Host is checked.
"""

import asyncio
import ipaddress
import ssl
from collections.abc import Mapping
from email.utils import formatdate
from http import HTTPStatus
from importlib import resources

from websockets.datastructures import Headers
from websockets.http11 import Request, Response
from websockets.server import ServerProtocol

from workbench.common.errors import WorkbenchError
from workbench.link.address import Address, is_loopback
from workbench.link.page_address import page_address
from workbench.link.server.acceptor import Acceptor, listen
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.tcp import TcpConnection
from workbench.link.server.web_socket import WebSocket
from workbench.link.wire import FRAME_HEADER, MAX_PAYLOAD_BYTES

MAX_WEB_MESSAGE_BYTES = FRAME_HEADER.size + MAX_PAYLOAD_BYTES
"""Size limit of a client's message [bytes]; it may have several frames, or a part of one."""
MEDIA_TYPE_BY_SUFFIX = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
WEB_IDLE_TIMEOUT_S = 10.0
"""Time without a complete request, or with an answer that is not read, after which a connection is
closed [s]."""
MAX_WEB_REQUEST_BYTES = 16 * 1024
"""Size limit of a request [bytes]; other programs of this machine may have set cookies."""
MAX_URL_PATH_CHARS = 2048
MAX_REQUEST_HEADERS = 64
MAX_REQUEST_READS = 64
"""Largest number of reads until a request is complete, as tiny pieces cost time, too."""
ANSWER_COST_BYTES = 1024
"""Cost of an answer, see `Hub.later`."""
HEADERS_END = b"\r\n\r\n"
STRICT_HEADERS = {
    "Cache-Control": "no-store",
    "Connection": "close",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
    "Referrer-Policy": "no-referrer",
    "Server": "drake-drone-workbench",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
CONTENT_POLICY = (
    "default-src 'self'; connect-src 'self' {socket}; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; object-src 'none'"
)


class WebConnection(TcpConnection):
    """A connection to the page: one request, then its answer or a WebSocket.

    After an answer the connection ends. So it takes no further requests, each of which would take
    time from the clients that fly.

    Args:
        hub: handles the client.
        page: answers the request.
        address: of the client, "HOST:PORT".
    """

    def __init__(self, hub: Hub, page: "Page", address: str) -> None:
        super().__init__(hub, address, "websocket")
        self._page = page
        self._request = b""
        self._reads = 0
        self._socket: WebSocket | None = None

    def _begin(self) -> None:
        self._set_timer(asyncio.get_running_loop().call_later(WEB_IDLE_TIMEOUT_S, self.abort))

    def data_received(self, data: bytes) -> None:
        if self._socket is not None or self._closing:
            super().data_received(data)
            return
        assert self._transport
        self._reads += 1
        self._request += data
        if HEADERS_END in self._request[: MAX_WEB_REQUEST_BYTES + len(HEADERS_END)]:
            self._transport.pause_reading()
            self._set_timer(None)
            self._hub.later(self._answer)
        elif len(self._request) > MAX_WEB_REQUEST_BYTES or self._reads > MAX_REQUEST_READS:
            self._end_with(
                text_response(431, f"A request has {MAX_WEB_REQUEST_BYTES} bytes at most here.")
            )

    def write(self, data: bytes) -> None:
        if self._socket is not None:
            self._socket.say(data)

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        super().close()

    def _answer(self) -> int:
        """Answer the request, and return the cost of it."""
        own = self._transport.get_extra_info("sockname") if self._transport else None
        if self._closing or not self._transport or not own:
            return 0
        end = self._request.index(HEADERS_END) + len(HEADERS_END)
        head, rest = self._request[:end], self._request[end:]
        protocol = ServerProtocol(max_size=MAX_WEB_MESSAGE_BYTES)
        protocol.receive_data(head)
        answer = self._page.answer(protocol, self._address, own[0])
        if answer.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            self._end_with(answer)
            return ANSWER_COST_BYTES
        super().write(answer.serialize())
        self._socket = WebSocket(protocol, super().write, super().close)
        self._decoder = self._socket
        self._greet()
        self._transport.resume_reading()
        if rest:
            self.data_received(rest)
        return ANSWER_COST_BYTES

    def _end_with(self, answer: Response) -> None:
        super().write(answer.serialize())
        self._close(WEB_IDLE_TIMEOUT_S)


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
        self._tls: ssl.SSLContext | None = config.tls()
        self._scheme = "https" if self._tls else "http"
        self._files = page_files()
        self._acceptor: Acceptor | None = None

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
        hub = self._hub
        self._acceptor = Acceptor(
            listener,
            lambda address: WebConnection(hub, self, address),
            hub.refusals.add,
            self._tls,
            hub.later,
        )
        self.port = self._acceptor.address.port
        self.address = page_address(self._host, self.port, self._scheme)

    async def close(self) -> None:
        """Stop listening, and end all connections."""
        if self._acceptor is not None:
            await self._acceptor.close()

    def answer(self, protocol: ServerProtocol, address: str, local: str) -> Response:
        """Return the answer to a request; that of a WebSocket also opens the protocol.

        Args:
            protocol: has received the request.
            address: of the client, "HOST:PORT".
            local: address of this machine in the connection.
        """
        request = next(iter(protocol.events_received()), None)
        if not isinstance(request, Request) or request.protocol != "HTTP/1.1":
            return text_response(400, "A request of HTTP/1.1 without a body is answered here.")
        hosts = request.headers.get_all("Host")
        if (
            len(hosts) != 1
            or len(request.path) > MAX_URL_PATH_CHARS
            or len(request.headers) > MAX_REQUEST_HEADERS
        ):
            return text_response(400, "A request with one Host is answered here.")
        [host] = hosts
        if not is_own_host(host, local, self._host):
            said = f"{host!r} is not where this page is: open it by the machine's address"
            return self._forbid("host", address, said)
        path = request.path.partition("?")[0]
        if path == "/ws":
            return self._join(protocol, request, host, address)
        if request.method not in ("GET", "HEAD"):
            return text_response(405, "Only GET is answered here.", {"Allow": "GET, HEAD"})
        name = path.removeprefix("/") or "index.html"
        if name not in self._files:
            return text_response(404, "There is nothing here: the page is at /.")
        socket = f"{self._scheme.replace('http', 'ws')}://{host}"
        policy = {"Content-Security-Policy": CONTENT_POLICY.format(socket=socket)}
        file = web_response(200, self._files[name], MEDIA_TYPE_BY_SUFFIX[_suffix(name)], policy)
        if request.method == "HEAD":
            file.body = b""
        return file

    def _join(
        self, protocol: ServerProtocol, request: Request, host: str, address: str
    ) -> Response:
        """Open the WebSocket, if the page is ours."""
        origins = request.headers.get_all("Origin")
        origin = ", ".join(origins)
        if len(origins) != 1 or not is_own_origin(origin, host, self._scheme):
            said = f"{origin or 'no page'!r} is not the page of this server: programs use TCP"
            return self._forbid("origin", address, said)
        accepted = protocol.accept(request)
        if accepted.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            version = {"Sec-WebSocket-Version": "13"}
            return text_response(400, "A WebSocket of version 13 is to be opened here.", version)
        protocol.send_response(accepted)
        protocol.data_to_send()  # the answer, which the caller sends
        return accepted

    def _forbid(self, code: str, address: str, said: str) -> Response:
        self._hub.refusals.add(code, f"{address}: {code}: {said}")
        return text_response(403, f"Refused: {said}.")


def page_files() -> Mapping[str, bytes]:
    """Return the files of the page by name; nothing else is served."""
    folder = resources.files("workbench.link") / "page"
    return {
        file.name: file.read_bytes()
        for file in folder.iterdir()
        if _suffix(file.name) in MEDIA_TYPE_BY_SUFFIX
    }


def _suffix(name: str) -> str:
    return "." + name.rpartition(".")[2]


def text_response(status: int, said: str, more: Mapping[str, str] | None = None) -> Response:
    """Return an answer with a sentence."""
    return web_response(status, f"{said}\n".encode(), "text/plain", more or {})


def web_response(status: int, body: bytes, kind: str, more: Mapping[str, str]) -> Response:
    """Return an answer.

    Args:
        status: number of HTTP.
        body: content.
        kind: type of the content, a text in UTF-8.
        more: headers.
    """
    headers = {
        "Content-Length": str(len(body)),
        "Content-Type": f"{kind}; charset=utf-8",
        "Date": formatdate(usegmt=True),
    }
    return Response(
        status, HTTPStatus(status).phrase, Headers(STRICT_HEADERS | headers | dict(more)), body
    )


def is_own_host(asked: str, local: str, named: str) -> bool:
    """Return whether the Host of a request is this server.

    Args:
        asked: the Host of the request, with or without a port.
        local: address of this machine in the connection.
        named: the host that the server listens at.
    """
    host, is_ipv6 = _host_in(asked.lower())
    if not host or "%" in host:  # a zone has a meaning on its own machine only
        return False
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        is_named = host == named.lower() or (host == "localhost" and is_loopback(local))
        return is_named and not is_ipv6
    own = ipaddress.ip_address(local.partition("%")[0])
    return is_ipv6 is (address.version == 6) and _as_ipv4(address) == _as_ipv4(own)


def is_own_origin(origin: str, asked: str, scheme: str) -> bool:
    """Return whether a WebSocket is opened by the page of this server.

    Args:
        origin: of the request; a browser always states it correctly.
        asked: the Host of the request.
        scheme: http or https, of the connection.
    """
    return origin.lower() == f"{scheme}://{asked.lower()}"


def _host_in(asked: str) -> tuple[str, bool]:
    """Return the name or address in a Host, "" if it is invalid, and whether it has brackets."""
    is_ipv6 = asked.startswith("[")
    if is_ipv6:
        name, bracket, rest = asked[1:].partition("]")
        understood = bool(bracket) and (not rest or rest.startswith(":"))
        port = rest[1:]
    else:
        name, colon, port = asked.partition(":")
        understood = not colon or bool(port)
    if not understood or (port and not (port.isascii() and port.isdigit())):
        return "", is_ipv6
    return name, is_ipv6


def _as_ipv4(
    address: ipaddress.IPv4Address | ipaddress.IPv6Address,
) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Return an IPv4 address mapped to IPv6 as IPv4, and any other unchanged."""
    return getattr(address, "ipv4_mapped", None) or address
