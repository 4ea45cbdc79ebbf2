"""Orders of ROS 2 programs: read from DDS, and executed under the lease of the link.

Orders are velocities, flight operations and trajectories of joints. One program flies at a time.
"""

import asyncio
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from cyclonedds.idl import IdlStruct
from cyclonedds.sub import DataReader

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_dds import DdsDomain
from workbench.extras.gateways.ros2_definitions import STRING_TYPE, TRAJECTORY_TYPE
from workbench.extras.gateways.ros2_reading import make_reader, take_messages
from workbench.extras.gateways.ros2_trajectory import TrajectoryOrder, trajectory_order
from workbench.extras.gateways.running import rotors_stopped, set_parameters
from workbench.link import AsyncClient
from workbench.link.control import AsyncControl
from workbench.link.drone_topics import ALL_COMMAND_AXES
from workbench.link.message_json import TAKE_OFF_HEIGHT_M
from workbench.link.ros_messages.making import (
    ROS_BODY_FRAME,
    ROS_MAP_FRAME,
    ROS_ODOM_FRAME,
    ROS_WORLD_FRAME,
)
from workbench.link.ros_messages.namespace import in_namespace
from workbench.link.topics import PREFIX

CMD_VEL_TOPIC = f"{PREFIX}cmd_vel"
COMMAND_VELOCITY_TOPIC = f"{PREFIX}command_velocity"
FLIGHT_OPERATION_TOPIC = f"{PREFIX}flight_operation"
JOINT_TRAJECTORY_TOPIC = f"{PREFIX}joint_trajectory"
"""Names of the topics in the namespace of the shipped drone."""
TWIST_TYPE = "geometry_msgs/msg/Twist"
TWIST_STAMPED_TYPE = "geometry_msgs/msg/TwistStamped"
ORDER_TYPES = (
    (CMD_VEL_TOPIC, TWIST_STAMPED_TYPE),
    (CMD_VEL_TOPIC, TWIST_TYPE),
    (COMMAND_VELOCITY_TOPIC, "dh_drone_msgs/msg/CommandVelocity"),
    (FLIGHT_OPERATION_TOPIC, STRING_TYPE),
    (JOINT_TRAJECTORY_TOPIC, TRAJECTORY_TYPE),
)
"""Topic and type of each kind of order."""
LEVELLED_FRAMES = ("", ROS_BODY_FRAME, "base_footprint", "base_stabilized")
WORLD_FRAMES = (ROS_WORLD_FRAME, ROS_MAP_FRAME, ROS_ODOM_FRAME)
"""Frames of a stamped velocity: of the drone as seen from above, and of the world."""
_HEIGHT_PATTERN = re.compile(r"[0-9]{1,3}(\.[0-9]{0,9})?")


@dataclass(frozen=True)
class VelocityOrder:
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
class OperationOrder:
    """A flight operation: arm, take_off (to a height [m]), hold, land, stop or reset."""

    publisher: int
    what: str
    height: float = TAKE_OFF_HEIGHT_M


FlightOrder = VelocityOrder | OperationOrder
RosOrder = FlightOrder | TrajectoryOrder | str
"""What a message asks for; a sentence for one that is no valid order."""


def order_readers(domain: DdsDomain, namespace: str) -> list[tuple[str, str, DataReader]]:
    """Return name, type and reader of each topic for orders; the gateway does not write to these.

    Args:
        domain: open; `cmd_vel` has two types, so that one has a participant of its own.
        namespace: of the drone, without slashes.
    """
    found = []
    for topic, kind in ORDER_TYPES:
        own = domain.add_participant() if kind == TWIST_TYPE else domain.participant
        name = in_namespace(topic, namespace)
        found.append((name, kind, make_reader(own, name, kind)))
    return found


def take_orders(readers: Sequence[tuple[str, str, DataReader]]) -> Iterator[RosOrder]:
    """Yield orders that have arrived; for each topic at most as many as are kept."""
    for name, kind, reader in readers:
        for publisher, message, error in take_messages(reader):
            order = error or order_of(kind, message, publisher)
            yield f"{name}: {order}" if isinstance(order, str) else order


