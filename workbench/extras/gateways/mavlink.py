"""The gateway to MAVLink: a client of the link that appears as a vehicle to a ground station."""

import asyncio
import socket
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import is_servo_parameter
from workbench.extras.gateways.ground_station import GroundStation
from workbench.extras.gateways.running import (
    LinkOptions,
    all_of,
    report_connection,
    run_until_interrupted,
    throttled,
)
from workbench.link.address import Address, is_loopback

if TYPE_CHECKING:
    from workbench.extras.gateways.mavlink_gimbal import Gimbal
    from workbench.link import AsyncClient

MAVLINK_PORT = 14550
"""Port at which ground stations listen."""
MAVLINK_SAMPLE_RATE_HZ = 20.0
"""Default rate of samples of each topic [1/s]."""


def check_stations(stations: Sequence[Address], link: LinkOptions) -> None:
    """Check that not anybody in the network can fly.

    Raises:
        WorkbenchError: if commands would be accepted from another computer.
    """
    away = [to for to in stations if not is_loopback(to.host)]
    if link.flies and away:
        raise WorkbenchError(
            f"commands are taken from this computer only, as MAVLink has no login, and "
            f"{away[0].host} is another one: run this gateway on the computer of the ground "
            "station; it reaches a server elsewhere with --token-file and --tls"
        )


def run_mavlink(
    link: LinkOptions,
    stations: Sequence[Address],
    say: Callable[[str], None] = print,
    ready: Callable[[str, dict[str, str]], None] | None = None,
) -> None:
    """Pass a served flight to ground stations, and let them set gains and fly, until Ctrl-C.

    Args:
        link: connection to the server; by default 20 samples of each topic per second.
        stations: addresses of the ground stations.
        say: shows the user a sentence.
        ready: called with the name of the vehicle, and the MAVLink id of each parameter by name.

    Raises:
        WorkbenchError: if the extra is not installed, an option is invalid, or the server rejects
            the client or is gone.
    """
    check_stations(stations, link)
    if find_spec("pymavlink") is None:
        raise WorkbenchError("MAVLink needs the package pymavlink: `pip install pymavlink`")
    run_until_interrupted(serve_mavlink(link, stations, throttled(say), ready))


async def serve_mavlink(
    link: LinkOptions,
    stations: Sequence[Address],
    say: Callable[[str], None],
    ready: Callable[[str, dict[str, str]], None] | None = None,
) -> None:
    """Do the work of `run_mavlink` until it is cancelled."""
    from workbench.extras.gateways.mavlink_messages import parameter_ids
    from workbench.extras.gateways.mavlink_vehicle import MavlinkVehicle

    async with replace(link, rate=link.rate or MAVLINK_SAMPLE_RATE_HZ).async_client() as client:
        ids = parameter_ids(await client.parameters())
        loop = asyncio.get_running_loop()
        station = GroundStation(say)
        try:
            for to in stations:
                try:
                    await loop.create_datagram_endpoint(
                        lambda: station, remote_addr=(to.host, to.port)
                    )
                except socket.gaierror:
                    raise WorkbenchError(
                        f"--to {to}: the host is unknown: check its name, or write its address"
                    ) from None
                except OSError as error:
                    raise WorkbenchError(f"--to {to}: {error.strerror or error}") from error
            gimbal = await _gimbal(client)
            vehicle = MavlinkVehicle(client, station, ids, link.flies, say, gimbal)
            commands = "they may set parameters and fly" if link.flies else "they only watch"
            places = " and ".join(map(str, stations))
            say(f"{client.hello.vehicle}: ground stations at {places}, {commands}; Ctrl-C ends it")
            if ready is not None:
                ready(client.hello.vehicle, ids)
            works = (
                vehicle.publish(),
                vehicle.beat(),
                vehicle.execute(),
                report_connection(client, say),
            )
            await all_of([asyncio.create_task(work) for work in works])
        finally:
            station.close()


async def _gimbal(client: "AsyncClient") -> "Gimbal | None":
    """Return the gimbal of the drone; an older server has no description that shows one."""
    from workbench.extras.gateways.mavlink_gimbal import gimbal_of

    rows = client.hello.parameters
    if not any(is_servo_parameter(row.name) for row in rows):
        return None
    try:
        return gimbal_of(await client.description(), rows)
    except WorkbenchError:
        return None
