"""DDS for ROS 2: a domain limited to this computer, message types, and topics.

DDS has no login, and by default the whole network can receive it. So the domain of the gateway uses
the loopback interface, and the kernel drops packets to its sockets from any other: Cyclone sends on
the given interface, but receives on all of them.
"""

import ctypes
import os
import socket
import stat
import struct
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from cyclonedds.core import DDSException
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct, make_idl_struct, types
from cyclonedds.qos import Policy, Qos
from cyclonedds.topic import Topic as DdsTopic

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_definitions import included_definitions
from workbench.extras.gateways.ros2_options import LOOPBACK_INTERFACE, interface_names
from workbench.link.ros_messages.cdr import Codec
from workbench.link.ros_messages.definitions import (
    TEXT_TYPE,
    Arity,
    Definition,
    MessageField,
)

WRITER_HISTORY_DEPTH = 10
PARTICIPANT_DATA = b"enclave=/;"
"""By this ROS 2 knows that a participant has nodes."""
_PLAIN_DDS_TYPES = {
    "bool": bool,
    "byte": types.byte,
    "char": types.uint8,
    "uint8": types.uint8,
    "int8": types.int8,
    "uint16": types.uint16,
    "int16": types.int16,
    "uint32": types.uint32,
    "int32": types.int32,
    "uint64": types.uint64,
    "int64": types.int64,
    "float32": types.float32,
    "float64": types.float64,
    TEXT_TYPE: str,
}


class MessageType:
    """A message type in DDS and in ROS 2.

    Args:
        definitions: of the type, first, and of all types included in it.

    Attributes:
        name: in ROS 2, such as std_msgs/msg/Header.
        idl: the type in Cyclone DDS; readers return instances of it.
    """

    def __init__(self, definitions: Sequence[Definition]) -> None:
        self.name = definitions[0].name
        self.idl = _idl({each.name: each for each in definitions}, self.name)
        self._codec = Codec(definitions)

        class Encoded(self.idl):
            """A message already encoded as bytes, as Cyclone's own encoder is slow."""

            def __init__(self, data: bytes) -> None:
                self.data = data

            def serialize(self, *_: object, **__: object) -> bytes:
                return self.data

        self._encoded = Encoded

    def sample(self, values: Mapping[str, Any]) -> IdlStruct:
        """Return a message for a writer.

        Args:
            values: by field; nested messages are mappings.
        """
        return self._encoded(self._codec.encode(values))


@cache
def message_type(name: str) -> MessageType:
    """Return a type by its name, such as std_msgs/msg/Header.

    Raises:
        WorkbenchError: if it is unknown.
    """
    return MessageType(included_definitions(name))


def dds_name(name: str) -> str:
    """Return the DDS name of a ROS 2 type, such as std_msgs::msg::dds_::Header_."""
    package, kind, plain = name.split("/")
    return f"{package}::{kind}::dds_::{plain}_"


def _idl(definitions: Mapping[str, Definition], name: str) -> type[IdlStruct]:
    fields = {
        field.name: _idl_array_type(field, _idl_element_type(definitions, field))
        for field in definitions[name].fields
    }
    plain = name.rpartition("/")[2]
    return make_idl_struct(f"{plain}_", dds_name(name).replace("::", "."), fields)


def _idl_element_type(definitions: Mapping[str, Definition], field: MessageField) -> Any:
    return _idl(definitions, field.type) if field.nested else _PLAIN_DDS_TYPES[field.type]


def _idl_array_type(field: MessageField, one: Any) -> Any:
    match field.arity:
        case Arity.ONE:
            return one
        case Arity.FIXED:
            return types.array[one, field.count]
        case Arity.SEQUENCE:
            return types.sequence[one]


def dds_topic(participant: DomainParticipant, name: str, kind: MessageType) -> DdsTopic:
    """Return the DDS topic of a ROS 2 topic."""
    return DdsTopic(participant, f"rt{name}", kind.idl)


def endpoint_qos(*policies: Any) -> Qos:
    """Return the default quality of service of ROS 2, which every reader matches.

    Best-effort readers match a reliable writer, but not vice versa. A writer does not wait for slow
    readers: samples that do not fit are dropped.

    Args:
        policies: replace the default ones.
    """
    usual = (
        Policy.Reliability.Reliable(0),
        Policy.Durability.Volatile,
        Policy.History.KeepLast(WRITER_HISTORY_DEPTH),
        # ROS 2 uses XCDR1, and readers of XCDR1 get no XCDR2 data, without any error.
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
    )
    replaced = {policy.__scope__ for policy in policies}
    return Qos(*(each for each in usual if each.__scope__ not in replaced), *policies)


def latched_qos() -> Qos:
    """Return the quality of service of a topic whose last message later readers get, too."""
    return endpoint_qos(Policy.Durability.TransientLocal, Policy.History.KeepLast(1))