def order_of(kind: str, message: IdlStruct | None, publisher: int) -> RosOrder:
    """Return the order in a message.

    Args:
        kind: type of the message, one of `ORDER_TYPES`.
        message: from DDS.
        publisher: number of its program.
    """
    content: Any = message
    if kind == TWIST_STAMPED_TYPE:
        return _stamped(content, publisher)
    if kind == TWIST_TYPE:
        return _velocity(content, publisher, levelled=True)
    if kind == TRAJECTORY_TYPE:
        return trajectory_order(content)
    if kind == STRING_TYPE:
        return _operation(str(content.data), publisher)
    return _masked(content, publisher)


def _stamped(message: Any, publisher: int) -> RosOrder:
    """Return the order of a TwistStamped, in the axes of its frame."""
    frame = str(message.header.frame_id).lstrip("/")
    plain = frame.rpartition("/")[2]
    if plain in WORLD_FRAMES:
        return _velocity(message.twist, publisher, levelled=False)
    if plain in LEVELLED_FRAMES:
        return _velocity(message.twist, publisher, levelled=True)
    return (
        f"its frame_id is {frame[:40]!r}: write {ROS_BODY_FRAME} for forward, left and up, or "
        f"{', '.join(WORLD_FRAMES)} for east, north and up"
    )


def _velocity(twist: Any, publisher: int, levelled: bool) -> VelocityOrder:
    linear, turn = twist.linear, twist.angular.z
    return VelocityOrder(publisher, (linear.x, linear.y, linear.z), turn, levelled)


def _masked(message: Any, publisher: int) -> RosOrder:
    """Return the order of a CommandVelocity, with the axes that it does not use at zero."""
    if not 1 <= message.axes <= ALL_COMMAND_AXES:
        return (
            f"axes is {message.axes}: set bits 0 to 3 for those that count, {ALL_COMMAND_AXES} "
            "for all"
        )
    numbers = (message.v_x, message.v_y, message.v_z, message.yaw_rate)
    x, y, z, turn = (
        number if message.axes >> bit & 1 else 0.0 for bit, number in enumerate(numbers)
    )
    return VelocityOrder(publisher, (x, y, z), turn, levelled=False)


def _operation(text: str, publisher: int) -> RosOrder:
    words = text.split()
    match words:
        case ["arm" | "hold" | "land" | "stop" | "take_off" as what]:
            return OperationOrder(publisher, what)
        case ["take_off", number] if _HEIGHT_PATTERN.fullmatch(number):
            return OperationOrder(publisher, "take_off", float(number))
    return (
        f"{text[:40]!r} is not an operation: write arm, take_off, take_off HEIGHT [m], hold, land "
        "or stop"
    )


CONTROL_RETRY_S = 1.0
"""Time after a rejection before a velocity requests control again [s]."""
MAX_ORDER_AGE_S = 0.5
"""Largest age of an order to be executed [s]."""
ENDING_OPERATIONS = ("land", "stop")
"""Operations that end a flight, which are executed even if late."""


