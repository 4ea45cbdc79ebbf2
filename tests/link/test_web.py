"""The page's server: its files, and who is refused."""

import asyncio
import contextlib
import gc
import importlib.util
import math
import socket
import ssl
from pathlib import Path

import aiohttp
import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.backplane import Published
from workbench.link.server import acceptor, web
from workbench.link.server.config import ServerConfig
from workbench.link.server.web import MAX_WEB_MESSAGE_BYTES
from workbench.link.wire import Decoder, WireFrame

PAGE = {
    "index.html",
    "style.css",
    "icon.svg",
    "app.js",
    "link.js",
    "lease.js",
    "wire.js",
    "sticks.js",
}


def load(name):
    """Return a module that stands beside the tests and is no test."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


served = load("web_client")


@pytest.fixture
def over_tls(certificate):
    """Return what a page over TLS is to do."""
    cert, key = certificate
    return ServerConfig(port=0, web=True, tls_cert=cert, tls_key=key)


def test_the_page_is_whole():
    assert set(web.page_files()) >= PAGE
    assert not {
        name for name in web.page_files() if not name.endswith(tuple(web.MEDIA_TYPE_BY_SUFFIX))
    }


def test_files_come_with_strict_headers():
    async def scenario(hub, page, client):
        for name in ["", *web.page_files()]:
            async with client.get(page.address + name) as answer:
                assert answer.status == 200, name
                assert answer.headers["X-Content-Type-Options"] == "nosniff"
                assert answer.headers["Cache-Control"] == "no-store"
                assert answer.headers["Referrer-Policy"] == "no-referrer"
                policy = dict(
                    part.strip().split(" ", 1)
                    for part in answer.headers["Content-Security-Policy"].split(";")
                )
                assert policy["default-src"] == "'self'"
                assert policy["frame-ancestors"] == "'none'"
                port = page.port
                assert policy["connect-src"] == f"'self' ws://127.0.0.1:{port}"
                assert "unsafe" not in str(policy) and "script-src" not in policy

    served.run(scenario)


def test_the_page_runs_no_script_of_its_own_text_and_loads_nothing_from_elsewhere():
    for name, file in web.page_files().items():
        text = file.decode()
        assert "http://" not in text.replace("http://www.w3.org/", ""), name
        assert "https://" not in text, name
        assert " style=" not in text and " onclick=" not in text, name
    assert b"<script>" not in web.page_files()["index.html"]


@pytest.mark.parametrize(
    "path", ["package.json", "../wire.py", "%2e%2e/wire.py", "page", "app.js/", "ws/", "x" * 500]
)
def test_nothing_else_is_served(path):
    async def scenario(hub, page, client):
        import yarl

        async with client.get(yarl.URL(page.address + path, encoded=True)) as answer:
            assert answer.status == 404
            assert answer.headers["X-Content-Type-Options"] == "nosniff"

    served.run(scenario)


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS"])
def test_only_get_is_answered(method):
    async def scenario(hub, page, client):
        async with client.request(method, page.address) as answer:
            assert answer.status == 405

    served.run(scenario)


@pytest.mark.parametrize("path", ["", "app.js", "ws"])
def test_a_foreign_host_is_refused_and_counted(path):
    async def scenario(hub, page, client):
        headers = {"Host": f"evil.example:{page.port}", "Origin": "http://evil.example"}
        async with client.get(page.address + path, headers=headers) as answer:
            assert answer.status == 403
            assert "evil.example" in await answer.text()
        assert hub.refusals.counts == {"host": 1}
        assert "evil.example" in hub.refusals.log[0]

    served.run(scenario)


@pytest.mark.parametrize("tls", [False, True], ids=["http", "https"])
def test_who_only_knocks_makes_room_for_others(tls, request, monkeypatch):
    """The page is answered and a client stays in, however many connections ask for nothing."""
    monkeypatch.setattr(acceptor, "MAX_BEGUN_CONNECTIONS", 8)
    for limit in ("BEGINS_PER_TURN", "BEGIN_RATE_HZ"):  # so they begin in the order they came in
        monkeypatch.setattr(acceptor, limit, math.inf)
    monkeypatch.setattr(acceptor, "HANDSHAKE_TIMEOUT_S", served.LIMIT)
    monkeypatch.setattr(web, "WEB_IDLE_TIMEOUT_S", served.LIMIT)
    config = request.getfixturevalue("over_tls") if tls else None
    trusted = ssl.create_default_context(cafile=config.tls_cert) if tls else None

    async def scenario(hub, page, client):
        knocking = []
        try:
            async with client.ws_connect(
                page.address + "ws", origin=page.address.rstrip("/"), ssl=trusted or True
            ) as link:
                await served.operations(link, Decoder(), 1)
                for _ in range(8 + 5):
                    knocking.append(await asyncio.open_connection("127.0.0.1", page.port))
                # The oldest are cut off; the newest stay.
                for reader, _ in knocking[:5]:
                    with contextlib.suppress(ConnectionResetError):
                        assert await reader.read() == b""
                await served.until(lambda: hub.refusals.counts.get("too_many", 0) >= 6)
                assert not knocking[-1][0].at_eof()
                async with client.get(page.address, ssl=trusted or True) as answer:
                    assert answer.status == 200
                await link.send_bytes(served.said("ping", 1, id=7))
                [pong] = await served.operations(link, Decoder(), 1)
                assert pong["id"] == 7
        finally:
            for _, writer in knocking:
                writer.transport.abort()

    served.run(scenario, config)


def test_who_never_shakes_hands_is_cut_off(over_tls, monkeypatch):
    monkeypatch.setattr(acceptor, "HANDSHAKE_TIMEOUT_S", 0.2)

    async def scenario(hub, page, client):
        reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
        with contextlib.suppress(ConnectionResetError):
            assert await reader.read() == b""
        await served.until(lambda: hub.refusals.counts == {"tls": 1})
        writer.transport.abort()

    served.run(scenario, over_tls)


def test_a_name_with_two_addresses_has_one_port(monkeypatch):
    found = [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (f"127.0.0.{n}", 0)) for n in (1, 2)]
    listened = []
    begin = socket.socket.listen

    def note(self, *how):
        begin(self, *how)
        listened.append(self.getsockname())

    async def scenario(hub, page, client):
        assert listened == [("127.0.0.1", page.port)]
        assert page.address == f"http://localhost:{page.port}/"

    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: found)
    monkeypatch.setattr(socket.socket, "listen", note)
    served.run(scenario, ServerConfig("localhost", port=0, web=True))


@pytest.mark.parametrize(
    "request_line",
    [
        b"GET /?" + b"x" * 4_000 + b" HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nX: " + b"x" * 10_000 + b"\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"".join(b"X%d: 1\r\n" % i for i in range(100)) + b"\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n",
    ],
)
def test_what_is_no_sound_request_gets_no_page(request_line):
    async def scenario(hub, page, client):
        reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
        host = f"\r\nHost: 127.0.0.1:{page.port}\r\n".encode()
        writer.write(request_line.replace(b"\r\n", host, 1))
        with contextlib.suppress(ConnectionResetError):
            assert b" 200 " not in (await reader.read())[:40]
        writer.close()
        async with client.get(page.address) as answer:
            assert answer.status == 200

    served.run(scenario)


def test_a_long_cookie_of_another_program_is_no_hindrance():
    async def scenario(hub, page, client):
        async with client.get(page.address, headers={"Cookie": "x" * 4000}) as answer:
            assert answer.status == 200

    served.run(scenario)


def test_a_port_in_use_is_a_sentence():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        config = ServerConfig(port=0, web=True, web_port=taken.getsockname()[1])
        with pytest.raises(WorkbenchError, match=r"page cannot listen at 127\.0\.0\.1:\d+: .*port"):
            served.run(None, config)


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1", ""])
def test_a_foreign_origin_is_refused_and_counted(origin):
    async def scenario(hub, page, client):
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await served.join(page, client, Origin=origin)
        assert refused.value.status == 403
        assert hub.refusals.counts == {"origin": 1}
        assert hub.status().clients == ()

    served.run(scenario)


def test_what_is_no_websocket_is_told_so():
    async def scenario(hub, page, client):
        origin = {"Origin": page.address.rstrip("/")}
        async with client.get(page.address + "ws", headers=origin) as answer:
            assert answer.status == 400

    served.run(scenario)


def test_a_websocket_carries_frames_in_parts_and_several_at_once():
    async def scenario(hub, page, client):
        async with served.join(page, client) as link:
            decoder = Decoder()
            [hello] = await served.operations(link, decoder, 1)
            assert (hello["op"], hello["vehicle"]) == ("hello", "x500")
            [peer] = hub.status().clients
            assert (peer.transport, peer.address.split(":")[0]) == ("websocket", "127.0.0.1")
            stream = served.said("ping", 1, id=7) + served.said("ping", 2, id=8)
            for begin in range(0, len(stream), 11):
                await link.send_bytes(stream[begin : begin + 11])
            await link.send_bytes(served.said("ping", 3, id=9) + served.said("ping", 4, id=10))
            pongs = await served.operations(link, decoder, 4)
            assert [pong["id"] for pong in pongs] == [7, 8, 9, 10]
        await served.until(lambda: hub.status().clients == ())

    served.run(scenario)


def test_a_goodbye_arrives_before_the_end():
    async def scenario(hub, page, client):
        async with served.join(page, client) as link:
            decoder = Decoder()
            await served.operations(link, decoder, 1)
            hub.stop("the server stops")
            [bye] = await served.operations(link, decoder, 1)
            assert bye == {"op": "bye", "said": "the server stops"}
            assert (await link.receive()).type is aiohttp.WSMsgType.CLOSE

    served.run(scenario)


def test_a_text_ends_the_connection_and_is_counted():
    async def scenario(hub, page, client):
        async with served.join(page, client) as link:
            await served.operations(link, Decoder(), 1)
            await link.send_str("text")
            [error] = await served.operations(link, Decoder(), 1)
            assert (error["op"], error["code"]) == ("error", "kind")
            assert (await link.receive()).data == aiohttp.WSCloseCode.UNSUPPORTED_DATA
        await served.until(lambda: hub.status().clients == ())
        assert hub.refusals.counts == {"kind": 1}

    served.run(scenario)


MASK = b"\x11\x22\x33\x44"


def masked(payload, first=0x82):
    """Return a frame of a WebSocket's client, by the words of RFC 6455 alone."""
    size = len(payload)
    if size < 126:
        length = bytes([0x80 | size])
    else:
        wide = size >= 1 << 16
        length = (b"\xff" if wide else b"\xfe") + size.to_bytes(8 if wide else 2, "big")
    hidden = bytes(byte ^ MASK[index % 4] for index, byte in enumerate(payload))
    return bytes([first]) + length + MASK + hidden


