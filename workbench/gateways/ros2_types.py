"""Types of Cyclone DDS, made of the definitions of messages, and messages in ROS 2's bytes."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct, types

from workbench.gateways.ros_messages.cdr import Codec
from workbench.gateways.ros_messages.definitions import (
    TEXT,
    Arity,
    Definition,
    MessageField,
    read_definition,
)
from workbench.gateways.ros_messages.library import included, type_names

CLOCK = "rosgraph_msgs/msg/Clock"
STRING = "std_msgs/msg/String"
_PLAIN = {
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
    TEXT: str,
}


class MessageType:
    """A type of message, as DDS and as ROS 2 know it.

    Args:
        definitions: of the type and of all that it includes, the type's own first.

    Attributes:
        name: as ROS 2 has it: std_msgs/msg/Header.
        idl: as Cyclone DDS has it; readers return instances of it.
    """

    def __init__(self, definitions: Sequence[Definition]) -> None:
        self.name = definitions[0].name
        self.idl = _idl({each.name: each for each in definitions}, self.name)
        self._codec = Codec(definitions)

        class Encoded(self.idl):  # type: ignore[name-defined]
            """A message that is bytes already: Cyclone's own encoder is slow."""

            def __init__(self, data: bytes) -> None:
                self.data = data

            def serialize(self, *_: object, **__: object) -> bytes:
                return self.data

        self._encoded = Encoded

    def sample(self, values: Mapping[str, Any]) -> IdlStruct:
        """Return a message as a writer takes it.

        Args:
            values: by field; messages within are mappings themselves.
        """
        return self._encoded(self._codec.encode(values))


@cache
def message_type(name: str) -> MessageType:
    """Return a type by its name, as std_msgs/msg/Header.

    Raises:
        WorkbenchError: if it is not known.
    """
    own = _OURS.get(name)
    if own is None or name in type_names():
        return MessageType(included(name))
    first = read_definition(name, own)
    nested = [each for field in first.fields if field.nested for each in included(field.type)]
    return MessageType((first, *nested))


def dds_name(name: str) -> str:
    """Return what DDS calls a type of ROS 2: std_msgs::msg::dds_::Header_."""
    package, _, plain = name.split("/")
    return f"{package}::msg::dds_::{plain}_"


_OURS = {CLOCK: "builtin_interfaces/Time clock\n", STRING: "string data\n"}
"""Definitions of types that only this gateway uses."""


def _idl(definitions: Mapping[str, Definition], name: str) -> type[IdlStruct]:
    fields = {
        field.name: _several(field, _one(definitions, field)) for field in definitions[name].fields
    }
    plain = name.rpartition("/")[2]
    return make_idl_struct(f"{plain}_", dds_name(name).replace("::", "."), fields)


def _one(definitions: Mapping[str, Definition], field: MessageField) -> Any:
    return _idl(definitions, field.type) if field.nested else _PLAIN[field.type]


def _several(field: MessageField, one: Any) -> Any:
    match field.arity:
        case Arity.ONE:
            return one
        case Arity.FIXED:
            return types.array[one, field.count]
        case Arity.SEQUENCE:
            return types.sequence[one]
