"""The page's server: its files, and who is refused."""

import asyncio
import contextlib
import importlib.util
import shutil
import socket
from pathlib import Path

import aiohttp
import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.server import acceptor, web
from workbench.link.server.acceptor import MOST_OF_A_NETWORK
from workbench.link.server.config import ServerConfig

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
def over_tls(tmp_path):
    """Return what a page over TLS is to do."""
    if not shutil.which("openssl"):
        pytest.skip("needs openssl")
    return served.over_tls(tmp_path)


def test_the_page_is_whole():
    assert set(web.page_files()) >= PAGE
    assert not {name for name in web.page_files() if not name.endswith(tuple(web.TYPES))}


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
        text = file.body.decode()
        assert "http://" not in text.replace("http://www.w3.org/", ""), name
        assert "https://" not in text, name
        assert " style=" not in text and " onclick=" not in text, name
    assert b"<script>" not in web.page_files()["index.html"].body


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
def test_connections_of_one_address_are_bounded(tls, request):
    config = request.getfixturevalue("over_tls") if tls else None

    async def scenario(hub, page, client):
        knocking = []
        try:
            for _ in range(MOST_OF_A_NETWORK + 5):
                knocking.append(await asyncio.open_connection("127.0.0.1", page.port))
            # Who comes too late is cut off; the others stay, and keep no other address out.
            for reader, _ in knocking[-5:]:
                with contextlib.suppress(ConnectionResetError):
                    assert await reader.read() == b""
            assert not knocking[0][0].at_eof()
            assert hub.refusals.counts == {"too_many": 5}
            local = aiohttp.TCPConnector(local_addr=("127.0.0.2", 0), ssl=False)
            async with (
                aiohttp.ClientSession(connector=local) as other,
                other.get(page.address) as answer,
            ):
                assert answer.status == 200
        finally:
            for _, writer in knocking:
                writer.transport.abort()

    served.run(scenario, config)


def test_who_never_shakes_hands_is_cut_off(over_tls, monkeypatch):
    monkeypatch.setattr(acceptor, "HANDSHAKE_TIME", 0.2)

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
