"""Orders from ROS 2 on their way to the drone: one publisher at a time, under the link's lease."""

import asyncio
import math
from collections.abc import Callable

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros2_orders import Operation, Order, Unclear, Velocity
from workbench.link import AsyncClient
from workbench.link.control import AsyncDirectControl
from workbench.link.messages import TAKE_OFF_HEIGHT

ASK_AGAIN = 1.0
"""After a refusal, a velocity does not ask for control sooner [s]."""
OLDEST = 0.5
"""What may have waited longer is not begun any more [s]."""
ENDING = ("land", "stop")
"""Operations that end a flight: late is better than never."""


class Commanding:
    """Asks for control when an order comes, passes orders on, and says what is refused.

    The first program that sends a velocity of zero has the drone until it is silent and control
    is lost with that: nobody takes over with a stick pushed, and nothing resumes by itself.
    Flight operations are taken from any, so that one may land what another flies.

    Args:
        client: of the link, open.
        say: tells the user a sentence.
    """

    def __init__(self, client: AsyncClient, say: Callable[[str], None]) -> None:
        self._client = client
        self._say = say
        self._control: AsyncDirectControl | None = None
        self._holder: int | None = None
        self._refused = -math.inf

    async def obey(self, order: Order, since: float) -> None:
        """Carry an order out, or say why not.

        Args:
            order: what is to be done.
            since: it has come after this time of the loop's clock [s].
        """
        if isinstance(order, Unclear):
            self._say(order.said)
            return
        try:
            await self.look()
            if self._is_late(order, since) or not self._may(order):
                return
            control = self._control or await self._ask()
            if self._is_late(order, since):  # asking took its time
                return
            if isinstance(order, Velocity):
                self._holder = order.publisher
            await self._carry_out(order, control)
        except WorkbenchError as error:
            self._say(str(error))

    async def look(self) -> None:
        """Notice that control was lost."""
        if self._control is not None and self._control.lost:
            self._say(f"control was lost: {self._control.lost}; to go on, begin with zero")
            await self.release()

    async def release(self) -> None:
        """Give control back, if the drone is still ours."""
        control, self._control, self._holder = self._control, None, None
        if control is not None:
            await control.__aexit__(None, None, None)

    def _is_late(self, order: Velocity | Operation, since: float) -> bool:
        """Return whether an order waited behind others until it was an old one."""
        if isinstance(order, Operation) and order.what in ENDING:
            return False
        waited = asyncio.get_running_loop().time() - since
        if waited > OLDEST:
            self._say(f"an order was not carried out: it waited up to {waited:.1f} s for others")
        return waited > OLDEST

    def _may(self, order: Velocity | Operation) -> bool:
        """Return whether an order's program may give it."""
        if isinstance(order, Operation) or order.publisher == self._holder:
            return True
        if self._holder is not None:
            self._say("another program of ROS 2 flies already: one at a time")
        elif not order.neutral:
            self._say("nobody takes over in full flight: begin with a velocity of zero")
        else:
            # Velocities come many times a second.
            now = asyncio.get_running_loop().time()
            return self._control is not None or now - self._refused >= ASK_AGAIN
        return False

    async def _ask(self) -> AsyncDirectControl:
        """Ask for control.

        Raises:
            WorkbenchError: if it is refused.
        """
        control = self._client.direct_control()
        try:
            await control.__aenter__()
        except WorkbenchError:
            self._refused = asyncio.get_running_loop().time()
            raise
        self._control = control
        self._say("control was granted: a program of ROS 2 flies")
        return control

    async def _carry_out(self, order: Velocity | Operation, control: AsyncDirectControl) -> None:
        if isinstance(order, Velocity):
            if control.scaled:  # of the order before: a refusal takes its time
                self._say(f"flown slower than asked: {control.scaled}")
            control.velocity(*order.in_world(self._yaw()), order.yaw_rate)
            return
        match order.what:
            case "arm":
                await control.arm()
            case "take_off":
                await control.take_off(TAKE_OFF_HEIGHT if order.height is None else order.height)
            case "land":
                await control.land()
            case "stop":
                await control.stop()
        self._say(f"{order.what} was begun")

    def _yaw(self) -> float:
        """Return the heading [rad]."""
        newest = self._client.latest("position_data")
        if newest is None:
            raise WorkbenchError("the drone's heading is not known yet: nothing is flown")
        return float(newest["yaw"])  # type: ignore[arg-type]
