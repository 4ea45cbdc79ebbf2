"""A page that is served, and clients of it, for the tests."""

import asyncio
import json

import aiohttp

from workbench.link.backplane import ServedFlight
from workbench.link.drone_topics import drone_topics
from workbench.link.server import web
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.policy import Policy
from workbench.link.signal import TopicOptions
from workbench.link.wire import FrameKind, WireFrame

LIMIT = 300.0
"""Generous: nothing here is a matter of time [s]."""


def run(scenario, config=None, clients=16, an_address=4):
    """Run a test with a page that is served, within one loop."""

    async def served():
        flight = ServedFlight("x500", drone_topics(TopicOptions(4, 200, 8)), (), (8.0, 8.0, 0.4))
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
    return WireFrame(FrameKind.CONTROL, 0, 0, seq, 0, payload).to_bytes()