def test_a_websocket_is_read_as_the_standard_says():
    """In pieces of any size; what is not a frame of it ends the connection with the right code."""
    ping = served.said("ping", 1, id=1)
    sound = masked(ping[:9], 0x02) + masked(b"ask", 0x89) + masked(ping[9:], 0x80) + masked(ping)

    async def scenario(hub, page, client):
        for broken, code in [
            (masked(b"\x03\xe8", 0x88), 1000),  # the client ends it
            (b"\x82\x01x", 1002),  # without a mask
            (masked(b"x", 0xC2), 1002),  # a bit of an extension
            (masked(b"x", 0x83), 1002),  # no opcode
            (masked(b"x", 0x80), 1002),  # goes on with nothing
            (masked(ping[:9], 0x02) + masked(b"x", 0x82), 1002),  # within another
            (masked(bytes(126), 0x89), 1002),  # too long a ping
            (masked(b"", 0x09), 1002),  # a ping in parts
            (masked(served.said("ping", 1) * 1000, 0x02) + masked(bytes(60000), 0x80), 1009),
            (masked(bytes(MAX_WEB_MESSAGE_BYTES + 1)), 1009),
            (b"\x82\xff" + (2**62).to_bytes(8, "big"), 1009),
        ]:
            reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
            writer.write("\r\n".join((*joining(page), "", "")).encode())
            await reader.readuntil(b"\r\n\r\n")
            for byte in sound:
                writer.write(bytes([byte]))
            received = b""
            while received.count(b'"pong"') < 2 or b"\x8a\x03ask" not in received:
                assert not reader.at_eof(), received
                received += await reader.read(4096)
            for byte in broken:
                writer.write(bytes([byte]))
            with contextlib.suppress(ConnectionResetError):  # what was not read resets it
                received = await reader.read()
                ended = received.rpartition(b"\x88")[2]
                assert int.from_bytes(ended[1:3], "big") == code, broken[:9]
            writer.close()
            await served.until(lambda: hub.status().clients == ())

    served.run(scenario)


