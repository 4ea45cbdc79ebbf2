"""Who comes from beyond this machine: over TLS and with a token, or not at all.

The clients are here, but connect by the address of this machine in its network, which is what the
server sees of them.
"""

import asyncio
import contextlib
import json
import ssl
import time
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from workbench.common.errors import WorkbenchError
from workbench.link import Client
from workbench.link.authentication import write_tokens
from workbench.link.backplane import ClientRequest, ServerStatus
from workbench.link.messages import RequestControl
from workbench.link.page_address import lan_address
from workbench.link.server.acceptor import (
    HANDSHAKE_TIMEOUT_S,
    MAX_BEGUN_CONNECTIONS,
    Acceptor,
    listen,
)
from workbench.link.server.config import ServerConfig
from workbench.link.wire import Decoder

LIMIT = 300.0
"""Generous: nothing here is a matter of time, but where it is said [s]."""


@pytest.fixture(scope="module")
def own():
    """Return the address of this machine in its network."""
    return lan_address() or pytest.skip("this machine has no network")


@pytest.fixture
def tokens(tmp_path):
    return write_tokens(tmp_path / "tokens")


@pytest.fixture
def served(serve, own, tokens, tmp_path, certificate):
    """Return a server for all networks."""
    cert, key = certificate
    file = str(tmp_path / "tokens")
    server = serve(ServerConfig("0.0.0.0", 0, file, cert, key, web=True))
    assert isinstance(server.begun, ServerStatus), server.begun
    return server


@pytest.fixture
def context(certificate):
    return ssl.create_default_context(cafile=certificate[0])


def got(client):
    """Return all that comes until the end."""
    data = b""
    try:
        while piece := client.socket.recv(65536):
            data += piece
    except ConnectionResetError:
        pass
    return data


def test_a_port_without_tls_is_closed_to_others_at_once(own, parts):
    """However it came to be opened: `ServerConfig.check` refuses to."""

    async def scenario():
        refused, made = [], []
        acceptor = Acceptor(listen("0.0.0.0", 0), made.append, lambda *said: refused.append(said))
        try:
            client = parts.Raw(acceptor.address.port, own)
            with client:
                assert await asyncio.to_thread(got, client) == b""
        finally:
            await acceptor.close()
        assert made == []
        assert refused == [("tls", f"{own}: others than this machine are served over TLS alone")]

    asyncio.run(scenario())


@pytest.mark.parametrize("words", [b"GET / HTTP/1.1\r\n\r\n", bytes(24), None], ids=str)
def test_who_comes_without_tls_gets_nothing(served, own, parts, words):
    with served.client(host=own) as client:
        begun = time.monotonic()
        client.send(words or parts.operation("ping"))
        assert got(client) == b""
        assert time.monotonic() < begun + HANDSHAKE_TIMEOUT_S
    status = served.hear_of(ServerStatus, lambda record: record.refusals)
    assert status.refusals == {"tls": 1}


@pytest.mark.parametrize("op", ["subscribe", "request_control", "flight", "ping"])
def test_who_has_no_token_neither_watches_nor_flies(served, own, parts, context, op):
    with served.client(host=own, context=context) as client:
        client.answer("hello")
        client.send(parts.operation(op, topics=["*"], what="stop", lease=1), parts.command())
        served.flight.send(parts.published(1))
        assert [(each["op"], each["code"]) for each in client.rest()] == [("error", "login")]
    while served.flight.poll():
        assert isinstance(served.flight.recv(), ServerStatus)


def test_who_guesses_tokens_waits(served, own, parts, context):
    def guess():
        with served.client(host=own, context=context) as client:
            client.send(parts.operation("login", role="command", token="x" * 20))
            return client.rest()[-1]["code"]

    assert [guess() for _ in range(5)] == ["bad_login"] * 4 + ["back_off"]


def test_a_crowd_over_tls_without_tokens_keeps_nobody_out(
    served, own, tokens, context, certificate
):
    crowd = []
    for _ in range(MAX_BEGUN_CONNECTIONS + 16):
        with contextlib.suppress(OSError):  # one that had to make room at once
            crowd.append(served.client(host=own, context=context))
    with Client(f"{own}:{served.port}", token=tokens.command, tls=certificate[0]) as client:
        assert client.ping() >= 0.0
    for each in crowd:
        each.socket.close()


def test_a_token_goes_over_tls_alone(served, own, tokens, certificate):
    address = f"{own}:{served.port}"
    with pytest.raises(WorkbenchError, match="is another machine, and without TLS"):
        Client(address, token=tokens.command).__enter__()
    with pytest.raises(WorkbenchError, match="wants a token"):
        Client(address, tls=certificate[0]).__enter__()
    with Client(address, token=tokens.view, role="view", tls=certificate[0]) as client:
        with pytest.raises(WorkbenchError, match="refused: this client only watches"):
            client.control().__enter__()
        assert client.ping() >= 0.0


def test_the_page_is_served_over_https_and_flies_with_a_token(served, own, parts, tokens, context):
    page = served.begun.page or served.hear_of(ServerStatus, lambda record: record.page).page
    assert page.startswith(f"https://{own}:")
    with parts.Raw(urlsplit(page).port, own) as plain:
        plain.send(f"GET / HTTP/1.1\r\nHost: {urlsplit(page).netloc}\r\n\r\n".encode())
        assert got(plain) == b""
    socket, origin = page.replace("https", "wss") + "ws", page.rstrip("/")
    with pytest.raises(InvalidStatus):
        connect(socket, origin="https://elsewhere.example", ssl=context)
    for token, codes in [("x" * 20, ["bad_login"]), (tokens.command, [])]:
        with connect(socket, origin=origin, ssl=context, open_timeout=LIMIT) as link:
            decoder = Decoder()
            # In one piece: the server closes the connection as soon as it has read a bad login.
            login = parts.operation("login", role="command", token=token).to_bytes()
            link.send(login + parts.operation("request_control", 2).to_bytes())
            if codes:
                said = [json.loads(each.payload) for data in link for each in decoder.feed(data)]
                assert [each["code"] for each in said if each["op"] == "error"] == codes
            else:
                assert isinstance(served.hear_of(ClientRequest).operation, RequestControl)
