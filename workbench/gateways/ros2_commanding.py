"""Orders from ROS 2 on their way to the drone: one publisher at a time, under the link's lease."""

import asyncio
import math
from collections import deque
from collections.abc import Callable

from workbench.errors import WorkbenchError
from workbench.gateways.ros2_orders import Operation, Order, Unclear, Velocity
from workbench.link import AsyncClient
from workbench.link.control import AsyncControl
from workbench.link.operations import TAKE_OFF_HEIGHT

ASK_AGAIN = 1.0
"""After a refusal, control is not asked for sooner [s]."""
OLDEST = 0.5
"""An order that had to wait longer, while control was asked for, is not carried out [s]."""
MOST_REMEMBERED = 256


class PassedOn(AsyncControl):
    """Controls that pass on what comes and repeat nothing: silence is to reach the drone."""

    def keep_up(self) -> None:
        """Repeat nothing where simulated time runs faster than the clock."""

    async def _repeat(self) -> None:
        """Repeat nothing."""


class Commanding:
    """Asks for control when the first order comes, passes orders on, and says what is refused.

    The first program that sends a velocity has the drone until it is silent and control is lost
    with that; flight operations are taken from any, so that one may land what another flies.
    Nothing resumes by itself: whoever lost control or was refused begins with a velocity of zero.

    Args:
        client: of the link, open.
        say: tells the user a sentence.
    """

    def __init__(self, client: AsyncClient, say: Callable[[str], None]) -> None:
        self._client = client
        self._say = say
        self._control: PassedOn | None = None
        self._holder = 0
        self._to_rest: deque[int] = deque(maxlen=MOST_REMEMBERED)
        self._asked = -math.inf

    async def obey(self, order: Order) -> None:
        """Carry an order out, or say why not."""
        if isinstance(order, Unclear):
            self._say(order.said)
            return
        begin = asyncio.get_running_loop().time()
        try:
            await self.look()
            control = await self._control_for(order)
            if control is None:
                return
            if asyncio.get_running_loop().time() - begin > OLDEST:
                self._say("control was granted too late for the order that asked for it")
                return
            await self._carry_out(order, control)
        except WorkbenchError as error:
            self._say(str(error))

    async def look(self) -> None:
        """Notice that control was lost."""
        if self._control is not None and self._control.lost:
            self._say(f"control was lost: {self._control.lost}; to go on, begin with zero")
            if self._holder:
                self._remember(self._holder)
            await self.release()

    async def release(self) -> None:
        """Give control back, if the drone is still ours."""
        control, self._control, self._holder = self._control, None, 0
        if control is not None:
            await control.__aexit__(None, None, None)

    async def _control_for(self, order: Velocity | Operation) -> PassedOn | None:
        """Return the controls for an order; None where it gets nothing."""
        if isinstance(order, Operation):
            return self._control or await self._ask(order.publisher)
        if self._holder and order.publisher != self._holder:
            self._remember(order.publisher)
            self._say("another program of ROS 2 flies already: one at a time")
            return None
        if order.publisher in self._to_rest and not order.neutral:
            self._say("control was lost or refused before: begin with a velocity of zero")
            return None
        self._control = self._control or await self._ask(order.publisher)
        if self._control is not None:
            self._forget(order.publisher)
            self._holder = order.publisher
        return self._control

    async def _ask(self, publisher: int) -> PassedOn | None:
        """Ask for control; return None if this was refused a moment ago."""
        now = asyncio.get_running_loop().time()
        if now - self._asked < ASK_AGAIN and publisher in self._to_rest:
            return None
        self._asked = now
        self._remember(publisher)  # until it is granted
        control = PassedOn(self._client)
        await control.__aenter__()
        self._forget(publisher)
        self._control = control
        self._say("control was granted: a program of ROS 2 flies")
        return control

    def _forget(self, publisher: int) -> None:
        if publisher in self._to_rest:
            self._to_rest.remove(publisher)

    def _remember(self, publisher: int) -> None:
        if publisher not in self._to_rest:
            self._to_rest.append(publisher)

    async def _carry_out(self, order: Velocity | Operation, control: PassedOn) -> None:
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
