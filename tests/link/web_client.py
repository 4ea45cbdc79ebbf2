"""A page that is served, and clients of it, for the tests."""

import asyncio
import json
import subprocess

import aiohttp

from workbench.link.backplane import Flight
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.link.server import web
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.policy import Policy
from workbench.link.wire import Frame, Kind

LIMIT = 300.0
"""Generous: nothing here is a matter of time [s]."""


def run(scenario, config=None, clients=16, an_address=4):
    """Run a test with a page that is served, within one loop."""

    async def served():
        flight = Flight("x500", drone_topics(Outfit(4, 200, 8)), (), (8.0, 8.0, 0.4))
        hub = Hub(Policy(flight), Admission(clients, an_address), lambda record: None)
        page = web.Page(hub, config or ServerConfig(port=0, web=True))
        await page.open()
        try:
            async with asyncio.timeout(LIMIT), aiohttp.ClientSession() as client:
                await scenario(hub, page, client)
        finally:
            hub.stop("over")
            await page.close()

    asyncio.run(served())


def over_tls(folder):
    """Return what a page over TLS is to do, with a certificate that is made in a folder."""
    cert, key = folder / "cert.pem", folder / "key.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
        + ["-nodes", "-days", "2", "-subj", "/CN=127.0.0.1", "-addext"]
        + ["subjectAltName=IP:127.0.0.1", "-keyout", str(key), "-out", str(cert)],
        check=True,
        capture_output=True,
    )
    return ServerConfig(port=0, web=True, tls_cert=str(cert), tls_key=str(key))


def join(page, client, **headers):
    """Open a WebSocket, as the page does unless other headers are given."""
    headers = {"Origin": page.address.rstrip("/")} | headers
    return client.ws_connect(page.address.replace("http", "ws", 1) + "ws", headers=headers)


async def until(condition):
    while not condition():
        await asyncio.sleep(0.01)


async def operations(socket, decoder, number):
    """Return what a server says next."""
    found = []
    while len(found) < number:
        found += [json.loads(frame.payload) for frame in decoder.feed(await socket.receive_bytes())]
    return found


def said(op, seq=1, **values):
    payload = json.dumps({"op": op, **values}).encode()
    return Frame(Kind.CONTROL, 0, 0, seq, 0, payload).to_bytes()
