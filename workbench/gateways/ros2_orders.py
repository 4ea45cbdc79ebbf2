"""Orders of ROS 2 programs: read from DDS, and executed under the lease of the link.

Orders are velocities and flight operations. One program flies at a time.
"""

import asyncio
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import cast

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.internal import InvalidSample, SampleInfo
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros2_dds import STRING, message_type
from workbench.gateways.ros2_publishing import DEPTH, dds_topic
from workbench.link import AsyncClient
from workbench.link.control import AsyncControl
from workbench.link.drone_topics import AXES
from workbench.link.messages import TAKE_OFF_HEIGHT
from workbench.link.topics import PREFIX

CMD_VEL = f"{PREFIX}cmd_vel"
COMMAND_VELOCITY = f"{PREFIX}command_velocity"
FLIGHT_OPERATION = f"{PREFIX}flight_operation"
_HEIGHT = re.compile(r"[0-9]{1,3}(\.[0-9]{0,9})?")


@dataclass(frozen=True)
class Velocity:
    """A velocity order.

    Attributes:
        publisher: number of the program; a restarted one has a different number.
        parts: x, y, z [m/s].
        yaw_rate: about the vertical [rad/s].
        levelled: whether x is forward and y left, seen from above; else they are those of W.
    """

    publisher: int
    parts: tuple[float, float, float]
    yaw_rate: float
    levelled: bool

    @property
    def neutral(self) -> bool:
        """Whether all axes are zero."""
        return not any((*self.parts, self.yaw_rate))

    def in_world(self, yaw: float) -> tuple[float, float, float]:
        """Return the velocity in W [m/s] of a drone with this heading [rad]."""
        x, y, z = self.parts
        if not self.levelled:
            return self.parts
        c, s = math.cos(yaw), math.sin(yaw)
        return c * x - s * y, s * x + c * y, z


@dataclass(frozen=True)
class Operation:
    """A flight operation: arm, take_off (to a height [m]), land or stop."""

    publisher: int
    what: str
    height: float | None


@dataclass(frozen=True)
class Unclear:
    """A message that is not a valid order, with a sentence."""

    said: str


Order = Velocity | Operation | Unclear


class Orders:
    """Reads the topics for orders of ROS 2 programs; the gateway does not write to these.

    Args:
        participant: of the domain.
    """

    def __init__(self, participant: DomainParticipant) -> None:
        qos = Qos(
            Policy.Reliability.Reliable(0),
            Policy.Durability.Volatile,
            Policy.History.KeepLast(DEPTH),
            Policy.IgnoreLocal.Participant,
            Policy.DataRepresentation(
                use_cdrv0_representation=True, use_xcdrv2_representation=True
            ),
        )
        self._readers = [
            (name, DataReader(participant, dds_topic(participant, name, kind), qos=qos))
            for name, kind in (
                (CMD_VEL, message_type("geometry_msgs/msg/Twist")),
                (COMMAND_VELOCITY, message_type("dh_drone_msgs/msg/CommandVelocity")),
                (FLIGHT_OPERATION, message_type(STRING)),
            )
        ]

    def take(self) -> Iterator[Order]:
        """Yield orders that have arrived; for each topic at most as many as are kept."""
        for name, reader in self._readers:
            for _ in range(DEPTH):
                try:
                    taken = reader.take(1)  # one by one, as one may be unreadable
                except (DDSException, UnicodeDecodeError, ValueError) as error:
                    yield Unclear(f"{name}: a message cannot be read ({error})")
                    continue
                if not taken:
                    break
                # A program that ends also sends a message; its silence means the same.
                if not isinstance(taken[0], InvalidSample):
                    yield order_of(name, taken[0], _program(reader, taken[0].sample_info))


def _program(reader: DataReader, info: SampleInfo) -> int:
    """Return a number for the program that wrote a message; it may write to several topics."""
    writer = reader.get_matched_publication_data(info.publication_handle)
    return info.publication_handle if writer is None else writer.participant_key.int


def order_of(name: str, message: IdlStruct, publisher: int) -> Order:
    """Return the order in a message.

    Args:
        name: of the topic.
        message: from DDS.
        publisher: number of its program.
    """
    if name == CMD_VEL:
        linear, turn = message.linear, message.angular.z
        return Velocity(publisher, (linear.x, linear.y, linear.z), turn, levelled=True)
    if name == COMMAND_VELOCITY:
        return _masked(message, publisher)
    return _operation(str(message.data), publisher)