class OrderExecutor:
    """Requests control when an order comes, passes on orders, and reports rejections.

    The first program that sends a velocity of zero controls the drone until it falls silent, which
    ends its control. So no program takes over with a velocity that is not zero, and nothing resumes
    automatically. Flight operations are accepted from any program, so that one may land a drone
    that another flies. Control that a service obtained is kept until the rotors stop, as a service
    is called once, or until a program sends a velocity. One task calls all methods, one at a time.

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
        self._operated = -math.inf  # start of the last operation of a service, simulated [s]
        self._kept = False  # whether control is kept even if the rotors stand still

    async def execute(self, order: FlightOrder | str, since: float) -> None:
        """Execute an order, or report why not.

        Args:
            order: the order, or the sentence why it is none.
            since: earliest arrival time of the order, by the clock of the loop [s].
        """
        if isinstance(order, str):
            self._say(order)
            return
        try:
            await self.look()
            if self._is_late(order, since) or not self._may(order):
                return
            control = self._control or await self._ask()
            if self._is_late(order, since):  # the request took time
                return
            if isinstance(order, VelocityOrder):
                self._holder = order.publisher
            await self._carry_out(order, control)
        except WorkbenchError as error:
            self._say(str(error))

    async def operate(self, what: str) -> str:
        """Do a flight operation, and return the sentence for the one who requested it.

        Raises:
            WorkbenchError: if it is refused.
        """
        await self.look()
        control = self._control or await self._ask(keeps=True)
        self._operated = await control.request(what)
        if what == "reset":
            control.lose("the flight has started again")
            await self.release()
            return "the flight has started again"
        self._say(f"{what} has started")
        return f"{what} has started at {self._operated:g} s"

    async def set(self, values: Mapping[str, float]) -> None:
        """Set live parameters, all or none.

        Raises:
            WorkbenchError: if it is refused.
        """
        await self.look()
        await set_parameters(self._client, self._control, values)

    async def keep_control(self) -> None:
        """Request control if this client does not have it, and keep it until `end_keeping`.

        Raises:
            WorkbenchError: if it is refused.
        """
        await self.look()
        if self._control is None:
            await self._ask(keeps=True)
        self._kept = True

    def end_keeping(self, now: float) -> None:
        """Keep control from a simulated time [s] on as for a service, until the rotors stop."""
        if self._kept:
            self._kept, self._operated = False, now

    async def set_with_control(self, values: Mapping[str, float]) -> None:
        """Set live parameters, all or none, with control that was kept.

        Raises:
            WorkbenchError: if it is refused, or control was lost.
        """
        await self.look()
        if self._control is None:
            raise WorkbenchError("this gateway has no control of the flight any more")
        await self._control.set(**values)

    async def look(self) -> None:
        """Notice that control was lost, or that a service no longer needs it."""
        control = self._control
        if control is not None and control.lost:
            self._say(f"control was lost: {control.lost}; to continue, begin with zero")
            await self.release()
        elif (
            control is not None
            and control.repeats
            and not self._kept
            and rotors_stopped(self._client, self._operated)
        ):
            self._say("control was released, as the rotors stand still")
            await self.release()

    async def release(self) -> None:
        """Release control, if this client still has it."""
        control, self._control, self._holder = self._control, None, None
        if control is not None:
            await control.__aexit__(None, None, None)

    def _is_late(self, order: FlightOrder, since: float) -> bool:
        """Return whether an order has become too old."""
        if isinstance(order, OperationOrder) and order.what in ENDING_OPERATIONS:
            return False
        waited = asyncio.get_running_loop().time() - since
        if waited > MAX_ORDER_AGE_S:
            self._say(f"an order was not carried out: it waited up to {waited:.1f} s for others")
        return waited > MAX_ORDER_AGE_S

    def _may(self, order: FlightOrder) -> bool:
        """Return whether the program of an order may give it."""
        if isinstance(order, OperationOrder) or order.publisher == self._holder:
            return True
        if self._holder is not None:
            self._say("another ROS 2 program flies already: one at a time")
        elif not order.neutral:
            self._say("nobody takes over in full flight: begin with a velocity of zero")
        else:
            # Velocities come many times a second.
            now = asyncio.get_running_loop().time()
            return self._control is not None or now - self._refused >= CONTROL_RETRY_S
        return False

    async def _ask(self, keeps: bool = False) -> AsyncControl:
        """Request control.

        Args:
            keeps: whether it is kept without velocities.

        Raises:
            WorkbenchError: if it is refused.
        """
        control = self._client.control() if keeps else self._client.direct_control()
        try:
            await control.__aenter__()
        except WorkbenchError:
            self._refused = asyncio.get_running_loop().time()
            raise
        self._control = control
        self._say("control was granted: a ROS 2 program flies")
        return control

    async def _carry_out(self, order: FlightOrder, control: AsyncControl) -> None:
        if isinstance(order, VelocityOrder):
            control.stop_repeating()  # from now on its silence counts
            if control.scaled:  # from the order before, as a rejection takes time
                self._say(f"flown slower than commanded: {control.scaled}")
            control.velocity(*order.in_world(self._yaw()), order.yaw_rate)
            return
        await control.request(order.what, order.height)
        self._say(f"{order.what} has started")

    def _yaw(self) -> float:
        """Return the heading [rad]."""
        newest = self._client.latest("position_data")
        if newest is None:
            raise WorkbenchError("the drone's heading is not known yet: nothing is flown")
        return float(cast(float, newest["yaw"]))
