"""The common parts of gateways with asyncio: tasks that end together, and messages to the user."""

import asyncio
from collections.abc import Callable
from time import monotonic

from workbench.link import AsyncClient

LOOK = 0.2
"""Period between checks for messages to the user [s]."""
SAY_AGAIN = 5.0
"""Time before a message is repeated [s]."""


async def all_of(works: list["asyncio.Task[None]"]) -> None:
    """Wait until one of several tasks ends, and end the others with it.

    Raises:
        WorkbenchError: the error of that task.
    """
    try:
        await asyncio.wait(works, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for work in works:
            work.cancel()
        ended = await asyncio.gather(*works, return_exceptions=True)
    for error in ended:
        if error is not None and not isinstance(error, asyncio.CancelledError):
            raise error


async def tell_trouble(client: AsyncClient, say: Callable[[str], None]) -> None:
    """Report when the connection to the drone is lost, and when it is restored."""
    lost = False
    while True:
        if client.trouble:
            say(f"{client.trouble}; trying again")
        elif lost:
            say(f"connected to {client.hello.vehicle} again")
        lost = bool(client.trouble)
        await asyncio.sleep(LOOK)


class Sayings:
    """Shows sentences, without frequent repetition.

    Args:
        say: shows the user a sentence.
        clock: time now [s].
    """

    def __init__(self, say: Callable[[str], None], clock: Callable[[], float] = monotonic) -> None:
        self._say = say
        self._clock = clock
        self._said: dict[str, float] = {}

    def __call__(self, sentence: str) -> None:
        now = self._clock()
        self._said = {each: when for each, when in self._said.items() if now - when < SAY_AGAIN}
        if sentence not in self._said:
            self._said[sentence] = now
            self._say(sentence)
