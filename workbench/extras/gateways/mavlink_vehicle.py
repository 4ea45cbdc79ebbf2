"""A flight as a MAVLink vehicle.

Source: mavlink.io/en/services, for commands, modes, parameters, files and missions.
"""

import asyncio
import math
from collections.abc import Callable, Mapping
from typing import Any

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20 import development

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways import mavlink_messages as making
from workbench.extras.gateways.ground_station import GroundStation
from workbench.extras.gateways.mavlink_effect import NoEffectError, wait_for_effect
from workbench.extras.gateways.mavlink_files import (
    GENERAL_FILE,
    METADATA_MESSAGE_ID,
    ComponentMetadata,
    file_crc,
    file_replies,
    metadata_files,
)
from workbench.extras.gateways.mavlink_flight import MissionFlight
from workbench.extras.gateways.mavlink_gimbal import Gimbal
from workbench.extras.gateways.mavlink_gimbal_protocol import GimbalProtocol
from workbench.extras.gateways.mavlink_mission import (
    CHANGING_MESSAGES,
    Mission,
    MissionError,
    home_of,
)
from workbench.extras.gateways.mavlink_modes import (
    MISSION_MODE,
    current_mode_message,
    mode_messages,
    mode_operation,
    standard_operation,
)
from workbench.extras.gateways.mavlink_parameters import ParameterProtocol
from workbench.extras.gateways.running import rotors_stopped, set_parameters
from workbench.link import AsyncClient
from workbench.link.control import AsyncControl
from workbench.link.message_json import TAKE_OFF_HEIGHT_M
from workbench.link.topics import PREFIX

HEARTBEAT_PERIOD_S = 1.0
"""Period of heartbeats [s]."""
STATION_TIMEOUT_S = 5.0
"""Silence after which a station counts as gone [s]."""
FORCED_DISARM_CODE = 21196.0
"""The code to stop rotors in flight (MAV_CMD_COMPONENT_ARM_DISARM)."""


