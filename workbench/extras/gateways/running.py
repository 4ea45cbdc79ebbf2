"""The common parts of gateways: options of the connection, tasks that end together, messages."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass
from time import monotonic
from typing import Any

from workbench.link import AsyncClient, Client
from workbench.link.control import AsyncControl
from workbench.link.messages import Role

MESSAGE_CHECK_PERIOD_S = 0.2
"""Period between checks for messages to the user [s]."""
ROTOR_STATE_DELAY_S = 1.0
"""Simulated time after an operation from which the state of the rotors shows its effect [s]."""
MESSAGE_REPEAT_S = 5.0
"""Time before a message is repeated [s]."""


@dataclass(frozen=True)
class LinkOptions:
    """The connection of a gateway to the server of a flight.

    The attributes are the arguments of `workbench.link.Client`. Only a gateway with the role
    command passes commands on.
    """

    address: str
    name: str
    token: str = ""
    role: Role = Role.VIEW
    tls: str | bool | None = None
    topics: Sequence[str] = ("*",)
    rate: float | None = None

    @property
    def flies(self) -> bool:
        """Whether the gateway passes commands on."""
        return self.role is Role.COMMAND

    def client(self) -> Client:
        """Return a client for a program without asyncio."""
        return Client(**vars(self))

    def async_client(self) -> AsyncClient:
        """Return a client for asyncio."""
        return AsyncClient(**vars(self))


SetParameters = Callable[[Mapping[str, float]], Awaitable[None]]
"""Sets live parameters, all or none; it raises a WorkbenchError with the reason."""


async def set_parameters(
    client: AsyncClient, control: AsyncControl | None, values: Mapping[str, float]
) -> None:
    """Set live parameters, all or none, with the control that a gateway has or for this alone.

    Raises:
        WorkbenchError: if it is refused.
    """
    if control is not None:
        await control.set(**values)
        return
    async with client.control() as own:
        await own.set(**values)


def rotors_stopped(client: AsyncClient, operated: float) -> bool:
    """Return whether the rotors stand still after an operation.

    The state of before an operation says nothing of what it does.

    Args:
        client: of the link.
        operated: simulated time of the operation [s].
    """
    rotors = client.latest("on_off_state")
    if rotors is None or rotors["on"]:
        return False
    return rotors.time - operated >= ROTOR_STATE_DELAY_S


def run_until_interrupted(work: Coroutine[Any, Any, None]) -> None:
    """Run a gateway until it ends, or until Ctrl-C, its usual end."""
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(work)


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


async def report_connection(client: AsyncClient, say: Callable[[str], None]) -> None:
    """Report when the connection to the drone is lost, and when it is restored."""
    lost = False
    while True:
        if client.trouble:
            say(f"{client.trouble}; trying again")
        elif lost:
            say(f"connected to {client.hello.vehicle} again")
        lost = bool(client.trouble)
        await asyncio.sleep(MESSAGE_CHECK_PERIOD_S)


def throttled(
    say: Callable[[str], None], clock: Callable[[], float] = monotonic
) -> Callable[[str], None]:
    """Return a function that shows sentences, without frequent repetition.

    Args:
        say: shows the user a sentence.
        clock: time now [s].
    """
    shown: dict[str, float] = {}

    def show(sentence: str) -> None:
        now = clock()
        for each in [each for each, when in shown.items() if now - when >= MESSAGE_REPEAT_S]:
            del shown[each]
        if sentence not in shown:
            shown[sentence] = now
            say(sentence)

    return show