def joining(page):
    """Return the lines of a request for a WebSocket."""
    return (
        "GET /ws HTTP/1.1",
        f"Host: 127.0.0.1:{page.port}",
        f"Origin: {page.address.rstrip('/')}",
        "Connection: Upgrade",
        "Upgrade: websocket",
        "Sec-WebSocket-Version: 13",
        f"Sec-WebSocket-Key: {'A' * 22}==",
    )


def ask(page, *lines):
    """Send a request as it stands, and return the first line of the answer."""
    with socket.create_connection(("127.0.0.1", page.port), served.LIMIT) as link:
        link.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        return link.recv(4096).partition(b"\r\n")[0].decode()


def test_requests_that_two_readers_could_take_differently_are_refused():
    async def scenario(hub, page, client):
        host, origin = f"Host: 127.0.0.1:{page.port}", f"Origin: {page.address.rstrip('/')}"
        upgrade = ("Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13")
        join = ("GET /ws HTTP/1.1", *upgrade, f"Sec-WebSocket-Key: {'A' * 22}==")
        for lines, status in [
            (("GET / HTTP/1.1", host), 200),
            (("GET / HTTP/1.0",), 400),
            (("GET / HTTP/1.0", host), 400),
            (("GET / HTTP/1.1",), 400),
            (("GET / HTTP/1.1", host, host), 400),
            ((*join, host, origin), 101),
            ((*join, host, origin, origin), 403),
            ((*join, host), 403),
            ((*join[:1], *join[2:], host, origin), 400),
            ((*join[:3], "Sec-WebSocket-Version: 8", join[4], host, origin), 400),
            ((*join[:3], *join[4:], host, origin), 400),
            (("GET / HTTP/1.1", f"Host: 127.0.0.1%00:{page.port}"), 403),
            (("GET / HTTP/1.1", f"Host: [127.0.0.1]:{page.port}"), 403),
        ]:
            answer = await asyncio.to_thread(ask, page, *lines)
            assert answer.split()[1] == str(status), lines

    served.run(scenario)