class MavlinkVehicle:
    """The vehicle seen by a ground station: reports the flight, and handles requests.

    Args:
        client: of the link, open.
        station: the ground station.
        ids: MAVLink id of each parameter, by its name.
        allow_commands: whether the station may set parameters and fly.
        say: shows the user a sentence.
        gimbal: of the drone, if it has one.
    """

    def __init__(
        self,
        client: AsyncClient,
        station: GroundStation,
        ids: dict[str, str],
        allow_commands: bool,
        say: Callable[[str], None],
        gimbal: Gimbal | None = None,
    ) -> None:
        self._client, self._station, self._say = client, station, say
        self._allow = allow_commands
        self._control: AsyncControl | None = None
        self._carried_out = -math.inf  # when, in simulated time [s]; infinite until it is
        self._texts = 0
        self._parameters = ParameterProtocol(client, station, ids, self._set)
        self._metadata = metadata_files(client.hello.parameters, ids)
        self._mission = Mission(home_of(client))
        self._flying: asyncio.Task[None] | None = None
        self._gimbal = GimbalProtocol(client, gimbal, self._aim) if gimbal else None

    async def publish(self) -> None:
        """Pass samples on as they come."""
        async for sample in self._client:
            match sample.topic.removeprefix(PREFIX):
                case "position_data" if velocity := self._client.latest("velocity_data"):
                    self._station.send(
                        *making.motion_messages(sample.t_ns, sample.values, velocity.values)
                    )
                case "gps" if position := self._client.latest("position_data"):
                    self._station.send(
                        *making.position_messages(sample.t_ns, sample.values, position.values)
                    )
                case "joint_states" if self._gimbal:
                    self._station.send(*self._gimbal.reports())
                case "events":
                    self._tell(*making.event_text(sample.values))
                case "parameters":
                    self._parameters.send(str(sample["name"]), sample["value"])

    async def beat(self) -> None:
        """Send the heartbeat and the status of the vehicle once a second."""
        while True:
            state, switch = self._client.latest("drone_state"), self._client.latest("on_off_state")
            on = switch is not None and bool(switch["on"])
            battery = self._client.latest("battery")
            self._station.send(
                *making.status_messages(
                    state.values if state else None,
                    on,
                    self._mode(),
                    battery.values if battery else None,
                ),
                current_mode_message(self._mode()),
                self._mission.status(self._flying is not None),
                *self._mission.request_next(),  # again, should one be lost
            )
            await self._look(not rotors_stopped(self._client, self._carried_out))
            await asyncio.sleep(HEARTBEAT_PERIOD_S)

    async def execute(self) -> None:
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
        kind = message.get_type()
        if kind in ("COMMAND_LONG", "COMMAND_INT"):
            await self._command(message)
        elif kind == "SET_MODE":
            await self._set_mode(mode_operation(message.custom_mode))
        elif kind == "FILE_TRANSFER_PROTOCOL":
            self._send_files(message)
        elif self._gimbal and kind in self._gimbal.messages:
            self._check_allowed()
            await self._gimbal.answer(message)
        elif kind.startswith("MISSION_"):
            await self._answer_mission(message)
        else:
            await self._parameters.answer(message)

    def _send_files(self, message: Any) -> None:
        for reply in file_replies(self._metadata, bytes(message.payload)):
            self._station.send(
                mavlink.MAVLink_file_transfer_protocol_message(
                    0, message.get_srcSystem(), message.get_srcComponent(), list(reply)
                )
            )

    async def _answer_mission(self, message: Any) -> None:
        """Answer a message of the mission protocol."""
        changes = message.get_type() in CHANGING_MESSAGES
        if changes and not self._allow:
            self._station.send(self._mission.acknowledgement(mavlink.MAV_MISSION_DENIED, message))
            self._check_allowed()
        if message.get_type() == "MISSION_SET_CURRENT":
            await self._start_mission(message.seq, flies=self._flying is not None)
            return
        if changes:
            self._stop_mission()
        try:
            self._station.send(*self._mission.answer(message))
        except MissionError as error:
            self._station.send(self._mission.acknowledgement(error.result, message))
            raise

    async def _start_mission(self, number: int, flies: bool = True) -> None:
        """Fly the mission from a step on, or only set the step.

        Raises:
            WorkbenchError: if there is no such step, or control is refused.
        """
        self._check_allowed()
        if number >= len(self._mission.steps):
            raise WorkbenchError(
                f"there is no step {number} of a mission of {len(self._mission.steps)}: upload one"
            )
        self._stop_mission()
        self._mission.current, self._mission.complete = number, False
        if flies:
            control = await self._controls()
            flight = MissionFlight(
                self._client, control, self._mission, self._carry_out, self._note_reached
            )
            self._carried_out = math.inf  # control is kept while the mission is flown
            self._flying = asyncio.create_task(self._fly(flight), name="mission")

    async def _fly(self, flight: MissionFlight) -> None:
        """Fly a mission, and report its end."""
        try:
            await flight.fly()
            self._tell("the mission is done", mavlink.MAV_SEVERITY_INFO)
        except WorkbenchError as error:
            self._tell(f"the mission has ended: {error}")
        finally:
            if self._flying in (None, asyncio.current_task()):  # or another mission has begun
                self._flying = None
                state = self._client.latest("drone_state")
                self._carried_out = state.time if state is not None else -math.inf

    def _note_reached(self, number: int) -> None:
        self._station.send(mavlink.MAVLink_mission_item_reached_message(number))

    def _stop_mission(self) -> None:
        if self._flying is not None:
            self._flying.cancel()
            self._flying = None

    async def _set(self, name: str, value: float) -> None:
        """Set a parameter."""
        self._check_allowed()
        await set_parameters(self._client, self._control, {name: value})

    async def _aim(self, setpoints: Mapping[str, float]) -> None:
        """Set setpoints of the gimbal; control is kept as for an operation."""
        await (await self._controls()).set(**setpoints)
        state = self._client.latest("drone_state")
        if state is not None:
            self._carried_out = max(self._carried_out, state.time)

    async def _command(self, message: Any) -> None:
        """Execute a command, and acknowledge it once it has an effect."""
        try:
            known = await self._obey(message)
            result = mavlink.MAV_RESULT_ACCEPTED if known else mavlink.MAV_RESULT_UNSUPPORTED
        except NoEffectError as error:
            self._tell(str(error))
            result = mavlink.MAV_RESULT_FAILED
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
        match message.command:
            case mavlink.MAV_CMD_REQUEST_MESSAGE:
                return self._send_requested(
                    making.whole_number(message.param1), making.whole_number(message.param2)
                )
            case mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES:
                self._station.send(making.version_message())
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM if message.param1 == 1.0:
                await self._order("arm")
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                state = self._client.latest("drone_state")
                flies = state is not None and state["mode"] not in making.GROUND_MODES
                if flies and message.param2 != FORCED_DISARM_CODE:
                    raise WorkbenchError("the drone flies: land first, or force the rotors to stop")
                await self._order("stop")
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                height = float(message.z if message.get_type() == "COMMAND_INT" else message.param7)
                # NaN is the drone's own
                await self._order(
                    "take_off", height if math.isfinite(height) else TAKE_OFF_HEIGHT_M
                )
            case mavlink.MAV_CMD_NAV_LAND:
                await self._order("land")
            case mavlink.MAV_CMD_DO_PAUSE_CONTINUE if message.param1 == 0.0:
                await self._order("hold")
            case mavlink.MAV_CMD_DO_PAUSE_CONTINUE:
                await self._start_mission(self._mission.next_start)
            case mavlink.MAV_CMD_MISSION_START:
                await self._start_mission(making.whole_number(message.param1))
            case mavlink.MAV_CMD_DO_SET_MODE:
                number = making.whole_number(message.param2)
                return await self._set_mode(mode_operation(number, message.param3))
            case mavlink.MAV_CMD_DO_SET_STANDARD_MODE:
                return await self._set_mode(standard_operation(making.whole_number(message.param1)))
            case command if self._gimbal and command in self._gimbal.commands:
                self._check_allowed()
                await self._gimbal.execute(message)
            case _:
                return False
        return True

    async def _set_mode(self, operation: str) -> bool:
        """Do the operation of a mode; return whether a station can set the mode."""
        if operation == "mission":
            await self._start_mission(self._mission.next_start)
        elif operation:
            await self._order(operation)
        return bool(operation)

    def _send_requested(self, number: int, which: int) -> bool:
        """Send a message that a station requests; return whether there is such."""
        messages: list[Any] = []
        match number:
            case mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
                messages = [making.version_message()]
            case development.MAVLINK_MSG_ID_AVAILABLE_MODES:
                messages = mode_messages(which)
            case development.MAVLINK_MSG_ID_CURRENT_MODE:
                messages = [current_mode_message(self._mode())]
            case mavlink.MAVLINK_MSG_ID_HOME_POSITION:
                messages = making.home_messages(self._mission.home)
            case _ if number == METADATA_MESSAGE_ID:
                crc = file_crc(self._metadata[GENERAL_FILE])
                messages = [ComponentMetadata(0, crc, f"mftp:///{GENERAL_FILE}")]
            case _ if self._gimbal:
                messages = self._gimbal.requested(number)
        self._station.send(*messages)
        return bool(messages)

    def _mode(self) -> int:
        """Return the custom mode."""
        state: Any = self._client.latest("drone_state")
        if self._flying is not None:
            return MISSION_MODE
        return int(state["mode"]) if state is not None else making.OFF_MODE

    async def _order(self, what: str, height: float = TAKE_OFF_HEIGHT_M) -> None:
        """Do an operation of the station, which ends a mission."""
        self._check_allowed()
        self._stop_mission()
        await self._carry_out(what, height)

    def _check_allowed(self) -> None:
        if not self._allow:
            raise WorkbenchError("this gateway only watches: start it with --allow-commands")

    async def _carry_out(self, what: str, height: float = TAKE_OFF_HEIGHT_M) -> None:
        """Let the flight do an operation, and wait for its effect; control is kept meanwhile.

        Raises:
            WorkbenchError: if it is refused.
            NoEffectError: if it has no effect.
        """
        carried_out = -math.inf
        self._carried_out = math.inf
        try:
            carried_out = await (await self._controls()).request(what, height)
            await wait_for_effect(self._client, what, carried_out)
        finally:
            self._carried_out = math.inf if self._flying else carried_out

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
        elif silent > STATION_TIMEOUT_S:
            self._tell(f"the ground station was silent for {silent:.0f} s: the drone holds")
            await self._release()
        elif not in_use:
            await self._release()

    async def _release(self) -> None:
        self._stop_mission()
        control, self._control = self._control, None
        if control is not None:
            await control.__aexit__()

    def _tell(self, sentence: str, severity: int | None = None) -> None:
        """Send a sentence to the station, and to the user unless it came from the drone."""
        self._texts += 1
        if severity is None:
            self._say(sentence)
            severity = making.MAVLINK_SEVERITIES[1]
        self._station.send(*making.text_messages(self._texts, severity, sentence))
