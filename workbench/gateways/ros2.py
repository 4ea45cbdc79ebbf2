"""The gateway to ROS 2: a client of the link that uses DDS, without ROS installed."""

import asyncio
from collections.abc import Callable
from importlib.util import find_spec
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros2_options import LOOPBACK, Ros2Options, domain_number
from workbench.gateways.running import (
    LOOK,
    LinkOptions,
    Sayings,
    all_of,
    run_until_interrupted,
    tell_trouble,
)

if TYPE_CHECKING:
    from cyclonedds.domain import DomainParticipant

    from workbench.gateways.ros2_publishing import Publishing
    from workbench.link import AsyncClient

POLL = 0.01
"""Period between checks for orders [s]."""
IN_A_ROW = 16
"""Number of samples sent before other work gets a turn."""


def run_ros2(link: LinkOptions, options: Ros2Options, say: Callable[[str], None] = print) -> None:
    """Publish the data of a server to ROS 2, and let ROS 2 fly if allowed, until Ctrl-C.

    Args:
        link: connection to the server.
        options: of the gateway.
        say: shows the user a sentence.

    Raises:
        WorkbenchError: if the extra is not installed, an option is invalid, the server rejects the
            client or is gone, or DDS cannot be used.
    """
    options.check()
    if find_spec("cyclonedds") is None:
        raise WorkbenchError(
            "ROS 2 topics need the package cyclonedds: `pip install cyclonedds`; it comes for "
            "Python 3.11 to 3.13"
        )
    run_until_interrupted(serve_ros2(link, options, Sayings(say)))


async def serve_ros2(link: LinkOptions, options: Ros2Options, say: Callable[[str], None]) -> None:
    """Do the work of `run_ros2` until it is cancelled."""
    from cyclonedds.core import DDSException

    from workbench.gateways.ros2_dds import DdsDomain
    from workbench.gateways.ros2_publishing import Publishing

    number = domain_number(options.domain)
    async with link.async_client() as client:
        with DdsDomain(number, options.interface, options.configuration) as domain:
            try:
                publishing = Publishing(domain.participant)
                publishing.announce(client.hello.topics)
                take = _take_orders if options.allow_commands else _refuse_orders
                works = [
                    _publish(client, publishing, say),
                    take(client, domain.participant, say),
                    tell_trouble(client, say),
                ]
                say(_greeting(client, options, number, len(publishing.channels)))
                await all_of([asyncio.create_task(work) for work in works])
            except DDSException as error:
                raise WorkbenchError(f"DDS cannot continue: {error}") from error


async def _publish(
    client: "AsyncClient", publishing: "Publishing", say: Callable[[str], None]
) -> None:
    """Pass samples on as they come."""
    count = 0
    async for sample in client:
        publishing.write(sample)
        count += 1
        if count % IN_A_ROW == 0:
            await asyncio.sleep(0)
        if publishing.dropped:
            say("a ROS 2 program reads too slowly: some messages are left out")
            publishing.dropped = 0


async def _take_orders(
    client: "AsyncClient", participant: "DomainParticipant", say: Callable[[str], None]
) -> None:
    """Pass orders on as they come."""
    from workbench.gateways.ros2_orders import Commanding, Orders

    orders, commanding = Orders(participant), Commanding(client, say)
    now = asyncio.get_running_loop().time
    looked = now()
    try:
        while True:
            since, looked = looked, now()
            for order in list(orders.take()):  # all orders since the last check
                await commanding.obey(order, since)
            await commanding.look()
            await asyncio.sleep(POLL)
    finally:
        await commanding.release()


async def _refuse_orders(
    client: "AsyncClient", participant: "DomainParticipant", say: Callable[[str], None]
) -> None:
    """Report that orders are not accepted."""
    from workbench.gateways.ros2_orders import Orders

    orders = Orders(participant)
    while True:
        if list(orders.take()):
            say(
                "a ROS 2 program wants to fly, but this gateway only watches: start it with "
                "--allow-commands"
            )
        await asyncio.sleep(LOOK)


def _greeting(client: "AsyncClient", options: Ros2Options, number: int, topics: int) -> str:
    """Return the message for a successful start."""
    where = f"the network of {options.interface}"
    if options.configuration:
        where = "where its configuration says"
    elif options.interface == LOOPBACK:
        where = "this computer alone"
    commands = "commands are taken" if options.allow_commands else "it only watches"
    return (
        f"{client.hello.vehicle}: {topics} ROS 2 topics in domain {number}, for {where}; "
        f"{commands}; Ctrl-C ends it"
    )
