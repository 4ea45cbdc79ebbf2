"""MAVLink's gimbal protocol, version 2: a manager, and a device that is no MAVLink component.

Source: mavlink.io/en/services/gimbal_v2.html. Setpoints are angles of the gimbal relative to the
body; nothing keeps the camera level, and the flags say so.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.mavlink_gimbal import Gimbal
from workbench.extras.gateways.mavlink_messages import compass_heading, milliseconds, whole_number
from workbench.extras.gateways.running import SetParameters
from workbench.link import AsyncClient

GIMBAL_DEVICE_ID = 1
"""Number of a gimbal without a component of its own, 1 to 6."""
GIMBAL_STATUS_PERIOD_NS = 200_000_000
"""Simulated time between reports of the attitude [ns]."""
BROADCAST = 0
KEEP_CONTROL, TAKE_CONTROL, RELEASE_CONTROL = -1, -2, -3
"""Values of MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE beside the numbers of a component."""
NOBODY = (0, 0)
_CAPABILITIES = (
    mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_AXIS
    | mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_ROLL_FOLLOW,
    mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_AXIS
    | mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_PITCH_FOLLOW,
    mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_AXIS | mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_YAW_FOLLOW,
)
"""Capabilities of roll, pitch and yaw; a device has the same numbers as a manager."""


class GimbalProtocol:
    """The manager of a gimbal: reports it, and passes setpoints on.

    Args:
        client: of the link, open.
        gimbal: of the drone.
        set_values: sets setpoints.

    Attributes:
        commands: numbers of those that it executes.
        messages: names of those that it answers.
    """

    commands = (
        mavlink.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
        mavlink.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
    )
    messages = ("GIMBAL_MANAGER_SET_PITCHYAW", "GIMBAL_MANAGER_SET_ATTITUDE")

    def __init__(self, client: AsyncClient, gimbal: Gimbal, set_values: SetParameters) -> None:
        self._client, self._gimbal, self._set = client, gimbal, set_values
        self._owner = NOBODY  # system and component in control, 0 for none
        self._reported_ns = -GIMBAL_STATUS_PERIOD_NS

    def reports(self) -> list[Any]:
        """Return the status of manager and device if they are due, five times a second."""
        joints, position = self._client.latest("joint_states"), self._client.latest("position_data")
        if joints is None or position is None:
            return []
        if 0 <= joints.t_ns - self._reported_ns < GIMBAL_STATUS_PERIOD_NS:
            return []
        self._reported_ns = joints.t_ns
        names: Any = joints.definition.about["joints"]
        angles: Any = joints["position"]
        angles = angles if isinstance(angles, tuple) else (angles,)
        place: Any = position.values
        q = self._gimbal.attitude(
            place["roll"], place["pitch"], dict(zip(names, angles, strict=True))
        )
        unknown = (math.nan,) * 3
        device = mavlink.MAVLink_gimbal_device_attitude_status_message(
            BROADCAST,
            BROADCAST,
            self._milliseconds(),
            mavlink.GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME,
            q,
            *unknown,
            0,
            delta_yaw=compass_heading(place["yaw"]),
            delta_yaw_velocity=math.nan,
            gimbal_device_id=GIMBAL_DEVICE_ID,
        )
        return [self._manager_status(), device]

    def requested(self, number: int) -> list[Any]:
        """Return the messages that a station requests by their number, none for others."""
        match number:
            case mavlink.MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION:
                return [
                    mavlink.MAVLink_gimbal_manager_information_message(
                        self._milliseconds(),
                        self._capabilities(),
                        GIMBAL_DEVICE_ID,
                        *self._gimbal.limits(),
                    )
                ]
            case mavlink.MAVLINK_MSG_ID_GIMBAL_DEVICE_INFORMATION:
                return [
                    mavlink.MAVLink_gimbal_device_information_message(
                        self._milliseconds(),
                        b"",
                        self._client.hello.vehicle.encode("ascii", "replace")[:31],
                        b"",
                        0,
                        0,
                        0,
                        self._capabilities(),
                        0,
                        *self._gimbal.limits(),
                        gimbal_device_id=GIMBAL_DEVICE_ID,
                    )
                ]
            case mavlink.MAVLINK_MSG_ID_GIMBAL_MANAGER_STATUS:
                return [self._manager_status()]
            case mavlink.MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS:
                self._reported_ns = -GIMBAL_STATUS_PERIOD_NS
                return self.reports()
        return []

    async def execute(self, message: Any) -> None:
        """Execute one of its commands.

        Raises:
            WorkbenchError: if it is refused.
        """
        if message.command == mavlink.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE:
            self._configure(message)
            return
        angles = {1: math.radians(message.param1), 2: math.radians(message.param2)}
        # a COMMAND_INT has x, a whole number, where a COMMAND_LONG has param5
        in_whole = message.get_type() == "COMMAND_INT"
        flags = message.x if in_whole else whole_number(message.param5)
        await self._aim(message, angles, (message.param3, message.param4), flags)

    async def answer(self, message: Any) -> None:
        """Do what one of its messages says, which nobody acknowledges.

        Raises:
            WorkbenchError: if it is refused.
        """
        if message.get_type() == "GIMBAL_MANAGER_SET_PITCHYAW":
            rates = (message.pitch_rate, message.yaw_rate)
            await self._aim(message, {1: message.pitch, 2: message.yaw}, rates, message.flags)
            return
        known = all(map(math.isfinite, message.q)) and any(message.q)
        rates = (
            message.angular_velocity_x,
            message.angular_velocity_y,
            message.angular_velocity_z,
        )
        angles = self._gimbal.angles_of(tuple(message.q)) if known else {}
        await self._aim(message, angles, rates, message.flags)

    async def _aim(
        self,
        message: Any,
        angles: Mapping[int, float],
        rates: Sequence[float],
        flags: int,
    ) -> None:
        """Set angles by axis [rad]; NaN leaves one out."""
        sender = (message.get_srcSystem(), message.get_srcComponent())
        if self._owner not in (NOBODY, sender):
            raise WorkbenchError("another component controls the gimbal: take control of it first")
        if flags & mavlink.GIMBAL_MANAGER_FLAGS_RETRACT:
            raise WorkbenchError("the gimbal cannot be retracted")
        if flags & mavlink.GIMBAL_MANAGER_FLAGS_NEUTRAL:
            await self._set(self._gimbal.neutral())
            return
        if any(math.isfinite(rate) and rate != 0.0 for rate in rates):
            raise WorkbenchError("the gimbal takes angles, and no rates")
        in_earth = (
            mavlink.GIMBAL_MANAGER_FLAGS_YAW_LOCK | mavlink.GIMBAL_MANAGER_FLAGS_YAW_IN_EARTH_FRAME
        )
        if flags & in_earth and self._gimbal.find(2) and math.isfinite(angles.get(2, math.nan)):
            raise WorkbenchError("the gimbal takes yaw relative to the drone, not to north")
        setpoints = self._gimbal.setpoints(angles)
        if setpoints:
            await self._set(setpoints)

    def _configure(self, message: Any) -> None:
        """Note the component in control."""
        sender = (message.get_srcSystem(), message.get_srcComponent())
        wanted = whole_number(message.param1), whole_number(message.param2)
        if wanted[0] == TAKE_CONTROL:
            self._owner = sender
        elif wanted[0] == RELEASE_CONTROL:
            self._owner = NOBODY if self._owner == sender else self._owner
        elif wanted[0] != KEEP_CONTROL:
            self._owner = wanted

    def _manager_status(self) -> Any:
        return mavlink.MAVLink_gimbal_manager_status_message(
            self._milliseconds(),
            mavlink.GIMBAL_MANAGER_FLAGS_YAW_IN_VEHICLE_FRAME,
            GIMBAL_DEVICE_ID,
            *self._owner,
            0,
            0,
        )

    def _capabilities(self) -> int:
        axes = sum(_CAPABILITIES[each.axis] for each in self._gimbal.axes)
        return axes | mavlink.GIMBAL_MANAGER_CAP_FLAGS_HAS_NEUTRAL

    def _milliseconds(self) -> int:
        """Return the simulated time [ms]."""
        newest = self._client.latest("joint_states")
        return 0 if newest is None else milliseconds(newest.t_ns)
