"""The gateway to MAVLink: a client of the link that appears as a vehicle to a ground station."""

import asyncio
import contextlib
import math
from collections.abc import Awaitable, Callable
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.gateways.running import (
    LinkOptions,
    Sayings,
    all_of,
    run_until_interrupted,
    tell_trouble,
)
from workbench.link.address import Address, is_loopback
from workbench.link.control import AsyncControl
from workbench.link.topics import PREFIX

if TYPE_CHECKING:
    from workbench.link import AsyncClient

PORT = 14550
"""Port at which ground stations listen."""
RATE = 20.0
"""Default rate of samples of each topic [1/s]."""
BEAT = 1.0
"""Period of heartbeats [s]."""
GONE = 5.0
"""Silence after which a station counts as gone [s]."""
IN_A_ROW = 20
"""Number of parameters sent before other work gets a turn."""
SETTLED = 1.0
"""Simulated time after an operation from which the state of the rotors shows its effect [s]."""
FORCED = 21196.0
"""The code to stop rotors in flight (MAV_CMD_COMPONENT_ARM_DISARM)."""


def check_station(to: Address, link: LinkOptions) -> None:
    """Check that not anybody in the network can fly.

    Raises:
        WorkbenchError: if commands would be accepted from another computer.
    """
    if link.flies and not is_loopback(to.host):
        raise WorkbenchError(
            f"commands are taken from this computer only, as MAVLink has no login, and "
            f"{to.host} is another one: run this gateway on the computer of the ground "
            "station; it reaches a server elsewhere with --token-file"
        )


def run_mavlink(
    link: LinkOptions,
    to: Address,
    say: Callable[[str], None] = print,
    ready: Callable[[str, dict[str, str]], None] | None = None,
) -> None:
    """Pass a served flight to a ground station, and let it set gains and fly, until Ctrl-C.

    Args:
        link: connection to the server; by default 20 samples of each topic per second.
        to: address of the ground station.
        say: shows the user a sentence.
        ready: called with the name of the vehicle, and the MAVLink id of each parameter by name.

    Raises:
        WorkbenchError: if the extra is not installed, an option is invalid, or the server rejects
            the client or is gone.
    """
    check_station(to, link)
    if find_spec("pymavlink") is None:
        raise WorkbenchError("MAVLink needs the package pymavlink: `pip install pymavlink`")
    run_until_interrupted(serve_mavlink(link, to, Sayings(say), ready))


async def serve_mavlink(
    link: LinkOptions,
    to: Address,
    say: Callable[[str], None],
    ready: Callable[[str, dict[str, str]], None] | None = None,
) -> None:
    """Do the work of `run_mavlink` until it is cancelled."""
    from workbench.gateways.mavlink_messages import parameter_ids

    async with replace(link, rate=link.rate or RATE).async_client() as client:
        ids = parameter_ids(await client.parameters())
        loop = asyncio.get_running_loop()
        try:
            transport, station = await loop.create_datagram_endpoint(
                lambda: Station(say), remote_addr=(to.host, to.port)
            )
        except OSError as error:
            raise WorkbenchError(f"--to {to}: {error.strerror or error}") from error
        vehicle = MavlinkVehicle(client, station, ids, link.flies, say)
        commands = "it may set parameters and fly" if link.flies else "it only watches"
        say(f"{client.hello.vehicle}: a ground station at {to}, {commands}; Ctrl-C ends it")
        if ready is not None:
            ready(client.hello.vehicle, ids)
        try:
            works = (vehicle.publish(), vehicle.beat(), vehicle.obey(), tell_trouble(client, say))
            await all_of([asyncio.create_task(work) for work in works])
        finally:
            transport.close()


