"""Fly a mission's steps by velocities, as any client of the link could."""

import asyncio
import math
from collections.abc import Awaitable, Callable
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.mavlink_messages import HOLD_MODE
from workbench.extras.gateways.mavlink_mission import Mission, MissionPlace, MissionStep
from workbench.link import AsyncClient
from workbench.link.control import AsyncControl
from workbench.link.message_json import TAKE_OFF_HEIGHT_M

MISSION_PERIOD_S = 0.05
"""Period between commands [s]."""
COMMAND_HOLD_S = 0.5
"""Time for which a command is repeated, should the gateway stall [s]."""
APPROACH_GAIN = 1.0
"""Velocity per distance to a place [1/s]."""
REACHED_M = 0.5
"""Default distance at which a place counts as reached [m]."""
MISSION_SPEED_SHARE = 0.5
"""Share of the limit of speed that a mission flies with, unless it says otherwise."""
Operate = Callable[[str, float], Awaitable[None]]
"""Does a flight operation, with a height [m], and returns once it has an effect."""


class MissionFlight:
    """Flies the steps of a mission from the current one on.

    Args:
        client: of the link, open.
        control: the controls, which repeat commands.
        mission: steps, and the current one.
        operate: does a flight operation.
        reached: called with the number of each step that is done.
    """

    def __init__(
        self,
        client: AsyncClient,
        control: AsyncControl,
        mission: Mission,
        operate: Operate,
        reached: Callable[[int], None],
    ) -> None:
        self._client, self._control, self._mission = client, control, mission
        self._operate, self._reached = operate, reached
        self._speed = MISSION_SPEED_SHARE * client.hello.limits.level_speed

    async def fly(self) -> None:
        """Fly to the end of the mission.

        Raises:
            WorkbenchError: if a step is refused, or control is lost.
        """
        steps = self._mission.steps
        while steps:
            number = self._mission.current
            await self._fly_step(steps[number])
            self._reached(number)
            if number + 1 == len(steps):
                break  # a station sees that the last one was reached
            self._mission.current = number + 1
        self._mission.complete = True

    async def _fly_step(self, step: MissionStep) -> None:
        self._speed = step.speed or self._speed
        place = step.place
        match step.command:
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                assert place is not None
                await self._operate("take_off", place.z)
                await self._wait_until(lambda: self._mode() == HOLD_MODE)
                await self._go_to(place, step.radius)
            case mavlink.MAV_CMD_NAV_LAND | mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH:
                x, y = (0.0, 0.0) if place is None else place[:2]
                await self._go_to(MissionPlace(x, y, self._position()[2]), step.radius)
                await self._operate("land", TAKE_OFF_HEIGHT_M)
                await self._wait_until(lambda: self._mode() == 0)
            case _ if place is not None:
                await self._go_to(place, step.radius)
        if step.wait:
            ends = self._time() + step.wait
            await self._wait_until(lambda: self._time() >= ends)

    async def _go_to(self, place: MissionPlace, radius: float) -> None:
        """Fly to a place in W, and stop there."""
        start = self._position()
        goal = [here if to is None else to for here, to in zip(start, place, strict=True)]
        limits = self._client.hello.limits
        while True:
            way = [to - here for to, here in zip(goal, self._position(), strict=True)]
            if math.hypot(*way) <= (radius or REACHED_M):
                break
            level = APPROACH_GAIN * math.hypot(way[0], way[1])
            share = min(1.0, min(self._speed, limits.level_speed) / max(level, 1e-9))
            up = max(-limits.climb_rate, min(limits.climb_rate, APPROACH_GAIN * way[2]))
            self._control.velocity(
                APPROACH_GAIN * share * way[0],
                APPROACH_GAIN * share * way[1],
                up,
                hold=COMMAND_HOLD_S,
            )
            await asyncio.sleep(MISSION_PERIOD_S)
        self._control.velocity(0.0, 0.0, 0.0)

    async def _wait_until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            self._control.check()
            await asyncio.sleep(MISSION_PERIOD_S)

    def _newest(self, topic: str) -> Any:
        sample = self._client.latest(topic)
        if sample is None:
            raise WorkbenchError(f"the mission needs {topic}, which is not known yet")
        return sample

    def _position(self) -> tuple[float, float, float]:
        sample = self._newest("position_data")
        return sample["x"], sample["y"], sample["z"]

    def _time(self) -> float:
        return float(self._newest("position_data").time)

    def _mode(self) -> int:
        return int(self._newest("drone_state")["mode"])