def test_the_largest_message_is_taken():
    async def scenario(hub, page, client):
        async with served.join(page, client) as link:
            decoder = Decoder()
            await served.operations(link, decoder, 1)
            ping = served.said("ping", 2, id=1)
            skipped = WireFrame(0x80, 0, 0, 1, 0, bytes(MAX_WEB_MESSAGE_BYTES - 24 - len(ping)))
            await link.send_bytes(skipped.to_bytes() + ping)
            assert (await served.operations(link, decoder, 1))[0]["op"] == "pong"

    served.run(scenario)


def test_bytes_that_are_no_frames_are_answered_with_an_error():
    async def scenario(hub, page, client):
        async with served.join(page, client) as link:
            decoder = Decoder()
            await served.operations(link, decoder, 1)
            await link.send_bytes(b"GET / HTTP/1.1")
            [error] = await served.operations(link, decoder, 1)
            assert (error["op"], error["code"]) == ("error", "magic")

    served.run(scenario)


def test_a_ping_of_the_browser_is_answered():
    async def scenario(hub, page, client):
        origin = {"Origin": page.address.rstrip("/")}
        address = page.address + "ws"
        async with client.ws_connect(address, headers=origin, autoping=False) as link:
            await served.operations(link, Decoder(), 1)
            await link.ping(b"are you there")
            answer = await link.receive()
            assert (answer.type, answer.data) == (aiohttp.WSMsgType.PONG, b"are you there")

    served.run(scenario)


def test_a_connection_gets_one_answer():
    """However many requests come at once: each takes time from the clients that fly."""

    async def scenario(hub, page, client):
        reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
        request = f"GET /icon.svg HTTP/1.1\r\nHost: 127.0.0.1:{page.port}\r\n\r\n"
        writer.write(request.encode() * 100)
        received = await reader.read()
        assert received.count(b"HTTP/1.1 200 OK\r\n") == received.count(b"HTTP/1.1") == 1
        assert b"\r\nConnection: close\r\n" in received
        assert received.endswith(web.page_files()["icon.svg"])
        writer.close()

    served.run(scenario)


@pytest.mark.parametrize("size", [1, web.MAX_WEB_REQUEST_BYTES])
def test_a_request_that_never_ends_is_cut_off(size):
    """In whatever pieces it comes: each read takes time."""

    async def scenario(hub, page, client):
        reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
        writer.write(b"GET / HTTP/1.1\r\nX: ")
        answer = asyncio.create_task(reader.read())
        with contextlib.suppress(ConnectionError):
            while not answer.done():
                writer.write(b"x" * size)
                await asyncio.sleep(0)
        with contextlib.suppress(ConnectionError):
            assert (await answer).startswith(b"HTTP/1.1 431 ")
        writer.close()

    served.run(scenario)