class Station(asyncio.DatagramProtocol):
    """The ground station: messages to it and from it, by UDP.

    Args:
        say: shows the user a sentence.

    Attributes:
        heard: messages from it that are not read yet.
        heard_at: time of its last message, by the clock of the loop [s].
    """

    MOST_WAITING = 1000
    """Largest number of waiting messages; more are dropped."""

    def __init__(self, say: Callable[[str], None]) -> None:
        from pymavlink.dialects.v20 import common as mavlink

        from workbench.gateways.mavlink_messages import COMPONENT, SYSTEM

        self.heard: asyncio.Queue[Any] = asyncio.Queue(self.MOST_WAITING)
        self.heard_at = -math.inf
        self._say = say
        self._mav = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)
        self._transport: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: Any) -> None:
        """Keep the transport."""
        self._transport = transport

    def send(self, *messages: Any) -> None:
        """Send messages; they are lost if nobody listens."""
        if self._transport is not None:
            for message in messages:
                self._transport.sendto(message.pack(self._mav))
                self._mav.seq = (self._mav.seq + 1) % 256

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Keep messages for this vehicle; a datagram has complete messages."""
        from pymavlink.dialects.v20 import common as mavlink

        from workbench.gateways.mavlink_messages import SYSTEM

        self.heard_at = asyncio.get_running_loop().time()
        parser = mavlink.MAVLink(None)
        parser.robust_parsing = True
        for message in parser.parse_buffer(data) or ():
            target = getattr(message, "target_system", SYSTEM)
            if message.get_type() != "BAD_DATA" and target in (0, SYSTEM):
                with contextlib.suppress(asyncio.QueueFull):
                    self.heard.put_nowait(message)

    def error_received(self, exc: Exception) -> None:
        """Report that nobody listens."""
        self._say(f"no ground station listens yet ({exc}): start it, or name another --to")


class MavlinkVehicle:
    """The vehicle seen by a ground station: reports the flight, and handles requests.

    Args:
        client: of the link, open.
        station: the ground station.
        ids: MAVLink id of each parameter, by its name.
        allow_commands: whether the station may set parameters and fly.
        say: shows the user a sentence.
    """

    def __init__(
        self,
        client: "AsyncClient",
        station: Station,
        ids: dict[str, str],
        allow_commands: bool,
        say: Callable[[str], None],
    ) -> None:
        from workbench.gateways import mavlink_messages

        self._client, self._station, self._say = client, station, say
        self._names, self._ids = list(ids), ids
        self._named = {short: name for name, short in ids.items()}
        self._allow = allow_commands
        self._make = mavlink_messages
        self._control: AsyncControl | None = None
        self._carried_out = -math.inf  # when, in simulated time [s]; infinite until it is
        self._texts = 0

    async def publish(self) -> None:
        """Pass samples on as they come."""
        async for sample in self._client:
            match sample.topic.removeprefix(PREFIX):
                case "position_data" if velocity := self._client.latest("velocity_data"):
                    self._station.send(
                        *self._make.motion_messages(sample.t_ns, sample.values, velocity.values)
                    )
                case "gps" if position := self._client.latest("position_data"):
                    self._station.send(
                        *self._make.place_messages(sample.t_ns, sample.values, position.values)
                    )
                case "events":
                    self._tell(*self._make.event_text(sample.values))
                case "parameters" if (name := str(sample["name"])) in self._ids:
                    self._send_value(name, sample["value"])

    async def beat(self) -> None:
        """Send the heartbeat and the status of the vehicle once a second."""
        while True:
            state, switch = self._client.latest("drone_state"), self._client.latest("on_off_state")
            on = switch is not None and bool(switch["on"])
            self._station.send(*self._make.status_messages(state.values if state else None, on))
            # The state of before an operation says nothing of what it does.
            since = switch.time - self._carried_out if switch is not None else 0.0
            await self._look(on or since < SETTLED)
            await asyncio.sleep(BEAT)

    async def obey(self) -> None:
        """Handle requests of the station, in order."""
        try:
            while True:
                message = await self._station.heard.get()
                try:
                    await self._answer(message)
                except WorkbenchError as error:
                    self._tell(str(error))
        finally:
            await self._release()

    async def _answer(self, message: Any) -> None:
        from pymavlink.dialects.v20 import common as mavlink

        match message.get_type():
            case "PARAM_REQUEST_LIST":
                values = await self._client.parameters()
                for place, name in enumerate(self._names, start=1):
                    self._send_value(name, values[name])
                    if place % IN_A_ROW == 0:
                        await asyncio.sleep(0)
            case "PARAM_REQUEST_READ":
                name = self._asked(message)
                self._send_value(name, (await self._client.parameters(name))[name])
            case "PARAM_SET":
                await self._set(self._named_by(message.param_id), message.param_value)
            case "COMMAND_LONG" | "COMMAND_INT":
                await self._command(message)
            case "MISSION_REQUEST_LIST":
                self._station.send(
                    mavlink.MAVLink_mission_count_message(
                        message.get_srcSystem(),
                        message.get_srcComponent(),
                        0,
                        message.mission_type,
                    )
                )

    def _asked(self, message: Any) -> str:
        """Return the name of the requested parameter."""
        if message.param_index < 0:
            return self._named_by(message.param_id)
        if message.param_index >= len(self._names):
            raise WorkbenchError(
                f"there is no parameter {message.param_index} of 0 to {len(self._names) - 1}"
            )
        return self._names[message.param_index]

    def _named_by(self, short: str) -> str:
        name = self._named.get(short)
        if name is None:
            raise WorkbenchError(f"there is no parameter {short!r} here")
        return name

    async def _set(self, name: str, value: float) -> None:
        """Set a parameter, and report its present value, even if that failed."""
        try:
            self._check_allowed()
            if not math.isfinite(value):
                raise WorkbenchError(f"{name} = {value} is not a number: nothing was set")
            # a station sends 32 bits: 0.8 must not become 0.800000011920929
            wanted = {name: float(str(np.float32(value)))}
            if self._control is not None:
                await self._control.set(**wanted)
            else:
                async with self._client.control() as control:
                    await control.set(**wanted)
        finally:
            self._send_value(name, (await self._client.parameters(name))[name])

    def _send_value(self, name: str, value: Any) -> None:
        from pymavlink.dialects.v20 import common as mavlink

        self._station.send(
            mavlink.MAVLink_param_value_message(
                self._ids[name].encode(),
                value,
                mavlink.MAV_PARAM_TYPE_REAL32,
                len(self._names),
                self._names.index(name),
            )
        )

    async def _command(self, message: Any) -> None:
        """Execute a command, and acknowledge it."""
        from pymavlink.dialects.v20 import common as mavlink

        try:
            known = await self._obey(message)
            result = mavlink.MAV_RESULT_ACCEPTED if known else mavlink.MAV_RESULT_UNSUPPORTED
        except WorkbenchError as error:
            self._tell(str(error))
            result = mavlink.MAV_RESULT_DENIED
        self._station.send(
            mavlink.MAVLink_command_ack_message(
                message.command,
                result,
                target_system=message.get_srcSystem(),
                target_component=message.get_srcComponent(),
            )
        )

    async def _obey(self, message: Any) -> bool:
        """Execute a command, and return whether it is known."""
        from pymavlink.dialects.v20 import common as mavlink

        match message.command:
            case mavlink.MAV_CMD_REQUEST_MESSAGE | mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
                version = mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION
                if message.command == mavlink.MAV_CMD_REQUEST_MESSAGE and message.param1 != version:
                    return False
                self._send_version()
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM if message.param1 == 1.0:
                await self._carry_out(AsyncControl.arm)
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                state = self._client.latest("drone_state")
                flies = state is not None and state["mode"] not in self._make.ON_THE_GROUND
                if flies and message.param2 != FORCED:
                    raise WorkbenchError("the drone flies: land first, or force the rotors to stop")
                await self._carry_out(AsyncControl.stop)
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                height = float(message.z if message.get_type() == "COMMAND_INT" else message.param7)
                await self._carry_out(lambda control: control.take_off(height))
            case mavlink.MAV_CMD_NAV_LAND:
                await self._carry_out(AsyncControl.land)
            case mavlink.MAV_CMD_DO_PAUSE_CONTINUE if message.param1 == 0.0:
                await self._carry_out(AsyncControl.hold)
            case _:
                return False
        return True

    def _send_version(self) -> None:
        from pymavlink.dialects.v20 import common as mavlink

        able = (
            mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
            | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST
        )
        none = [0] * 8
        self._station.send(
            mavlink.MAVLink_autopilot_version_message(able, 0, 0, 0, 0, none, none, none, 0, 0, 0)
        )

    def _check_allowed(self) -> None:
        if not self._allow:
            raise WorkbenchError("this gateway only watches: start it with --allow-commands")

    async def _carry_out(self, operation: Callable[[AsyncControl], Awaitable[float]]) -> None:
        """Let the flight do an operation; control is kept meanwhile, and until it shows."""
        carried_out = -math.inf
        self._carried_out = math.inf
        try:
            carried_out = await operation(await self._controls())
        finally:
            self._carried_out = carried_out

    async def _controls(self) -> AsyncControl:
        """Return the controls; they are kept until the drone has landed or the station is gone."""
        self._check_allowed()
        if self._control is not None and self._control.lost:
            await self._release()
        if self._control is None:
            control = self._client.control()
            await control.__aenter__()
            self._control = control
            self._say("control was granted: the ground station flies")
        return self._control

    async def _look(self, in_use: bool) -> None:
        """Release control when it is no longer needed, as the rotors stand still."""
        control = self._control
        if control is None:
            return
        silent = asyncio.get_running_loop().time() - self._station.heard_at
        if control.lost:
            self._tell(f"control was lost: {control.lost}")
            await self._release()
        elif silent > GONE:
            self._tell(f"the ground station was silent for {silent:.0f} s: the drone holds")
            await self._release()
        elif not in_use:
            await self._release()

    async def _release(self) -> None:
        control, self._control = self._control, None
        if control is not None:
            await control.__aexit__()

    def _tell(self, sentence: str, severity: int | None = None) -> None:
        """Send a sentence to the station, and to the user unless it came from the drone."""
        self._texts += 1
        if severity is None:
            self._say(sentence)
            severity = self._make.SEVERITIES[1]
        self._station.send(*self._make.text_messages(self._texts, severity, sentence))