_ATTACH_FILTER = 26
"""SO_ATTACH_FILTER of Linux, which is missing in `socket`."""
_INTERFACE_INDEX_OFFSET = 0xFFFFF000 + 8
"""Offset at which a filter finds the number of the interface of a packet."""


class DdsDomain:
    """A participant in a domain of DDS, as a context manager.

    Args:
        number: of the domain, 0 to 232.
        interface: name or address of the network interface; "lo" for this computer alone.
        configuration: of Cyclone DDS, in the form of CYCLONEDDS_URI; replaces the interface.

    Raises:
        WorkbenchError: on entering, if the domain cannot be created.
    """

    def __init__(
        self, number: int, interface: str = LOOPBACK_INTERFACE, configuration: str = ""
    ) -> None:
        self._participants: list[DomainParticipant] = []
        self._number = number
        self._closed_in = interface == LOOPBACK_INTERFACE and not configuration
        self._given = bool(configuration)
        self._configuration = configuration or configuration_of(interface)
        self._domain: Domain | None = None

    def __enter__(self) -> "DdsDomain":
        before = _sockets()
        try:
            self._domain = Domain(self._number, self._configuration)
            if self._closed_in:
                # Before there is a participant, incoming packets have no receiver.
                for descriptor in _sockets() - before:
                    accept_only_interface(descriptor, socket.if_nametoindex(LOOPBACK_INTERFACE))
            self.add_participant()
        except DDSException as error:
            self.__exit__(None, None, None)
            raise WorkbenchError(self._failure(error)) from None
        except OSError as error:
            self.__exit__(None, None, None)
            raise WorkbenchError(
                "DDS cannot be kept to this computer, as the system refuses the filter on its "
                f"sockets ({error.strerror or error}); Linux is needed for that"
            ) from None
        return self

    def __exit__(self, *_: object) -> None:
        self._participants.clear()
        self._domain = None

    def _failure(self, error: DDSException) -> str:
        """Return what prevents Cyclone DDS from joining the domain."""
        if self._given:
            return "Cyclone DDS refuses the configuration of --config: its reason stands above"
        return (
            f"DDS domain {self._number} cannot be joined ({error.msg or error}): are there too "
            "many programs in it, and is the interface up?"
        )

    @property
    def participant(self) -> DomainParticipant:
        """The participant for writers and readers."""
        assert self._participants, "the domain is not open"
        return self._participants[0]

    def add_participant(self) -> DomainParticipant:
        """Return a further participant; in one, all endpoints of a topic have the same type."""
        qos = Qos(Policy.Userdata(PARTICIPANT_DATA))
        self._participants.append(DomainParticipant(self._number, qos=qos))
        return self._participants[-1]


def configuration_of(interface: str) -> str:
    """Return a configuration of Cyclone DDS for one network interface.

    On the loopback interface, programs find each other without multicast, by trying the first
    ports, like ROS 2 programs limited to their computer.
    """
    if interface != LOOPBACK_INTERFACE:
        kind = "name" if interface in interface_names() else "address"
        return (
            "<CycloneDDS><Domain><General><Interfaces>"
            f"<NetworkInterface {kind}={quoteattr(interface)}/>"
            "</Interfaces></General></Domain></CycloneDDS>"
        )
    return (
        "<CycloneDDS><Domain>"
        "<General><Interfaces>"
        f'<NetworkInterface name="{LOOPBACK_INTERFACE}"/>'
        "</Interfaces></General>"
        "<Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex>"
        '<Peers><Peer address="127.0.0.1"/></Peers></Discovery>'
        "</Domain></CycloneDDS>"
    )


def accept_only_interface(descriptor: int, interface: int) -> None:
    """Restrict a socket to packets from one interface, given by its number.

    Raises:
        OSError: if the system has no such filters.
    """
    # Load the number of the interface; accept the packet if it matches, else drop it.
    program = b"".join(
        struct.pack("=HBBI", *step)
        for step in (
            (0x20, 0, 0, _INTERFACE_INDEX_OFFSET),
            (0x15, 0, 1, interface),
            (0x06, 0, 0, 0xFFFFFFFF),
            (0x06, 0, 0, 0),
        )
    )
    text = ctypes.create_string_buffer(program, len(program))
    wanted = struct.pack("@HP", 4, ctypes.addressof(text))
    with socket.socket(fileno=os.dup(descriptor)) as ours:
        ours.setsockopt(socket.SOL_SOCKET, _ATTACH_FILTER, wanted)


def _sockets() -> set[int]:
    """Return the file descriptors of the datagram sockets of this process."""
    found = set()
    for number in [int(path.name) for path in Path("/proc/self/fd").iterdir()]:
        try:
            if not stat.S_ISSOCK(os.fstat(number).st_mode):
                continue
            with socket.socket(fileno=os.dup(number)) as each:
                if each.type == socket.SOCK_DGRAM:
                    found.add(number)
        except OSError:  # the descriptor of the listing itself, closed by now
            continue
    return found