@pytest.mark.parametrize("what", ["empty", "ping", "pong", "continuation"])
def test_what_carries_nothing_counts_as_well(what, monkeypatch):
    """Whoever sends it without end must be read as slowly as who sends frames without end."""

    async def scenario(hub, page, client):
        paused = []
        receive = hub.receive

        def note(session, size=None):
            if size is None:
                paused.append(session)
            return receive(session, size)

        monkeypatch.setattr(hub, "receive", note)
        first = {"empty": 0x82, "ping": 0x89, "pong": 0x8A, "continuation": 0x00}[what]
        reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
        writer.write("\r\n".join((*joining(page), "", "")).encode())
        await reader.readuntil(b"\r\n\r\n")
        writer.write(masked(b"", 0x02) + masked(b"", 0x80) + masked(b"", 0x02) * (not first))
        writer.write(masked(b"", first) * 300)
        await served.until(lambda: paused)
        writer.close()

    served.run(scenario)


def test_places_are_those_of_all_clients():
    async def scenario(hub, page, client):
        async with contextlib.AsyncExitStack() as stack:
            for _ in range(2):
                link = await stack.enter_async_context(served.join(page, client))
                await served.operations(link, Decoder(), 1)
            link = await stack.enter_async_context(served.join(page, client))
            [error] = await served.operations(link, Decoder(), 1)
            assert (error["op"], error["code"]) == ("error", "too_many")

    served.run(scenario, clients=2, an_address=2)


def test_a_client_that_reads_nothing_is_ended_with_what_it_was_sent():
    async def scenario(hub, page, client):
        deaf = socket.create_connection(("127.0.0.1", page.port))
        deaf.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        host = f"127.0.0.1:{page.port}"
        request = (
            f"GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\n"
            "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        deaf.sendall(request.encode())
        await served.until(lambda: len(hub._sessions) == 1)
        [session] = hub._sessions.values()
        for _ in range(4000):
            session.transport.write(bytes(4096))
        await served.until(lambda: 0 < session.transport.unsent < 4000 * 4096)
        session.transport.close()
        await served.until(lambda: hub.status().clients == ())
        deaf.close()

    served.run(scenario)


def test_a_client_that_vanishes_while_it_is_sent_to_leaves_no_error(caplog):
    async def scenario(hub, page, client):
        reader, writer = await asyncio.open_connection("127.0.0.1", page.port)
        writer.write("\r\n".join((*joining(page), "", "")).encode())
        await served.until(lambda: len(hub._sessions) == 1)
        [session] = hub._sessions.values()
        writer.write(masked(b"ask", 0x89) * 100)
        writer.transport.abort()
        while hub.status().clients:
            session.transport.write(bytes(4096))
            await asyncio.sleep(0)

    served.run(scenario)
    gc.collect()
    assert [record.getMessage() for record in caplog.records] == []


def test_data_goes_to_the_page_in_batches():
    async def scenario(hub, page, client):
        async with served.join(page, client) as link:
            decoder = Decoder()
            await served.operations(link, decoder, 1)
            await link.send_bytes(
                served.said("subscribe", 1, id=1, topics=["/dh_drone/velocity_data"])
            )
            await served.operations(link, decoder, 1)
            hub.hear([Published(5, 6, ((3, bytes(24)),))])
            [frame] = decoder.feed(await link.receive_bytes())
            assert (frame.kind, frame.topic, frame.flags, frame.t_ns) == (1, 3, 2, 5)

    served.run(scenario)


def test_with_a_certificate_all_goes_over_tls(over_tls):
    trusted = ssl.create_default_context(cafile=over_tls.tls_cert)

    async def scenario(hub, page, client):
        assert page.address == f"https://127.0.0.1:{page.port}/"
        async with client.get(page.address, ssl=trusted) as answer:
            assert f"wss://127.0.0.1:{page.port};" in answer.headers["Content-Security-Policy"]
        address, origin = page.address + "ws", page.address.rstrip("/")
        async with client.ws_connect(address, origin=origin, ssl=trusted) as link:
            assert (await served.operations(link, Decoder(), 1))[0]["op"] == "hello"
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await client.ws_connect(address, origin=origin.replace("https", "http"), ssl=trusted)

    served.run(scenario, over_tls)
