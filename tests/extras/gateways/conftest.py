"""The scripted server of the link's tests stands beside the gateways, too."""

import asyncio

from tests.link.conftest import fakes, server

__all__ = ["fakes", "server", "until"]


async def until(condition):
    """Wait until a condition holds, and return what it gave."""
    async with asyncio.timeout(300.0):
        while not (given := condition()):
            await asyncio.sleep(0.002)
    return given
