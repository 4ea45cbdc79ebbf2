"""Read messages of other ROS 2 programs from DDS, however they are made."""

from collections.abc import Iterator

from cyclonedds.core import DDSException
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.internal import InvalidSample, SampleInfo
from cyclonedds.qos import Policy
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from workbench.extras.gateways.ros2_dds import (
    WRITER_HISTORY_DEPTH,
    dds_topic,
    endpoint_qos,
    message_type,
)


def make_reader(
    participant: DomainParticipant, topic: DdsTopic | str, type_name: str = "", user_data: str = ""
) -> DataReader:
    """Return a reader of messages of other participants, with the defaults of ROS 2.

    Args:
        participant: of the domain.
        topic: the DDS topic, or the name of a ROS 2 topic.
        type_name: of the messages, for a name.
        user_data: that other programs see with the reader.
    """
    if isinstance(topic, str):
        topic = dds_topic(participant, topic, message_type(type_name))
    policies = [
        Policy.IgnoreLocal.Participant,
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=True),
    ]
    if user_data:
        policies.append(Policy.Userdata(user_data.encode()))
    return DataReader(participant, topic, qos=endpoint_qos(*policies))


def take_messages(reader: DataReader) -> Iterator[tuple[int, IdlStruct | None, str]]:
    """Yield messages of other programs that have arrived; at most as many as are kept.

    Each comes with the number of its program, another one after a restart, and why it cannot be
    read: then it is None, else the reason is "".
    """
    for _ in range(WRITER_HISTORY_DEPTH):
        try:
            taken = reader.take(1)  # one by one, as one may be unreadable
        except (DDSException, UnicodeDecodeError, ValueError) as error:
            yield 0, None, f"a message cannot be read ({error})"
            continue
        if not taken:
            return
        # A program that ends also sends a message; its silence means the same.
        if not isinstance(taken[0], InvalidSample):
            yield _program(reader, taken[0].sample_info), taken[0], ""


def _program(reader: DataReader, info: SampleInfo) -> int:
    """Return a number for the program that wrote a message; it may write to several topics."""
    writer = reader.get_matched_publication_data(info.publication_handle)
    return info.publication_handle if writer is None else writer.participant_key.int