def _masked(message: IdlStruct, publisher: int) -> Order:
    """Return the order of a CommandVelocity, with the axes that it does not use at zero."""
    if not 1 <= message.axes <= AXES:
        return Unclear(
            f"{COMMAND_VELOCITY}: axes is {message.axes}: set bits 0 to 3 for those that count, "
            f"{AXES} for all"
        )
    numbers = (message.v_x, message.v_y, message.v_z, message.yaw_rate)
    x, y, z, turn = (
        number if message.axes >> bit & 1 else 0.0 for bit, number in enumerate(numbers)
    )
    return Velocity(publisher, (x, y, z), turn, levelled=False)


def _operation(text: str, publisher: int) -> Order:
    words = text.split()
    match words:
        case ["arm" | "land" | "stop" | "take_off" as what]:
            return Operation(publisher, what, None)
        case ["take_off", number] if _HEIGHT.fullmatch(number):
            return Operation(publisher, "take_off", float(number))
    return Unclear(
        f"{FLIGHT_OPERATION}: {text[:40]!r} is not an operation: write arm, take_off, take_off "
        "HEIGHT [m], land or stop"
    )


ASK_AGAIN = 1.0
"""Time after a rejection before a velocity requests control again [s]."""
OLDEST = 0.5
"""Largest age of an order to be executed [s]."""
ENDING = ("land", "stop")
"""Operations that end a flight, which are executed even if late."""


class Commanding:
    """Requests control when an order comes, passes on orders, and reports rejections.

    The first program that sends a velocity of zero controls the drone until it falls silent, which
    ends its control. So no program takes over with a velocity that is not zero, and nothing resumes
    automatically. Flight operations are accepted from any program, so that one may land a drone
    that another flies.

    Args:
        client: of the link, open.
        say: shows the user a sentence.
    """

    def __init__(self, client: AsyncClient, say: Callable[[str], None]) -> None:
        self._client = client
        self._say = say
        self._control: AsyncControl | None = None
        self._holder: int | None = None
        self._refused = -math.inf

    async def obey(self, order: Order, since: float) -> None:
        """Execute an order, or report why not.

        Args:
            order: the order.
            since: earliest arrival time of the order, by the clock of the loop [s].
        """
        if isinstance(order, Unclear):
            self._say(order.said)
            return
        try:
            await self.look()
            if self._is_late(order, since) or not self._may(order):
                return
            control = self._control or await self._ask()
            if self._is_late(order, since):  # the request took time
                return
            if isinstance(order, Velocity):
                self._holder = order.publisher
            await self._carry_out(order, control)
        except WorkbenchError as error:
            self._say(str(error))

    async def look(self) -> None:
        """Notice that control was lost."""
        if self._control is not None and self._control.lost:
            self._say(f"control was lost: {self._control.lost}; to continue, begin with zero")
            await self.release()

    async def release(self) -> None:
        """Release control, if this client still has it."""
        control, self._control, self._holder = self._control, None, None
        if control is not None:
            await control.__aexit__(None, None, None)

    def _is_late(self, order: Velocity | Operation, since: float) -> bool:
        """Return whether an order has become too old."""
        if isinstance(order, Operation) and order.what in ENDING:
            return False
        waited = asyncio.get_running_loop().time() - since
        if waited > OLDEST:
            self._say(f"an order was not carried out: it waited up to {waited:.1f} s for others")
        return waited > OLDEST

    def _may(self, order: Velocity | Operation) -> bool:
        """Return whether the program of an order may give it."""
        if isinstance(order, Operation) or order.publisher == self._holder:
            return True
        if self._holder is not None:
            self._say("another ROS 2 program flies already: one at a time")
        elif not order.neutral:
            self._say("nobody takes over in full flight: begin with a velocity of zero")
        else:
            # Velocities come many times a second.
            now = asyncio.get_running_loop().time()
            return self._control is not None or now - self._refused >= ASK_AGAIN
        return False

    async def _ask(self) -> AsyncControl:
        """Request control.

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
        self._say("control was granted: a ROS 2 program flies")
        return control

    async def _carry_out(self, order: Velocity | Operation, control: AsyncControl) -> None:
        if isinstance(order, Velocity):
            if control.scaled:  # from the order before, as a rejection takes time
                self._say(f"flown slower than commanded: {control.scaled}")
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
        self._say(f"{order.what} has started")

    def _yaw(self) -> float:
        """Return the heading [rad]."""
        newest = self._client.latest("position_data")
        if newest is None:
            raise WorkbenchError("the drone's heading is not known yet: nothing is flown")
        return float(cast(float, newest["yaw"]))
