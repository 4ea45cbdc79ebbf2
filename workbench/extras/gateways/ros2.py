"""The gateway to ROS 2: a client of the link that uses DDS, without ROS installed."""

import asyncio
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, NoReturn

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_options import LOOPBACK_INTERFACE, Ros2Options, domain_number
from workbench.extras.gateways.ros2_trajectory import TrajectoryOrder
from workbench.extras.gateways.running import (
    MESSAGE_CHECK_PERIOD_S,
    LinkOptions,
    all_of,
    report_connection,
    run_until_interrupted,
    throttled,
)
from workbench.link.ros_messages.namespace import ros_namespace

if TYPE_CHECKING:
    from workbench.extras.gateways.ros2_node import FlightNode
    from workbench.extras.gateways.ros2_orders import OrderExecutor, RosOrder
    from workbench.extras.gateways.ros2_publishing import RosPublisher
    from workbench.extras.gateways.ros2_servos import ServoMover
    from workbench.link import AsyncClient

ORDER_POLL_PERIOD_S = 0.01
"""Period between checks for orders [s]."""
REQUEST_POLL_PERIOD_S = 0.05
"""Period between checks for requests of services [s]; there are many readers."""
SAMPLES_PER_TURN = 16
"""Number of samples sent before other work gets a turn."""
ONLY_WATCHES = "this gateway only watches: start it with --allow-commands"


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
    run_until_interrupted(serve_ros2(link, options, throttled(say)))


async def serve_ros2(link: LinkOptions, options: Ros2Options, say: Callable[[str], None]) -> None:
    """Do the work of `run_ros2` until it is cancelled."""
    from cyclonedds.core import DDSException

    from workbench.extras.gateways.ros2_dds import DdsDomain
    from workbench.extras.gateways.ros2_node import FlightNode
    from workbench.extras.gateways.ros2_orders import OrderExecutor, order_readers, take_orders
    from workbench.extras.gateways.ros2_publishing import RosPublisher
    from workbench.extras.gateways.ros2_servos import ServoMover

    number = domain_number(options.domain)
    async with link.async_client() as client:
        with DdsDomain(number, options.interface, options.configuration) as domain:
            try:
                namespace = options.namespace or ros_namespace(client.hello.vehicle)
                publishing = RosPublisher(domain.participant, namespace)
                publishing.announce(client.hello.topics)
                await _describe(client, publishing, say)
                readers, commanding = order_readers(domain, namespace), OrderExecutor(client, say)
                orders = partial(take_orders, readers)
                flies = options.allow_commands
                node = FlightNode(
                    client,
                    domain.participant,
                    namespace,
                    commanding.operate if flies else _refuse,
                    commanding.set if flies else _refuse,
                    say,
                )
                node.announce(publishing.writers)
                works = [
                    _publish(client, publishing, say),
                    _take_orders(commanding, orders, node, ServoMover(client, commanding, say))
                    if flies
                    else _refuse_orders(orders, node, say),
                    report_connection(client, say),
                ]
                say(_greeting(client, options, number, namespace, len(publishing.channels)))
                await all_of([asyncio.create_task(work) for work in works])
            except DDSException as error:
                raise WorkbenchError(f"DDS cannot continue: {error}") from error


async def _describe(
    client: "AsyncClient", publishing: "RosPublisher", say: Callable[[str], None]
) -> None:
    """Publish the description of the drone, if the server has it."""
    try:
        publishing.describe(await client.description())
    except WorkbenchError as error:
        say(f"there is no /robot_description: {error}")


async def _publish(
    client: "AsyncClient", publishing: "RosPublisher", say: Callable[[str], None]
) -> None:
    """Pass samples on as they come."""
    count = 0
    async for sample in client:
        publishing.write(sample)
        count += 1
        if count % SAMPLES_PER_TURN == 0:
            await asyncio.sleep(0)
        if publishing.dropped:
            say("a ROS 2 program reads too slowly: some messages are left out")
            publishing.dropped = 0


async def _take_orders(
    commanding: "OrderExecutor",
    orders: "Callable[[], Iterator[RosOrder]]",
    node: "FlightNode",
    servos: "ServoMover",
) -> None:
    """Pass orders on as they come, and answer requests."""
    now = asyncio.get_running_loop().time
    looked = served = now()
    try:
        while True:
            since, looked = looked, now()
            for order in list(orders()):  # all orders since the last check
                if isinstance(order, TrajectoryOrder):
                    await servos.start(order)
                else:
                    await commanding.execute(order, since)
            await servos.look()
            if looked - served >= REQUEST_POLL_PERIOD_S:
                served = looked
                await node.serve()
            await commanding.look()
            await asyncio.sleep(ORDER_POLL_PERIOD_S)
    finally:
        await commanding.release()


async def _refuse_orders(
    orders: "Callable[[], Iterator[RosOrder]]", node: "FlightNode", say: Callable[[str], None]
) -> None:
    """Report that orders are not accepted, and answer requests with that."""
    while True:
        if list(orders()):
            say(f"a ROS 2 program wants to fly, but {ONLY_WATCHES}")
        await node.serve()
        await asyncio.sleep(MESSAGE_CHECK_PERIOD_S)


async def _refuse(what: object) -> NoReturn:
    """Refuse a request.

    Raises:
        WorkbenchError: always.
    """
    raise WorkbenchError(ONLY_WATCHES)


def _greeting(
    client: "AsyncClient", options: Ros2Options, number: int, namespace: str, topics: int
) -> str:
    """Return the message for a successful start."""
    where = f"the network of {options.interface}"
    if options.configuration:
        where = "where its configuration says"
    elif options.interface == LOOPBACK_INTERFACE:
        where = "this computer alone"
    commands = "commands are taken" if options.allow_commands else "it only watches"
    return (
        f"{client.hello.vehicle}: {topics} ROS 2 topics under /{namespace} in domain {number}, for "
        f"{where}; {commands}; Ctrl-C ends it"
    )
