"""What programs of ROS 2 order: velocities and flight operations, read from DDS."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.internal import InvalidSample, SampleInfo
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader

from workbench.gateways.ros2_publishing import DEPTH, dds_topic
from workbench.gateways.ros2_types import STRING, message_type
from workbench.link.drone_topics import AXES
from workbench.link.topics import PREFIX

CMD_VEL = f"{PREFIX}cmd_vel"
COMMAND_VELOCITY = f"{PREFIX}command_velocity"
FLIGHT_OPERATION = f"{PREFIX}flight_operation"
_HEIGHT = re.compile(r"[0-9]{1,3}(\.[0-9]{0,9})?")


@dataclass(frozen=True)
class Velocity:
    """A velocity that is asked for.

    Attributes:
        publisher: number of the program; one that is started anew has another.
        parts: x, y, z [m/s].
        yaw_rate: about the vertical [rad/s].
        levelled: whether x is forward and y left, as seen from above; else they are those of W.
    """

    publisher: int
    parts: tuple[float, float, float]
    yaw_rate: float
    levelled: bool

    @property
    def neutral(self) -> bool:
        """Whether nothing is to move."""
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
    """Something else that is to be done: arm, take_off (to a height [m]), land or stop."""

    publisher: int
    what: str
    height: float | None


@dataclass(frozen=True)
class Unclear:
    """A message that is no order; a sentence."""

    said: str


Order = Velocity | Operation | Unclear


class Orders:
    """Reads the topics on which programs of ROS 2 order; what the gateway writes is not among it.

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
        """Yield what has arrived; of each topic at most as much as is kept."""
        for name, reader in self._readers:
            for _ in range(DEPTH):
                try:
                    taken = reader.take(1)  # one by one: what cannot be read takes none with it
                except (DDSException, UnicodeDecodeError, ValueError) as error:
                    yield Unclear(f"{name}: a message cannot be read ({error})")
                    continue
                if not taken:
                    break
                # That a program has gone is a message too; its silence says the same.
                if not isinstance(taken[0], InvalidSample):
                    yield order_of(name, taken[0], _program(reader, taken[0].sample_info))


def _program(reader: DataReader, info: SampleInfo) -> int:
    """Return a number of the program that wrote a message: it may write to several topics."""
    writer = reader.get_matched_publication_data(info.publication_handle)
    return info.publication_handle if writer is None else writer.participant_key.int


def order_of(name: str, message: IdlStruct, publisher: int) -> Order:
    """Return what a message orders.

    Args:
        name: of the topic.
        message: as DDS has it.
        publisher: whose it is.
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
        f"{FLIGHT_OPERATION}: {text[:40]!r} is no operation: write arm, take_off, take_off HEIGHT "
        "[m], land or stop"
    )
