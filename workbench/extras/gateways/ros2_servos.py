"""Servos of the drone, moved along the trajectories that ROS 2 programs send."""

import math
from collections.abc import Callable

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_orders import OrderExecutor
from workbench.extras.gateways.ros2_trajectory import (
    ServoTrajectory,
    TrajectoryOrder,
    servo_trajectory,
)
from workbench.link import AsyncClient

SETPOINT_PERIOD_S = 0.1
"""Simulated time between setpoints along a trajectory [s]."""


class ServoMover:
    """Moves servos along a trajectory; a newer one replaces it.

    Control is requested at its start, and kept as for a service.

    Args:
        client: of the link, open.
        executor: has control of the flight.
        say: shows the user a sentence.
    """

    def __init__(
        self, client: AsyncClient, executor: OrderExecutor, say: Callable[[str], None]
    ) -> None:
        self._client, self._executor, self._say = client, executor, say
        self._trajectory: ServoTrajectory | None = None
        self._set_at = -math.inf

    async def start(self, order: TrajectoryOrder) -> None:
        """Begin a trajectory, or say why not."""
        try:
            if not order.points:
                self._end("the joints hold their setpoints")
                return
            self._trajectory = None
            present = await self._client.parameters()
            rows = self._client.hello.parameters
            trajectory = servo_trajectory(order, rows, present, self._now())
            await self._executor.keep_control()
        except WorkbenchError as error:
            self._end(f"joint_trajectory: {error}")
            return
        self._trajectory, self._set_at = trajectory, -math.inf

    async def look(self) -> None:
        """Set the setpoints of now, if they are due."""
        trajectory = self._trajectory
        if trajectory is None:
            return
        try:
            now = self._now()
            ended = now >= trajectory.times[-1]
            if 0.0 <= now - self._set_at < SETPOINT_PERIOD_S and not ended:
                return
            self._set_at = now
            await self._executor.set_with_control(trajectory.at(now))
        except WorkbenchError as error:
            self._end(f"joint_trajectory has ended: {error}")
            return
        if ended:
            self._end("joint_trajectory is done")

    def _end(self, sentence: str) -> None:
        """End the trajectory, if there is one, and say why."""
        self._trajectory = None
        newest = self._client.latest("joint_states")
        if newest is not None:
            self._executor.end_keeping(newest.time)
        self._say(sentence)

    def _now(self) -> float:
        """Return the simulated time [s]."""
        newest = self._client.latest("joint_states")
        if newest is None:
            raise WorkbenchError("the joints of the drone are not known yet")
        return newest.time
